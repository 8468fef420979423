/* Owen's nested uniform scrambling in base 2 as a hash in which each bit flips by a function of the bits above it and
 * of a random key: Laine and Karras 2011, "Stratified sampling for stochastic transparency"; the constants are
 * Vegdahl's (2021, "Building a better LK hash").
 *
 * How uniform it is. Nested scrambling flips the first three digits in 2^1 2^2 2^4 = 128 ways (a bit for the first, one
 * for each value of the digits before for the second and third). With the random bits of the key all 128 are equally
 * likely here, exactly. That needs what those papers' hashes lack: a sum and an exclusive or, both random, on the two
 * sides of a product by a random even number, which together are no affine map; sums and products alone reach 32 of
 * the 128. Of the 2^15 ways of four digits 4,608 are reached, as no step makes the product of three digits; each by
 * itself, and any pair, is uniform. The tests hold the figures. */
#ifndef ASC_OWEN_H
#define ASC_OWEN_H

#include "bits.h"

/* What the hash takes from 64 random bits. */
typedef struct asc_owen_key {
  uint32_t added, turned, factor, added_later;
} asc_owen_key;

ASC_INLINE asc_owen_key asc_owen_key_of(uint64_t bits) {
  return (asc_owen_key){(uint32_t)bits, (uint32_t)(bits >> 32), (uint32_t)(bits >> 16) & ~1u, (uint32_t)(bits >> 24)};
}

/* It acts on bits with the leading one lowest, as are those of the result: there multiplications and additions carry
 * from the leading digits to those below. */
ASC_INLINE uint32_t asc_owen_reversed(uint32_t x, asc_owen_key key) {
  x += key.added;
  x ^= x * 0x3d20adeau;
  x ^= key.turned;
  x ^= x * key.factor;
  x += key.added_later;
  x ^= x * 0x05526c56u;
  return x ^ x * 0x53a22864u;
}

/* The same, but that the result has its leading bit on top. */
ASC_INLINE uint32_t asc_owen_hash(uint32_t reversed, uint64_t bits) {
  return asc_reverse_bits(asc_owen_reversed(reversed, asc_owen_key_of(bits)));
}

/* Constants of owen_four.h, in memory: the compiler would make each in three steps at each use. */
typedef struct asc_owen_constants {
  uint64_t draw[2][4], draw_high[2][4]; /* the multipliers of SplitMix64, and their high words */
  uint64_t factor[3][4], even[4];
  uint64_t nibbles[4], nibble_low[4], nibble_high[4];
  uint64_t one[4];
} asc_owen_constants;
extern const asc_owen_constants asc_owen;

#endif

/* Owen's nested uniform scrambling in base 2 as it was defined: Owen 1995, "Randomly permuted (t,m,s)-nets and
 * (t,s)-sequences". Each digit flips by a coin of its own for every value of the digits before it, so that all flips of
 * a dimension, 2^32 - 1 for 32 digits, are independent: of four digits all 2^15 ways are reached, where the hash of
 * owen.h reaches 4,608.
 *
 * A coin is a function of the key, the dimension and those digits. They are drawn 63 at a time, the bits of one draw
 * being the coins of six levels under one prefix: bit 1 the first digit's there, bits 2 and 3 the second's, and so on;
 * six draws make a value of 32 digits. */
#ifndef ASC_OWEN_FULL_H
#define ASC_OWEN_FULL_H

#include "hash.h"
#include "vectorise.h"

#define ASC_OWEN_FULL_LEVELS 6u

/* Before loops of at most six steps inside one over lanes: unrolled, they leave that one to be vectorised. */
#if defined(__GNUC__) && !defined(__clang__)
#define ASC_UNROLLED _Pragma("GCC unroll 6")
#else
#define ASC_UNROLLED
#endif

/* Bits with the leading one on top; `start`: 64 random bits of a dimension and pixel. The numbers of nodes, 1 before
 * the first digit, then 2 and 3, are those of the sequence that begins at `start`. */
ASC_INLINE uint32_t asc_owen_full(uint32_t x, uint64_t start) {
  const uint64_t digits = UINT64_C(1) << 36 | (uint64_t)x << 4; /* of 36 levels, the last four for nothing */
  uint64_t flips = 0;
  ASC_UNROLLED
  for (uint32_t done = 0; done < 36; done += ASC_OWEN_FULL_LEVELS) {
    const uint64_t coins = asc_draw_at(start, digits >> (36 - done));
    ASC_UNROLLED
    for (uint32_t level = 0; level < ASC_OWEN_FULL_LEVELS; level++) {
      const uint64_t leading = UINT64_C(1) << level, below = digits >> (36 - done - level) & (leading - 1);
      flips |= (coins >> (leading | below) & 1u) << (35 - done - level);
    }
  }
  return x ^ (uint32_t)(flips >> 4);
}

#endif

/* Owen's nested uniform scrambling in base 2 as a hash in which each bit flips by a function of the bits above it and
 * of the seed: Laine and Karras 2011, "Stratified sampling for stochastic transparency", with Vegdahl's constants
 * (2021, "Building a better LK hash"). */
#ifndef ASC_OWEN_H
#define ASC_OWEN_H

#include "vectorise.h"

#include <stdint.h>

ASC_INLINE uint32_t asc_reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
  return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/* One of the ASC_OWEN_STEPS of the hash. They act on bits with the leading one lowest, where multiplications and
 * additions carry from the leading digits to those below. */
#define ASC_OWEN_STEPS 4
ASC_INLINE uint32_t asc_owen_step(int step, uint32_t x, uint32_t seed) {
  switch (step) {
  case 0: return (x ^ x * 0x3d20adeau) + seed;
  case 1: return x * ((seed >> 16) | 1u);
  case 2: return x ^ x * 0x05526c56u;
  default: return x ^ x * 0x53a22864u;
  }
}

/* `reversed`: the bits with the leading one lowest; the result has it on top. */
ASC_INLINE uint32_t asc_owen_hash(uint32_t reversed, uint32_t seed) {
  for (int step = 0; step < ASC_OWEN_STEPS; step++) reversed = asc_owen_step(step, reversed, seed);
  return asc_reverse_bits(reversed);
}

#endif

/* Owen's nested uniform scrambling in base 2 as a hash in which each bit flips by a function of the bits above it and
 * of the seed: Laine and Karras 2011, "Stratified sampling for stochastic transparency", with Vegdahl's constants
 * (2021, "Building a better LK hash"). */
#ifndef ASC_OWEN_H
#define ASC_OWEN_H

#include "vectorise.h"

#include <stdint.h>

ASC_INLINE uint32_t asc_reverse_bits(uint32_t x) {
  x = (x >> 24) | ((x >> 8) & 0xff00u) | ((x << 8) & 0xff0000u) | (x << 24);
  x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
  return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/* `reversed`: the bits with the leading one lowest, where multiplications and additions carry from the leading digits
 * to those below. The result has its leading bit on top. */
ASC_INLINE uint32_t asc_owen_hash(uint32_t reversed, uint32_t seed) {
  uint32_t x = reversed;
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return asc_reverse_bits(x);
}

#endif

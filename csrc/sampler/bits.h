/* Digits in base 2. */
#ifndef ASC_BITS_H
#define ASC_BITS_H

#include "vectorise.h"

#include <stdint.h>
#include <string.h>

ASC_INLINE uint32_t asc_reverse_bits(uint32_t x) {
  x = __builtin_bswap32(x);
  x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
  return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/* A word to [0, 1): as the fraction of a number in [1, 2), less 1; quicker than the conversion, and as exact. */
ASC_INLINE double asc_unit_of_bits(uint32_t bits) {
  const uint64_t pattern = 0x3ff0000000000000u | ((uint64_t)bits << 20);
  double x;
  memcpy(&x, &pattern, sizeof x);
  return x - 1.0;
}

#endif

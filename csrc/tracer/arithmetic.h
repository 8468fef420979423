/* What loops over samples need of the elementary functions: steps that compilers vectorise, with the same bits on every
 * machine. */
#ifndef TRACER_ARITHMETIC_H
#define TRACER_ARITHMETIC_H

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rows.h"
#include "vectorise.h"

/* The largest argument, for which the number of half turns has 19 bits. */
#define HAVERCOSINE_MOST 1.6e6

/* (1 + cos x) / 2, for |x| up to HAVERCOSINE_MOST: within 3e-16.
 *
 * Source: Cody and Waite 1980, "Software manual for the elementary functions", chapter 8: the nearest number of half
 * turns, times pi in two parts, is taken off. The product with the first part, of 33 bits, is exact, and so is that
 * difference. What is left is a quarter of a turn at most; its series in the square is that with the least largest
 * error, 2.1e-18 (Remez' exchange). */
ASC_INLINE double havercosine(double x) {
  static const double half_turn[] = {0x1.921fb544p+1, 0x1.0b4611a626331p-33};
  static const double whole = 0x1.8p52; /* numbers near it are whole, and their lowest bits are those of an integer */
  static const double series[] = {-0x1.ffffffffffffdp-3,  0x1.555555555540ap-6,   -0x1.6c16c16c0b21dp-11,
                                  0x1.a01a0199c923cp-17,  -0x1.27e4f9915e916p-23, 0x1.1eece489e8b6cp-30,
                                  -0x1.9351e11e36d5dp-38, 0x1.9f42233f261dcp-46};
  const double shifted = x * (1.0 / ASC_PI) + whole, n = shifted - whole;
  const double rest = (x - n * half_turn[0]) - n * half_turn[1], square = rest * rest;
  double twos[4]; /* halved twice, as steps of one long sum would wait for each other (Estrin's scheme) */
  for (size_t k = 0; k < 4; k++) twos[k] = series[2 * k] + series[2 * k + 1] * square;
  const double fourth = square * square, eighth = fourth * fourth;
  const double sum = (twos[0] + twos[1] * fourth) + (twos[2] + twos[3] * fourth) * eighth;
  const double half_cosine = 0.5 + square * sum;
  uint64_t turns, bits;
  memcpy(&turns, &shifted, sizeof turns);
  memcpy(&bits, &half_cosine, sizeof bits);
  bits ^= turns << 63; /* of an odd number of half turns the cosine has the other sign */
  double turned;
  memcpy(&turned, &bits, sizeof turned);
  return 0.5 + turned;
}

/* Beyond, by the C library's. */
static inline double havercosine_of_any(double x) {
  return fabs(x) <= HAVERCOSINE_MOST ? havercosine(x) : 0.5 * (1.0 + cos(x));
}

#endif

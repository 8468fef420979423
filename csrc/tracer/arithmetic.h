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

/* log(of) + correction, for a normal number `of`, the correction being small beside it.
 *
 * Source: the scheme of Sun's fdlibm, e_log.c: with of = 2^k (1 + f), sqrt(1/2) <= 1 + f < sqrt(2), and s = f / (2 +
 * f), log(1 + f) = 2 s + s R(s^2); the series of R has a largest error of 1.3e-18 of the logarithm (Remez' exchange).
 */
ASC_INLINE double corrected_log(double of, double correction) {
  static const double ln2[] = {0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45}; /* in two parts, the first of 42 bits */
  static const double series[] = {0x1.5555555555592p-1, 0x1.999999997fd7ap-2, 0x1.24924941f4e05p-2,
                                  0x1.c71c520615df0p-3, 0x1.74663fa079f29p-3, 0x1.39a1a70c45ccep-3,
                                  0x1.2f0634597d8e3p-3};
  static const uint64_t half_root = 0x3fe6a09e667f3bcd, one = 0x3ff0000000000000; /* sqrt(1/2), 1 */
  static const uint64_t digits = 0x000fffffffffffff, whole = 0x4330000000000000;  /* the latter: 2^52 */
  uint64_t bits;
  memcpy(&bits, &of, sizeof bits);
  const uint64_t moved = bits + (one - half_root), near_one = (moved & digits) + half_root, power = moved >> 52 | whole;
  double scaled, k;
  memcpy(&scaled, &near_one, sizeof scaled);
  memcpy(&k, &power, sizeof k);
  k -= 0x1p52 + 1023.0;
  const double f = scaled - 1.0, s = f / (2.0 + f), z = s * s;
  double sum = series[6];
  for (int i = 5; i >= 0; i--) sum = sum * z + series[i];
  const double half_square = 0.5 * f * f;
  return k * ln2[0] - ((half_square - (s * (half_square + sum * z) + (k * ln2[1] + correction))) - f);
}

/* log(1 + x), for -1 <= x <= 0, where it is -infinity at -1: off by no more than 2e-16 of it. */
ASC_INLINE double log_of_one_plus(double x) {
  const double sum = 1.0 + x;
  const int there = sum > 0.0;
  const double of = there ? sum : 1.0;
  const double found = corrected_log(of, (x - (of - 1.0)) / of); /* what `sum` lost */
  return there ? found : -INFINITY;
}

/* 2^k and e^r - 1 with x = k log(2) + r and |r| <= log(2) / 2, for |x| <= 708. The series' largest error is 2.7e-19 of
 * the latter (Remez' exchange). */
ASC_INLINE double reduced_exponential(double x, double *power) {
  static const double ln2[] = {0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45};
  static const double whole = 0x1.8p52;
  static const double series[] = {0x1.0000000000000p-1,  0x1.5555555555559p-3,  0x1.555555555555ap-5,
                                  0x1.111111110f6c1p-7,  0x1.6c16c16c14488p-10, 0x1.a01a01afdea3bp-13,
                                  0x1.a01a01b0a867fp-16, 0x1.71ddf862abd16p-19, 0x1.27e4c5bc1dc18p-22,
                                  0x1.af5ea69abafe6p-26, 0x1.1f953de250d1dp-29};
  const double shifted = x * 0x1.71547652b82fep+0 + whole, k = shifted - whole;
  const double r = (x - k * ln2[0]) - k * ln2[1];
  uint64_t bits;
  memcpy(&bits, &shifted, sizeof bits);
  bits = (bits + 1023) << 52;
  memcpy(power, &bits, sizeof bits);
  double sum = series[10];
  for (int i = 9; i >= 0; i--) sum = sum * r + series[i];
  return r + r * r * sum;
}

/* e^x - 1, for x <= 0: off by no more than 2.5e-16 of it. */
ASC_INLINE double exponential_less_one(double x) {
  double power;
  const double grown = reduced_exponential(x > -60.0 ? x : -60.0, &power);
  return power * grown + (power - 1.0);
}

/* base^exponent, for 0 < base <= 1 and exponent >= 0: off by no more than 3e-16 (1 + |log|) of it, `log` being its
 * logarithm; 0 where it is below e^-700. For a base that is itself rounded, whose error grows with the exponent, that
 * is not much. */
ASC_INLINE double power_of_fraction(double base, double exponent) {
  const double logarithm = exponent * corrected_log(base, 0.0);
  double power;
  const double grown = reduced_exponential(logarithm > -700.0 ? logarithm : -700.0, &power);
  return logarithm > -700.0 ? power + power * grown : 0.0;
}

#endif

/* A cosine and a quotient for loops that compilers vectorise, with the same bits on every machine. */
#ifndef TRACER_ARITHMETIC_H
#define TRACER_ARITHMETIC_H

#include <stdint.h>
#include <string.h>

#include "concentric.h"
#include "vectorise.h"

/* The largest argument, for which the number of quarter turns has 20 bits. */
#define COSINE_MOST 1.6e6

/* For |x| up to COSINE_MOST: within 2e-16 of the cosine, and off by no more than 4e-16 of it.
 *
 * Source: Cody and Waite 1980, "Software manual for the elementary functions", chapter 8: the nearest number of quarter
 * turns, times pi/2 in parts of 33 bits, is taken off a part at a time. Its products with those are exact, and so is
 * each difference whose digits cancel. */
ASC_INLINE double cosine(double x) {
  /* pi/2, its digits cut after 33 bits three times, and the rest. */
  static const double quarter[] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2ep-69, 0x1.b839a252049c1p-104};
  static const double whole = 0x1.8p52; /* numbers near it are whole, and their lowest bits are those of an integer */
  const double shifted = x * (2.0 / ASC_PI) + whole;
  uint64_t turns;
  memcpy(&turns, &shifted, sizeof turns);
  const double n = shifted - whole;
  const double rest = (((x - n * quarter[0]) - n * quarter[1]) - n * quarter[2]) - n * quarter[3];
  double sine, even;
  asc_eighth_turn(rest, &sine, &even);
  const double value = turns & 1 ? sine : even;
  return (turns + 1) & 2 ? -value : value;
}

/* Beyond, the C library's. */
static inline double cosine_of_any(double x) { return fabs(x) <= COSINE_MOST ? cosine(x) : cos(x); }

/* a / size, correctly rounded, where dividing takes as long as twenty other steps: for a whole number `size` of at most
 * 14 bits. The quotient by the reciprocal is off by little, and what is left of `a` is exact: so are the products with
 * the halves of the quotient's digits, and both differences. No quotient lies so near the middle of two numbers that
 * the last sum could be rounded to the wrong one: that takes a distance below 2^-52 of a digit, and it is at least
 * 2^-15. */
ASC_INLINE double quotient(double a, double size, double reciprocal) {
  const double near = a * reciprocal;
  uint64_t bits;
  memcpy(&bits, &near, sizeof bits);
  bits &= ~(uint64_t)0 << 27;
  double high;
  memcpy(&high, &bits, sizeof high);
  const double left = (a - high * size) - (near - high) * size;
  return near + left * reciprocal;
}

#endif

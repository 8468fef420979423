/* Numbers that keep what rounding takes off: discrepancies far below their terms are differences of such.
 *
 * Dekker 1971, "A floating-point technique for extending the available precision"; Knuth's two-sum. A `kept` is the sum
 * of its parts, `lost` being up to about 2^-53 of `value`; what is lost of `lost` itself is let go. */
#ifndef ASC_KEPT_H
#define ASC_KEPT_H

#include <math.h>
#include <stddef.h>

#include "vectorise.h"

typedef struct asc_kept {
  double value, lost;
} asc_kept;

/* larger - smaller, for 0 <= smaller <= larger. */
ASC_INLINE asc_kept asc_kept_difference(double larger, double smaller) {
  const double value = larger - smaller;
  return (asc_kept){value, (larger - value) - smaller};
}

ASC_INLINE asc_kept asc_kept_sum(double a, double b) {
  const double value = a + b, from_b = value - a;
  return (asc_kept){value, (a - (value - from_b)) + (b - from_b)};
}

/* The fused step tells what a product lost without rounding, so its bits are the same on machines without one. */
ASC_INLINE asc_kept asc_kept_product(asc_kept a, asc_kept b) {
  const double value = a.value * b.value;
  return (asc_kept){value, fma(a.value, b.value, -value) + (a.value * b.lost + a.lost * b.value)};
}

/* A sum that is not of one size on its way, in long double (Neumaier 1974). */
typedef struct asc_kept_long {
  long double value, lost;
} asc_kept_long;

static inline void asc_kept_add(asc_kept_long *to, long double term) {
  const long double sum = to->value + term;
  to->lost += fabsl(to->value) >= fabsl(term) ? (to->value - sum) + term : (term - sum) + to->value;
  to->value = sum;
}

static inline long double asc_kept_value(const asc_kept_long *of) { return of->value + of->lost; }

/* The sum of numbers in so many parts, which can be vectorised with the same bits everywhere. */
#define ASC_KEPT_PARTS 8

ASC_INLINE asc_kept asc_kept_total(const double *values, const double *lost, size_t count) {
  double parts[ASC_KEPT_PARTS] = {0.0}, rests[ASC_KEPT_PARTS] = {0.0};
  for (size_t j = 0; j < count; j += ASC_KEPT_PARTS)
    for (size_t p = 0; p < ASC_KEPT_PARTS; p++) {
      const asc_kept sum = asc_kept_sum(parts[p], values[j + p]);
      parts[p] = sum.value;
      rests[p] += sum.lost + lost[j + p];
    }
  asc_kept whole = {parts[0], rests[0]};
  for (size_t p = 1; p < ASC_KEPT_PARTS; p++) {
    const asc_kept sum = asc_kept_sum(whole.value, parts[p]);
    whole = (asc_kept){sum.value, whole.lost + (sum.lost + rests[p])};
  }
  return whole;
}

#endif

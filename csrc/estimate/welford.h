/* One step of the recurrence of moments.c, for those that add values of several channels. */
#ifndef ASC_WELFORD_H
#define ASC_WELFORD_H

#include "aliascope/estimate.h"

/* A value that is not finite, or too far from the first for its square, leaves `squares` not finite for good. */
static inline void asc_moments_push(asc_moments *to, double value) {
  if (to->count == 0) to->origin = value;
  const double x = value - to->origin;
  const double step = x - to->mean;
  to->mean += step / (double)++to->count;
  to->squares += step * (x - to->mean);
}

#endif

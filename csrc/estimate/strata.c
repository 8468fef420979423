/* The mean of a domain in parts, and its standard error. estimate.h has the formulas. */
#include <math.h>
#include <stdlib.h>

#include "aliascope/estimate.h"

/* A variance that is a sum of independent estimates, each with its degrees of freedom. In long double, as the square of
 * a variance may be beyond a double. */
typedef struct pooled {
  long double variance, degrees;
  long double spread; /* the sum of variance^2/degrees of the parts */
} pooled;

static void pool(pooled *to, long double variance, double degrees) {
  to->variance += variance;
  to->degrees += degrees;
  to->spread += variance * variance / degrees;
}

/* A stratum of one value. */
typedef struct lone_stratum {
  double size, value;
} lone_stratum;

/* `count` strata of one value each, 2 or 3. What is squared is how their weighted values differ from the first: where
 * shares are alike, by the difference of the values alone, which keeps its digits far from 0. */
static void collapse(pooled *to, const lone_stratum *strata, size_t count, double whole) {
  long double differences[3] = {0.0L}, mean = 0.0L, squares = 0.0L;
  for (size_t i = 1; i < count; i++) {
    const long double apart = (long double)strata[i].value - strata[0].value;
    const long double larger = (long double)strata[i].size - strata[0].size;
    differences[i] = (strata[i].size * apart + larger * strata[0].value) / whole;
    mean += differences[i] / (long double)count;
  }
  for (size_t i = 0; i < count; i++) squares += (differences[i] - mean) * (differences[i] - mean);
  const double size = (double)count;
  pool(to, size / (size - 1.0) * squares, size - 1.0);
}

static asc_status whole_size(const asc_stratum *strata, size_t count, double *whole) {
  *whole = 0.0;
  for (size_t j = 0; j < count; j++) {
    if (!(strata[j].size > 0.0) || strata[j].moments.count == 0) return ASC_INVALID_ARGUMENT;
    *whole += strata[j].size;
  }
  return isfinite(*whole) ? ASC_OK : ASC_INVALID_ARGUMENT;
}

asc_status asc_stratify(const asc_stratum *strata, size_t count, asc_stratified *made) {
  if (!strata || !made || count == 0) return ASC_INVALID_ARGUMENT;
  double whole;
  const asc_status status = whole_size(strata, count, &whole);
  if (status) return status;
  lone_stratum *lone = malloc(count * sizeof *lone);
  if (!lone) return ASC_OUT_OF_MEMORY;
  size_t alone = 0;
  pooled sum = {0};
  double mean = 0.0;
  for (size_t j = 0; j < count; j++) {
    asc_moments_summary summary;
    (void)asc_moments_summarise(&strata[j].moments, &summary);
    const double share = strata[j].size / whole;
    mean += share * summary.mean;
    if (summary.count > 1)
      pool(&sum, (long double)share * share * summary.variance / (double)summary.count, (double)summary.count - 1.0);
    else
      lone[alone++] = (lone_stratum){strata[j].size, summary.mean};
  }
  for (size_t i = 0; i + 1 < alone; i += 2) {
    const size_t together = alone - i == 3 ? 3 : 2;
    collapse(&sum, lone + i, together, whole);
    if (together == 3) break;
  }
  free(lone);
  const double standard_error = (double)sqrtl(sum.variance);
  if (!isfinite(mean) || !isfinite(standard_error)) return ASC_NUMERIC;
  const int known = alone != 1;
  *made = (asc_stratified){mean, known ? standard_error : NAN, NAN};
  /* Where all variances are 0 every part counts alike. */
  if (known) made->degrees = (double)(sum.spread > 0.0L ? sum.variance * sum.variance / sum.spread : sum.degrees);
  return ASC_OK;
}

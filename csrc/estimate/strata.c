/* The mean of a domain in parts, and its standard error. estimate.h has the formulas. */
#include <math.h>
#include <stdlib.h>

#include "aliascope/estimate.h"

/* A variance that is a sum of independent estimates, each with its degrees of freedom. */
typedef struct pooled {
  double variance, degrees;
  double spread; /* the sum of variance^2/degrees of the parts */
} pooled;

static void pool(pooled *to, double variance, double degrees) {
  to->variance += variance;
  to->degrees += degrees;
  to->spread += variance * variance / degrees;
}

/* Strata of one value each, `count` of them, 2 or more: their weighted values in `shares`. */
static void collapse(pooled *to, const double *shares, size_t count) {
  asc_moments moments = {0};
  (void)asc_moments_add(&moments, shares, count);
  const double size = (double)count;
  pool(to, size / (size - 1.0) * moments.squares, size - 1.0);
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
  double *lone = malloc(count * sizeof *lone); /* weighted values of the strata that have one */
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
      pool(&sum, share * share * summary.variance / (double)summary.count, (double)summary.count - 1.0);
    else
      lone[alone++] = share * summary.mean;
  }
  for (size_t i = 0; i + 1 < alone; i += 2) {
    const size_t together = alone - i == 3 ? 3 : 2;
    collapse(&sum, lone + i, together);
    if (together == 3) break;
  }
  free(lone);
  if (!isfinite(mean) || !isfinite(sum.variance)) return ASC_NUMERIC;
  const int known = alone != 1;
  *made = (asc_stratified){mean, known ? sqrt(sum.variance) : NAN, NAN};
  /* Where all variances are 0, or their squares underflow, every part counts alike. */
  if (known) made->degrees = sum.spread > 0.0 ? sum.variance * sum.variance / sum.spread : sum.degrees;
  return ASC_OK;
}

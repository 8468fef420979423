/* Mean and variance of values that come one after the other.
 *
 * Welford 1962, "Note on a method for calculating corrected sums of squares and products", on x - origin: the
 * difference of two near values is exact, so what is left to round is as small as the values' spread, not as large as
 * they are. Chan, Golub and LeVeque 1979, "Updating formulae and a pairwise algorithm for computing sample variances",
 * eq. 2.1. */
#include <math.h>

#include "welford.h"

asc_status asc_moments_add(asc_moments *to, const double *values, size_t n) {
  if (!to || (!values && n)) return ASC_INVALID_ARGUMENT;
  asc_moments made = *to;
  for (size_t i = 0; i < n; i++) asc_moments_push(&made, values[i]);
  if (!isfinite(made.squares)) return ASC_NUMERIC;
  *to = made;
  return ASC_OK;
}

asc_status asc_moments_merge(asc_moments *to, const asc_moments *from) {
  if (!to || !from) return ASC_INVALID_ARGUMENT;
  if (from->count == 0) return ASC_OK;
  if (to->count == 0) {
    *to = *from;
    return ASC_OK;
  }
  asc_moments made = *to;
  const double before = (double)to->count, added = (double)from->count, all = before + added;
  const double apart = (from->origin - to->origin) + (from->mean - to->mean);
  made.count += from->count;
  made.mean += apart * (added / all);
  made.squares += from->squares + apart * apart * (before * (added / all));
  if (!isfinite(made.squares)) return ASC_NUMERIC;
  *to = made;
  return ASC_OK;
}

asc_status asc_moments_summarise(const asc_moments *of, asc_moments_summary *made) {
  if (!of || !made) return ASC_INVALID_ARGUMENT;
  const double count = (double)of->count;
  *made = (asc_moments_summary){of->count, of->origin + of->mean, NAN, NAN};
  if (of->count == 0) made->mean = NAN;
  if (of->count < 2) return ASC_OK;
  made->variance = of->squares / (count - 1.0);
  made->standard_error = sqrt(made->variance / count);
  return ASC_OK;
}

asc_status asc_moments_interval(const asc_moments *of, double confidence, double *lower, double *upper) {
  if (!of || !lower || !upper || of->count < 2 || !(confidence > 0.0 && confidence < 1.0)) return ASC_INVALID_ARGUMENT;
  asc_moments_summary summary;
  (void)asc_moments_summarise(of, &summary);
  double t; /* of the lower tail: (1 + confidence)/2 would round */
  const asc_status status = asc_student_t_quantile(0.5 * (1.0 - confidence), (double)of->count - 1.0, &t);
  if (status) return status;
  *lower = summary.mean + t * summary.standard_error;
  *upper = summary.mean - t * summary.standard_error;
  return ASC_OK;
}

/* The estimators, over samplers and integrands of all kinds; moments and quantiles of any doubles. */
#include "aliascope/estimate.h"
#include "bytes.h"

enum { MOST_SAMPLES = 128, MOST_SIDE = 4, MOST_CHANNELS = 3, MOST_VALUES = MOST_SIDE * MOST_SIDE * MOST_CHANNELS };

/* Values of an integrand: an edge, whose two sides are any doubles, and one sample at which it is another. */
typedef struct edge {
  uint32_t channels;
  double a, b, c, low, high, odd;
  uint64_t odd_at, asked;
  asc_status fails;
} edge;

static asc_status edge_values(void *context, size_t count, const asc_pixel *pixels, const double *points,
                              double *values) {
  edge *of = context;
  for (size_t i = 0; i < count; i++) {
    const double x = points[2 * i], y = points[2 * i + 1];
    require(x >= 0.0 && x < 1.0 && y >= 0.0 && y < 1.0, "asked at (%g, %g)", x, y);
    const int inside = of->a * x + of->b * y + of->c * (pixels[i].x % 3) > 0.0;
    for (uint32_t c = 0; c < of->channels; c++)
      values[i * of->channels + c] = of->asked == of->odd_at ? of->odd : inside ? of->high : of->low * (c + 1);
    of->asked++;
  }
  return of->fails;
}

static double take_value(bytes *from) {
  return take_below(from, 8) ? (double)take(from, 1) / 128.0 - 0.5 : take_double(from);
}

static void check_estimate(const asc_estimator *estimator, const char *spec, uint32_t channels, uint64_t samples,
                           bytes *from) {
  edge of = {.channels = channels, .a = take_value(from), .b = take_value(from), .c = take_value(from)};
  of.low = take_value(from);
  of.high = take_value(from);
  of.odd = take_double(from);
  of.odd_at = take_below(from, 4) ? UINT64_MAX : take(from, 1);
  of.fails = take_below(from, 16) ? ASC_OK : ASC_UNAVAILABLE;
  const asc_group group = {(int32_t)take(from, 4), (int32_t)take(from, 4), 1 + take_below(from, MOST_SIDE),
                           1 + take_below(from, MOST_SIDE)};
  const size_t pixels = (size_t)group.columns * group.rows;
  double means[MOST_VALUES], errors[MOST_VALUES], degrees[MOST_VALUES];
  uint64_t counts[MOST_VALUES];
  asc_estimates made = {sizeof made, means, errors, degrees, counts, 0};
  asc_error error = {{0}};
  const asc_status status = asc_estimate(estimator, &group, edge_values, &of, &made, &error);
  if (status) {
    require(error.text[0] != '\0', "%s: failed without a reason", spec);
    return;
  }
  require(of.fails == ASC_OK, "%s: the integrand's status is lost", spec);
  require(made.spent == of.asked, "%s: spent %llu, asked %llu", spec, (unsigned long long)made.spent,
          (unsigned long long)of.asked);
  for (size_t i = 0; i < pixels * channels; i++) {
    require(isfinite(means[i]), "%s: mean %zu is %g", spec, i, means[i]);
    require(isnan(errors[i]) || (errors[i] >= 0.0 && isfinite(errors[i])), "%s: error %zu is %g", spec, i, errors[i]);
  }
  for (size_t i = 0; i < pixels; i++) {
    require(counts[i] >= 1 && counts[i] <= samples, "%s: pixel %zu has %llu of %llu samples", spec, i,
            (unsigned long long)counts[i], (unsigned long long)samples);
    require(isnan(degrees[i]) || degrees[i] > 0.0, "%s: pixel %zu has %g degrees", spec, i, degrees[i]);
  }
}

static void run_estimator(bytes *from) {
  asc_estimator_info info;
  require(asc_estimator_describe(take_below(from, (uint32_t)asc_estimator_count()), &info) == ASC_OK, "no estimator");
  char spec[512];
  (void)snprintf(spec, sizeof spec, "%s", info.name);
  take_keys(from, info.parameters, info.parameter_count, 64.0, spec, sizeof spec);
  static const char *const patterns[] = {"random",   "halton:scramble=shift", "sobol:scramble=owen", "r2", "regular",
                                         "jittered", "gauss-legendre"};
  const char *pattern = patterns[take_below(from, sizeof patterns / sizeof *patterns)];
  const asc_sampler_desc sampled = {sizeof sampled, pattern, 1 + take_below(from, MOST_SAMPLES), 2, take(from, 2)};
  asc_sampler *sampler = NULL;
  if (asc_sampler_create(&sampled, &sampler, NULL)) return;
  const uint32_t channels = 1 + take_below(from, MOST_CHANNELS);
  const asc_estimator_desc desc = {sizeof desc, spec, sampler, channels};
  asc_estimator *estimator = NULL;
  asc_error error = {{0}};
  const asc_status status = asc_estimator_create(&desc, &estimator, &error);
  require((status == ASC_OK) == (estimator != NULL), "%s: an estimator with status %d", spec, (int)status);
  if (status)
    require(error.text[0] != '\0', "%s: refused without a reason", spec);
  else
    check_estimate(estimator, spec, channels, sampled.samples, from);
  asc_estimator_destroy(estimator);
  asc_sampler_destroy(sampler);
}

/* All at once and in two parts: the same bits, or both refused. */
static void run_moments(bytes *from) {
  double values[32];
  const size_t count = 1 + take_below(from, 32), part = take_below(from, (uint32_t)count + 1);
  for (size_t i = 0; i < count; i++) values[i] = take_below(from, 2) ? take_double(from) : take_value(from);
  asc_moments whole = {0}, parts = {0}, rest = {0};
  const asc_status status = asc_moments_add(&whole, values, count);
  const asc_status first = asc_moments_add(&parts, values, part);
  const asc_status second = first ? first : asc_moments_add(&parts, values + part, count - part);
  require(status == second, "moments: %d, in parts %d", (int)status, (int)second);
  require(status == ASC_OK || status == ASC_NUMERIC, "moments: %d", (int)status);
  if (status) {
    require(whole.count == 0, "moments: something was added");
    return;
  }
  require(memcmp(&whole, &parts, sizeof whole) == 0, "moments: other bits in parts");
  asc_moments_summary summary;
  const asc_status summed = asc_moments_summarise(&whole, &summary);
  if (summed == ASC_OK && count > 1)
    require(isfinite(summary.mean) && summary.variance >= 0.0, "moments: %g, %g", summary.mean, summary.variance);
  double lower, upper;
  if (asc_moments_interval(&whole, take_value(from), &lower, &upper) == ASC_OK)
    require(lower <= upper, "moments: [%g, %g]", lower, upper);
  asc_moments merged = {0};
  if (asc_moments_add(&merged, values, part) == ASC_OK && asc_moments_add(&rest, values + part, count - part) == ASC_OK)
    (void)asc_moments_merge(&merged, &rest);
}

static void run_strata(bytes *from) {
  asc_stratum strata[8];
  const size_t count = take_below(from, 9);
  for (size_t j = 0; j < count; j++) {
    double values[4];
    const size_t n = take_below(from, 5);
    for (size_t i = 0; i < n; i++) values[i] = take_value(from);
    strata[j] = (asc_stratum){.size = take_below(from, 4) ? (double)(1 + take(from, 1)) : take_double(from)};
    (void)asc_moments_add(&strata[j].moments, values, n);
  }
  asc_stratified made;
  if (asc_stratify(strata, count, &made) == ASC_OK)
    require(isfinite(made.mean) && !(made.standard_error < 0.0), "strata: %g +- %g", made.mean, made.standard_error);
}

static void run_quantiles(bytes *from) {
  const uint32_t which = take_below(from, 4);
  const double p = take_below(from, 2) ? take_coordinate(from) : take_double(from), degrees = take_double(from);
  double x;
  asc_status status = ASC_OK;
  if (which == 0) status = asc_normal_quantile(p, &x);
  if (which == 1) status = asc_student_t_quantile(p, degrees, &x);
  if (which == 2) status = asc_chi_squared_quantile(p, degrees, &x);
  if (which == 3) status = asc_chi_squared_upper_quantile(p, degrees, &x);
  const int valid = p > 0.0 && p < 1.0 && (which == 0 || (degrees >= 1.0 && degrees <= 1e12));
  require((status == ASC_INVALID_ARGUMENT) == !valid, "quantile %u of %g, %g: %d", which, p, degrees, (int)status);
  if (status == ASC_OK) require(isfinite(x), "quantile %u of %g, %g: %g", which, p, degrees, x);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes from = {data, size};
  const uint32_t what = take_below(&from, 8);
  if (what < 5) run_estimator(&from);
  if (what == 5) run_moments(&from);
  if (what == 6) run_strata(&from);
  if (what == 7) run_quantiles(&from);
  return 0;
}

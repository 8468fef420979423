/* Samples until the variance of the mean is small: (n - 1) s^2/sigma^2 is chi-squared with n - 1 degrees of freedom, so
 * that with `confidence` sigma^2/n is below (n - 1) s^2/(c n), c being the quantile 1 - confidence. Ends when the root
 * of that, the standard deviation of the mean, is within the tolerance in every channel.
 *
 * Lee, Redner and Uselton 1985, "Statistically optimized sampling for distributed ray tracing", Computer Graphics
 * 19(3), whose threshold is of the variance, the square of this tolerance. It supposes normal values, as they do. */
#include "sequential.h"

static const asc_parameter parameters[ASC_SEQUENTIAL_COUNT] = {
    {"tolerance", ASC_REAL, NULL, 0.0, 1e300, 0.01, "standard deviation of the mean that is small enough"},
    ASC_SEQUENTIAL_PARAMETERS};

static asc_status prepare(asc_estimator *self, asc_error *error) {
  return asc_sequential_prepare(self, ASC_BY_CHI_SQUARED, error);
}

const asc_estimator_interface asc_estimator_chi_squared = {
    .name = "chi-squared",
    .title = "until the variance of the mean is small, by chi-squared",
    .source = "Lee, Redner and Uselton 1985, Statistically optimized sampling for distributed ray tracing",
    .parameters = parameters,
    .parameter_count = ASC_SEQUENTIAL_COUNT,
    .reach = asc_sequential_reach,
    .prepare = prepare,
    .run = asc_sequential_run};

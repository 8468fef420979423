/* What the tests of estimators share. Include after cmocka.h. */
#ifndef ESTIMATE_TOOLS_H
#define ESTIMATE_TOOLS_H

#include "aliascope/estimate.h"

static inline asc_sampler *sampler_of(const char *spec, uint64_t samples, uint32_t dimensions) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, 5};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  if (asc_sampler_create(&desc, &sampler, &error)) fail_msg("%s", error.text);
  return sampler;
}

static inline asc_estimator *estimator_of(const char *spec, const asc_sampler *sampler, uint32_t channels) {
  const asc_estimator_desc desc = {sizeof desc, spec, sampler, channels};
  asc_estimator *estimator = NULL;
  asc_error error = {{0}};
  if (asc_estimator_create(&desc, &estimator, &error)) fail_msg("%s: %s", spec, error.text);
  return estimator;
}

/* Estimates of a group, in memory of the right size. */
typedef struct result {
  double means[200], errors[200], degrees[100];
  uint64_t counts[100], spent;
} result;

static inline result estimated(const asc_estimator *with, asc_group group, asc_integrand integrand, void *context) {
  result made = {.spent = 0};
  asc_estimates out = {sizeof out, made.means, made.errors, made.degrees, made.counts, 0};
  asc_error error = {{0}};
  if (asc_estimate(with, &group, integrand, context, &out, &error)) fail_msg("%s", error.text);
  made.spent = out.spent;
  return made;
}

#endif

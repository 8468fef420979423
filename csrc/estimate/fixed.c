/* All pixels alike: the first n samples of the sampler, whatever they show. The baseline of those that decide.
 *
 * With n = N any sampler will do. A quadrature rule's values get its weights, and no standard error, as its error is
 * not random. Otherwise the standard error is s/sqrt(n), that of independent samples: samples that are spread evenly
 * err less, and for a pattern that is not randomised it means nothing. */
#include <math.h>
#include <stdlib.h>

#include "estimator.h"

enum { COUNT };

static const asc_parameter parameters[] = {
    {"n", ASC_INTEGER, NULL, 0, 9007199254740992.0, 0, "samples of a pixel; 0: all N of the sampler"}};

#define RULE_AT_ONCE 4096

static asc_status prepare(asc_estimator *self, asc_error *error) {
  const uint64_t count = self->values[COUNT] > 0.0 ? (uint64_t)self->values[COUNT] : self->samples;
  if (count > self->samples)
    return asc_fail(error, ASC_INVALID_VALUE, "fixed: n=%llu is more than the %llu samples of a pixel",
                    (unsigned long long)count, (unsigned long long)self->samples);
  const uint32_t traits = asc_sampler_traits(self->sampler);
  if (count < self->samples && (!(traits & ASC_TRAIT_SEQUENCE) || traits & ASC_TRAIT_WEIGHTED))
    return asc_fail(error, ASC_UNSUPPORTED,
                    "fixed: n=%llu of %llu samples need a sampler that is a sequence without weights",
                    (unsigned long long)count, (unsigned long long)self->samples);
  self->samples = count;
  return ASC_OK;
}

/* One pixel by a rule: the sum of weights times values. `work` has room for RULE_AT_ONCE samples. */
static asc_status apply_rule(const asc_estimator *self, const asc_group *group, asc_pixel pixel,
                             asc_integrand integrand, void *context, double *work, asc_pixel *pixels, double *sums,
                             asc_error *error) {
  double *points = work, *values = points + (size_t)RULE_AT_ONCE * self->dimensions;
  double *weights = values + (size_t)RULE_AT_ONCE * self->channels;
  for (uint32_t c = 0; c < self->channels; c++) sums[c] = 0.0;
  for (size_t i = 0; i < RULE_AT_ONCE; i++) pixels[i] = pixel;
  for (uint64_t first = 0; first < self->samples; first += RULE_AT_ONCE) {
    const uint64_t rest = self->samples - first;
    const size_t count = rest < RULE_AT_ONCE ? (size_t)rest : RULE_AT_ONCE;
    const asc_range range = {pixel.x, pixel.y, first, count, 0, self->dimensions};
    asc_status status = asc_sampler_fill(self->sampler, &range, points);
    if (status) return asc_fail_samples(self->sampler, group, &range, points, status, error);
    status = asc_sampler_weights(self->sampler, first, count, weights);
    if (status) return asc_fail_weights(self->sampler, first, count, weights, status, error);
    status = integrand(context, count, pixels, points, values);
    if (status) return asc_fail(error, status, "the integrand failed in pixel (%d, %d)", pixel.x, pixel.y);
    for (size_t i = 0; i < count; i++) {
      const double *value = values + i * self->channels;
      for (uint32_t c = 0; c < self->channels; c++) sums[c] += weights[i] * value[c];
      for (uint32_t c = 0; c < self->channels; c++)
        if (!isfinite(sums[c]))
          return asc_fail_value(self, group, pixel, points + i * self->dimensions, value, ASC_NUMERIC, error);
    }
  }
  return ASC_OK;
}

static asc_status run_rule(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                           asc_estimates *made, asc_error *error) {
  double *work = malloc((size_t)RULE_AT_ONCE * (self->dimensions + self->channels + 1) * sizeof *work);
  asc_pixel *pixels = malloc(RULE_AT_ONCE * sizeof *pixels);
  asc_status status = work && pixels ? ASC_OK : ASC_OUT_OF_MEMORY;
  if (status) (void)asc_fail(error, status, "out of memory");
  for (size_t i = 0; i < (size_t)group->columns * group->rows && status == ASC_OK; i++) {
    status = apply_rule(self, group, asc_pixel_of(group, i), integrand, context, work, pixels,
                        made->means + i * self->channels, error);
    if (made->counts) made->counts[i] = self->samples;
    made->spent += self->samples;
  }
  free(work);
  free(pixels);
  return status;
}

static asc_status run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                      asc_estimates *made, asc_error *error) {
  if (asc_sampler_traits(self->sampler) & ASC_TRAIT_WEIGHTED)
    return run_rule(self, group, integrand, context, made, error);
  const size_t pixels = (size_t)group->columns * group->rows;
  asc_draw *draws = calloc(pixels, sizeof *draws);
  asc_tally *tallies = calloc(pixels, self->channels * sizeof *tallies);
  asc_status status = draws && tallies ? ASC_OK : ASC_OUT_OF_MEMORY;
  if (status) (void)asc_fail(error, status, "out of memory");
  for (size_t i = 0; i < pixels && status == ASC_OK; i++)
    draws[i] = (asc_draw){.pixel = asc_pixel_of(group, i), .count = self->samples, .to = tallies + i * self->channels};
  if (status == ASC_OK) status = asc_take(self, group, draws, pixels, integrand, context, error);
  for (size_t i = 0; i < pixels && status == ASC_OK; i++)
    asc_write_tallies(made, i, self->channels, tallies + i * self->channels, self->samples);
  free(draws);
  free(tallies);
  return status;
}

const asc_estimator_interface asc_estimator_fixed = {.name = "fixed",
                                                     .title = "as many samples in every pixel",
                                                     .source = "the plain Monte Carlo estimate",
                                                     .parameters = parameters,
                                                     .parameter_count = sizeof parameters / sizeof *parameters,
                                                     .any_sampler = 1,
                                                     .prepare = prepare,
                                                     .run = run};

/* What is said of samples and values that cannot be: where, so that they can be found. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "estimator.h"

static int32_t clamped(int32_t at, int32_t first, uint32_t count) {
  const int64_t last = (int64_t)first + count - 1;
  return at < first ? first : at > last ? (int32_t)last : at;
}

/* The first that is not finite, or else the largest. */
static uint32_t culprit(const double *values, uint32_t channels) {
  uint32_t found = 0;
  for (uint32_t c = 0; c < channels; c++) {
    if (!isfinite(values[c])) return c;
    if (fabs(values[c]) > fabs(values[found])) found = c;
  }
  return found;
}

#define BESIDE 96

/* The pixel of the group that is next to a pixel; `beside` gets what tells that this is another one, or "". */
static asc_pixel asked_pixel(const asc_group *group, asc_pixel pixel, char beside[BESIDE]) {
  const asc_pixel asked = {clamped(pixel.x, group->x, group->columns), clamped(pixel.y, group->y, group->rows)};
  beside[0] = '\0';
  if (asked.x != pixel.x || asked.y != pixel.y)
    (void)snprintf(beside, BESIDE, ", of its neighbour (%d, %d), which it looks at too", pixel.x, pixel.y);
  return asked;
}

asc_status asc_fail_value(const asc_estimator *self, const asc_group *group, asc_pixel pixel, const double *point,
                          const double *values, asc_status status, asc_error *error) {
  char place[64], beside[BESIDE];
  const asc_pixel asked = asked_pixel(group, pixel, beside);
  const uint32_t channel = culprit(values, self->channels);
  if (self->dimensions > 1)
    (void)snprintf(place, sizeof place, "(%.9g, %.9g)", point[0], point[1]);
  else
    (void)snprintf(place, sizeof place, "%.9g", point[0]);
  return asc_fail(error, status,
                  "the integrand has a value that is not finite, or too large to square, in pixel (%d, %d): %g in "
                  "channel %u of the sample at %s%s",
                  asked.x, asked.y, values[channel], channel, place, beside);
}

asc_status asc_fail_samples(const asc_sampler *sampler, const asc_group *group, const asc_range *range,
                            const double *points, asc_status status, asc_error *error) {
  char beside[BESIDE];
  const asc_pixel asked = asked_pixel(group, (asc_pixel){range->pixel_x, range->pixel_y}, beside);
  asc_sampler_desc of;
  if (asc_sampler_resolved(sampler, &of)) of.spec = "";
  for (size_t i = 0; status == ASC_OUT_OF_RANGE && i < range->sample_count * range->dimension_count; i++)
    if (!(points[i] >= 0.0 && points[i] < 1.0))
      return asc_fail(error, status,
                      "the sampler %s gave a value outside [0, 1): %g as number %zu of sample %" PRIu64
                      " of pixel (%d, %d)%s",
                      of.spec, points[i], i % range->dimension_count, range->first_sample + i / range->dimension_count,
                      asked.x, asked.y, beside);
  return asc_fail(error, status, "the sampler %s has no samples from %" PRIu64 " on for pixel (%d, %d)%s: %s", of.spec,
                  range->first_sample, asked.x, asked.y, beside, asc_status_text(status));
}

asc_status asc_fail_weights(const asc_sampler *sampler, uint64_t first, size_t count, const double *weights,
                            asc_status status, asc_error *error) {
  asc_sampler_desc of;
  if (asc_sampler_resolved(sampler, &of)) of.spec = "";
  for (size_t i = 0; status == ASC_NUMERIC && i < count; i++)
    if (!isfinite(weights[i]))
      return asc_fail(error, status, "the sampler %s gives sample %" PRIu64 " the weight %g", of.spec, first + i,
                      weights[i]);
  return asc_fail(error, status, "the sampler %s has no weights: %s", of.spec, asc_status_text(status));
}

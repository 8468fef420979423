/* What the tests of samplers share. Include after cmocka.h. */
#ifndef SAMPLER_TOOLS_H
#define SAMPLER_TOOLS_H

#include "aliascope/sampler.h"

static inline asc_sampler *make(const char *spec, uint64_t samples, uint32_t dimensions, uint64_t seed) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, seed};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  if (asc_sampler_create(&desc, &sampler, &error)) fail_msg("%s: %s", spec, error.text);
  return sampler;
}

static inline void fill(const asc_sampler *sampler, int32_t x, int32_t y, uint64_t first, size_t count,
                        uint32_t dimension, uint32_t dimensions, double *points) {
  const asc_range range = {x, y, first, count, dimension, dimensions};
  assert_int_equal(asc_sampler_fill(sampler, &range, points), ASC_OK);
}

/* All points of pixel (0, 0), in one call. */
static inline void points_of(const char *spec, uint64_t samples, uint32_t dimensions, uint64_t seed, double *points) {
  asc_sampler *sampler = make(spec, samples, dimensions, seed);
  fill(sampler, 0, 0, 0, (size_t)samples, 0, dimensions, points);
  asc_sampler_destroy(sampler);
}

/* What creation says. */
static inline asc_status created(const char *spec, uint64_t samples, uint32_t dimensions) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, 0};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  const asc_status status = asc_sampler_create(&desc, &sampler, &error);
  asc_sampler_destroy(sampler);
  return status;
}

#endif

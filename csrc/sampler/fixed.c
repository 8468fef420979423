#include "fixed.h"

#include <stdlib.h>

typedef struct fixed_state {
  const uint8_t (*sixteenths)[2];
} fixed_state;

asc_status asc_fixed_create(const asc_fixed_table *table, const asc_sampler_config *config, asc_sampler_state *made,
                            asc_error *error) {
  const uint64_t n = config->samples;
  if (config->dimensions != 2)
    return asc_fail(error, ASC_UNSUPPORTED, "%s has two dimensions, not %u", table->name, config->dimensions);
  if (n == 0 || (n & (n - 1)) || n > table->most)
    return asc_fail(error, ASC_UNSUPPORTED, "%s has sets of 1, 2, 4, ... %llu points, not of %llu", table->name,
                    (unsigned long long)table->most, (unsigned long long)n);
  fixed_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "%s: out of memory", table->name);
  state->sixteenths = table->sixteenths + (n - 1); /* 1 + 2 + ... + n/2 points come before */
  *made = (asc_sampler_state){state, 0, n};
  return ASC_OK;
}

asc_status asc_fixed_fill(const void *opaque, const asc_range *range, double *points) {
  const fixed_state *state = opaque;
  for (size_t i = 0; i < range->sample_count; i++)
    for (uint32_t d = 0; d < range->dimension_count; d++)
      *points++ = state->sixteenths[range->first_sample + i][range->first_dimension + d] / 16.0;
  return ASC_OK;
}

/* The regular grid: k^d points at the centres of k^d cells, the first dimension running fastest.
 *
 * Not randomised: every pixel has the same points. */
#include <stdlib.h>

#include "pattern.h"

typedef struct regular_state {
  uint64_t side;
} regular_state;

static asc_status regular_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const uint64_t side = asc_exact_root(config->samples, config->dimensions);
  if (side == 0)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "regular has k^%u points in %u dimensions; %llu is not such a power: choose another N",
                    config->dimensions, config->dimensions, (unsigned long long)config->samples);
  regular_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "regular: out of memory");
  state->side = side;
  *made = (asc_sampler_state){state, 0, config->samples};
  return ASC_OK;
}

static asc_status regular_fill(const void *opaque, const asc_range *range, double *points) {
  const regular_state *state = opaque;
  const uint64_t side = state->side;
  for (size_t i = 0; i < range->sample_count; i++) {
    uint64_t rest = range->first_sample + i;
    for (uint32_t d = 0; d < range->first_dimension; d++) rest /= side;
    for (uint32_t d = 0; d < range->dimension_count; d++, rest /= side)
      *points++ = ((double)(rest % side) + 0.5) / (double)side;
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_regular = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "regular",
    .title = "the centres of a grid's cells",
    .source = "the trapezoid rule's points, moved by half a cell",
    .create = regular_create,
    .destroy = free,
    .fill = regular_fill,
};

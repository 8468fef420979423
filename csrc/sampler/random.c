/* Independent uniform points: what every other pattern is measured against.
 *
 * Source: Metropolis and Ulam 1949, "The Monte Carlo method". The numbers are those of hash.h: one block of 128 bits
 * for each pair of dimensions of each sample. */
#include <stdlib.h>

#include "pattern.h"

typedef struct random_state {
  uint64_t seed;
} random_state;

static asc_status random_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  random_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "random: out of memory");
  state->seed = config->seed;
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED | ASC_TRAIT_SEQUENCE, ASC_SEQUENCE_END};
  return ASC_OK;
}

static asc_status random_fill(const void *opaque, const asc_range *range, double *points) {
  const random_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  for (size_t done = 0; done < range->sample_count; done += ASC_LANES) {
    const size_t left = range->sample_count - done;
    const size_t lanes = left < ASC_LANES ? left : ASC_LANES;
    for (uint32_t pair = begin / 2; pair <= (end - 1) / 2; pair++) {
      asc_lanes bits;
      asc_hash_lanes(key, range->first_sample + done, pair, ASC_PURPOSE_UNIFORM, &bits);
      for (uint32_t half = 0; half < 2; half++) {
        const uint32_t dimension = 2 * pair + half;
        if (dimension < begin || dimension >= end) continue;
        const uint32_t *high = bits.word[half ? 2 : 0], *low = bits.word[half ? 3 : 1];
        double *column = points + done * range->dimension_count + (dimension - begin);
        for (size_t i = 0; i < lanes; i++) column[i * range->dimension_count] = asc_unit53(high[i], low[i]);
      }
    }
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_random = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "random",
    .title = "independent uniform points",
    .source = "Metropolis and Ulam 1949",
    .create = random_create,
    .destroy = free,
    .fill = random_fill,
};

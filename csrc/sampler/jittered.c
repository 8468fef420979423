/* One uniform point in each cell of a k x k grid.
 *
 * Source: Cook, Porter, Carpenter 1984, "Distributed ray tracing"; the name is Cook's (1986, "Stochastic sampling in
 * computer graphics"). More than two dimensions are padded: an independent pattern for each pair (0,1), (2,3), ..., the
 * pairs shuffled against each other; a last dimension without a partner has N strata of its own. */
#include <stdlib.h>

#include "pattern.h"
#include "permutation.h"

typedef struct jittered_state {
  uint64_t samples, seed, side;
  uint32_t dimensions;
} jittered_state;

static asc_status jittered_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const uint64_t side = asc_exact_root(config->samples, 2);
  if (side == 0 && config->dimensions > 1)
    return asc_fail(error, ASC_UNSUPPORTED, "jittered has k x k points; %llu is no square: choose 1, 4, 9, 16, ...",
                    (unsigned long long)config->samples);
  jittered_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "jittered: out of memory");
  *state = (jittered_state){config->samples, config->seed, side, config->dimensions};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* The columns of one pair of dimensions that the range asks for. */
static void fill_pair(const jittered_state *state, const asc_range *range, asc_key key, uint32_t pair, double *points) {
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  const int alone = 2 * pair + 1 == state->dimensions; /* no partner: N strata of its own */
  asc_permutation shuffle;
  if (pair > 0) asc_permutation_make(&shuffle, state->samples, key, pair);
  for (size_t done = 0; done < range->sample_count; done += ASC_LANES) {
    asc_lanes bits;
    asc_hash_lanes(key, range->first_sample + done, pair, ASC_PURPOSE_STRATUM, &bits);
    const size_t left = range->sample_count - done;
    for (size_t i = 0; i < (left < ASC_LANES ? left : ASC_LANES); i++) {
      const uint64_t sample = range->first_sample + done + i;
      const uint64_t cell = pair > 0 ? asc_permutation_at(&shuffle, sample) : sample;
      const uint64_t strata = alone ? state->samples : state->side;
      const uint64_t stratum[2] = {alone ? cell : cell % strata, alone ? 0 : cell / strata};
      for (uint32_t half = 0; half < 2; half++) {
        const uint32_t dimension = 2 * pair + half;
        if (dimension < begin || dimension >= end) continue;
        points[(done + i) * range->dimension_count + (dimension - begin)] =
            ((double)stratum[half] + asc_unit32(bits.word[half][i])) / (double)strata;
      }
    }
  }
}

static asc_status jittered_fill(const void *opaque, const asc_range *range, double *points) {
  const jittered_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  const uint32_t last = (range->first_dimension + range->dimension_count - 1) / 2;
  for (uint32_t pair = range->first_dimension / 2; pair <= last; pair++) fill_pair(state, range, key, pair, points);
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_jittered = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "jittered",
    .title = "one uniform point in each cell of a grid",
    .source = "Cook, Porter, Carpenter 1984; Cook 1986",
    .create = jittered_create,
    .destroy = free,
    .fill = jittered_fill,
};

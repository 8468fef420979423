#include "multi_jitter.h"

#include <stdlib.h>

#include "cell.h"
#include "permutation_family.h"

typedef struct multi_jitter_state {
  uint64_t samples, seed, columns, rows;
  int correlated;
} multi_jitter_state;

static uint64_t largest_divisor_up_to_root(uint64_t n) {
  uint64_t largest = 1;
  for (uint64_t divisor = 2; divisor * divisor <= n; divisor++)
    if (n % divisor == 0) largest = divisor;
  return largest;
}

asc_status asc_multi_jitter_create(const asc_sampler_config *config, const char *name, int correlated,
                                   asc_sampler_state *made, asc_error *error) {
  if (config->samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "%s has at most 2^32 points; %llu are asked for", name,
                    (unsigned long long)config->samples);
  multi_jitter_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "%s: out of memory", name);
  const uint64_t columns = largest_divisor_up_to_root(config->samples);
  *state = (multi_jitter_state){config->samples, config->seed, columns, config->samples / columns, correlated};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* The columns of one pair of dimensions that the range asks for. */
static void fill_pair(const multi_jitter_state *state, const asc_range *range, asc_key key, uint32_t pair,
                      double *points) {
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  asc_permutation shuffle;
  asc_permutation_family sub_columns, sub_rows;
  asc_permutation_make(&shuffle, state->samples, key, pair);
  asc_permutation_family_begin(&sub_columns, state->rows, key, 2 * pair);
  asc_permutation_family_begin(&sub_rows, state->columns, key, 2 * pair + 1);
  for (size_t done = 0; done < range->sample_count; done += ASC_LANES) {
    asc_lanes bits;
    const size_t left = range->sample_count - done, count = left < ASC_LANES ? left : ASC_LANES;
    asc_cell_bits(key, range->first_sample + done, count, pair, &bits);
    for (size_t i = 0; i < count; i++) {
      const uint64_t cell = asc_permutation_at(&shuffle, range->first_sample + done + i);
      const uint32_t column = (uint32_t)(cell % state->columns), row = (uint32_t)(cell / state->columns);
      double *point = points + (done + i) * range->dimension_count;
      if (2 * pair >= begin) {
        const uint64_t sub = asc_permutation_family_at(&sub_columns, state->correlated ? 0 : column, row);
        point[2 * pair - begin] = asc_in_cell(column * state->rows + sub, state->samples, bits.word[0][i]);
      }
      if (2 * pair + 1 < end) {
        const uint64_t sub = asc_permutation_family_at(&sub_rows, state->correlated ? 0 : row, column);
        point[2 * pair + 1 - begin] = asc_in_cell(row * state->columns + sub, state->samples, bits.word[1][i]);
      }
    }
  }
}

asc_status asc_multi_jitter_fill(const void *opaque, const asc_range *range, double *points) {
  const multi_jitter_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  const uint32_t last = (range->first_dimension + range->dimension_count - 1) / 2;
  for (uint32_t pair = range->first_dimension / 2; pair <= last; pair++) fill_pair(state, range, key, pair, points);
  return ASC_OK;
}

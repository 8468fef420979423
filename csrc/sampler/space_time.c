#include "space_time.h"

#include <stdlib.h>

#define DIMENSIONS 3

const asc_parameter asc_space_time_centred = {
    "centred", ASC_INTEGER, NULL, 0, 1, 0, "1: the table itself in every pixel, points at the centres of cells"};

/* How a pixel moves the table. */
typedef struct motion {
  uint64_t right, down;
  int mirrored, flipped, transposed, backward;
} motion;

asc_status asc_space_time_check(const char *name, const asc_sampler_config *config, asc_error *error) {
  if (config->dimensions == DIMENSIONS) return ASC_OK;
  return asc_fail(error, ASC_UNSUPPORTED, "%s has three dimensions, x, y and t, not %u", name, config->dimensions);
}

asc_space_time *asc_space_time_new(const asc_sampler_config *config, uint64_t side, asc_slot_function slot,
                                   size_t slots) {
  asc_space_time *pattern = malloc(sizeof *pattern + slots * sizeof *pattern->slots);
  if (!pattern) return NULL;
  pattern->seed = config->seed;
  pattern->side = side;
  pattern->step = 0;
  pattern->centred = config->values[0] != 0.0;
  pattern->slot = slot;
  return pattern;
}

asc_sampler_state asc_space_time_state(asc_space_time *pattern) {
  const uint32_t randomised = pattern->centred ? 0 : ASC_TRAIT_RANDOMISED;
  return (asc_sampler_state){pattern, randomised, pattern->side * pattern->side};
}

static motion motion_of(const asc_space_time *pattern, asc_key key) {
  if (pattern->centred) return (motion){0};
  const uint32_t bits = asc_hash(key, 0, 2, ASC_PURPOSE_ROTATION).word[0];
  const double side = (double)pattern->side;
  return (motion){.right = (uint64_t)(asc_rotation(key, 0) * side),
                  .down = (uint64_t)(asc_rotation(key, 1) * side),
                  .mirrored = bits & 1,
                  .flipped = bits >> 1 & 1,
                  .transposed = bits >> 2 & 1,
                  .backward = bits >> 3 & 1};
}

static uint64_t moved_slot(const asc_space_time *pattern, const motion *by, uint64_t column, uint64_t row) {
  const uint64_t side = pattern->side;
  column = (column + by->right) % side;
  row = (row + by->down) % side;
  if (by->mirrored) column = side - 1 - column;
  if (by->flipped) row = side - 1 - row;
  const uint64_t slot = by->transposed ? pattern->slot(pattern, row, column) : pattern->slot(pattern, column, row);
  return by->backward ? side * side - 1 - slot : slot;
}

/* `count` cells of [0, 1), and what a jitter in them can have: cell + u is exact, so that a value keeps to its cell,
 * and so of the 33 binary digits of u as many are left out as `count` has more than 20. */
typedef struct division {
  uint64_t count;
  int left_out;
  double digit; /* the last one that is kept */
} division;

static division divide(uint64_t count) {
  division made = {count, 0, 0x1p-32};
  for (; count >> made.left_out > 1u << 20; made.left_out++) made.digit *= 2.0;
  return made;
}

static double place(uint64_t cell, const division *of, uint32_t bits) {
  return ((double)cell + ((double)(bits >> of->left_out) + 0.5) * of->digit) / (double)of->count;
}

asc_status asc_space_time_fill(const void *opaque, const asc_range *range, double *points) {
  const asc_space_time *pattern = opaque;
  const asc_key key = asc_stream_key(pattern->seed, range->pixel_x, range->pixel_y);
  const motion by = motion_of(pattern, key);
  const uint64_t side = pattern->side;
  const division of_axis = divide(side), of_time = divide(side * side);
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  for (size_t done = 0; done < range->sample_count; done += ASC_LANES) {
    asc_lanes bits;
    if (!pattern->centred) asc_hash_lanes(key, range->first_sample + done, 0, ASC_PURPOSE_STRATUM, &bits);
    const size_t left = range->sample_count - done;
    for (size_t i = 0; i < (left < ASC_LANES ? left : ASC_LANES); i++) {
      const uint64_t sample = range->first_sample + done + i, column = sample % side, row = sample / side;
      for (uint32_t d = begin; d < end; d++) {
        const uint64_t cell = d == 0 ? column : d == 1 ? row : moved_slot(pattern, &by, column, row);
        const division *of = d < 2 ? &of_axis : &of_time;
        *points++ = pattern->centred ? ((double)cell + 0.5) / (double)of->count : place(cell, of, bits.word[d][i]);
      }
    }
  }
  return ASC_OK;
}

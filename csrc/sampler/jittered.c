/* One uniform point in each cell of a k x k grid.
 *
 * Source: Cook, Porter, Carpenter 1984, "Distributed ray tracing"; the name is Cook's (1986, "Stochastic sampling in
 * computer graphics"). More than two dimensions are padded: an independent pattern for each pair (0,1), (2,3), ..., the
 * pairs shuffled against each other; a last dimension without a partner has N strata of its own. */
#include <stdlib.h>

#include "pattern.h"
#include "permutation.h"
#include "tile.h"

#define QUAD ASC_TILE_COLUMNS
#define RUN ASC_PERMUTATION_RUN

typedef struct jittered_state {
  uint64_t samples, seed_mix;
  double side;
  uint32_t dimensions;
  int paired;                     /* at most two dimensions: two samples share a block of random bits */
  asc_jitter in_cell, in_stratum; /* of the k x k, and of the N of a dimension without a partner */
} jittered_state;

static asc_status jittered_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const uint64_t side = asc_exact_root(config->samples, 2);
  if (side == 0 && config->dimensions > 1)
    return asc_fail(error, ASC_UNSUPPORTED, "jittered has k x k points; %llu is no square: choose 1, 4, 9, 16, ...",
                    (unsigned long long)config->samples);
  if (config->samples > ASC_JITTER_CELLS) return asc_fail(error, ASC_UNSUPPORTED, "jittered has at most 2^48 points");
  jittered_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "jittered: out of memory");
  *state = (jittered_state){.samples = config->samples,
                            .seed_mix = asc_seed_mix(config->seed),
                            .side = (double)side,
                            .dimensions = config->dimensions,
                            .in_cell = asc_jitter_of(side),
                            .in_stratum = asc_jitter_of(config->samples)};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* Four dimensions, two pairs. */
typedef struct quad {
  int shuffled[2], alone[2]; /* whether the pair is; whether it lacks its second dimension */
  uint64_t start[2];         /* of the random bits of its samples */
  asc_permutation shuffle[2];
} quad;

static void make_quad(const jittered_state *state, asc_key key, uint32_t index, quad *made) {
  for (uint32_t half = 0; half < 2; half++) {
    const uint32_t pair = 2 * index + half;
    made->alone[half] = 2 * pair + 1 == state->dimensions;
    made->shuffled[half] = pair > 0 && 2 * pair < state->dimensions;
    made->start[half] = asc_draw(key, pair, ASC_PURPOSE_STRATUM);
    if (made->shuffled[half]) asc_permutation_make(&made->shuffle[half], state->samples, key, pair);
  }
}

/* The whole part of cell / side, for the inverse of the side. The half keeps the product away from whole numbers: by
 * half a 2^24th, where its rounding errors stay below 2^-26. */
ASC_INLINE double row_of(double cell, double per_side) { return (double)(int32_t)((cell + 0.5) * per_side); }

/* --- one point ------------------------------------------------------------------------------------------------------
 */

/* The dimensions [begin, end) of one quad. */
ASC_VECTORISE
static void make_point(const jittered_state *state, asc_key key, uint32_t quad_index, uint64_t sample, uint32_t begin,
                       uint32_t end, double *point) {
  for (uint32_t half = begin / 2; 2 * half < end; half++) {
    const uint32_t pair = 2 * quad_index + half;
    const uint64_t bits = asc_draw_at(asc_draw(key, pair, ASC_PURPOSE_STRATUM), sample);
    const uint32_t bits_x = (uint32_t)(bits >> 32), bits_y = (uint32_t)bits;
    const double cell = (double)(int64_t)(pair > 0 ? asc_permutation_image(state->samples, key, pair, sample) : sample);
    if (2 * pair + 1 == state->dimensions) {
      *point = asc_jitter_place(state->in_stratum, cell, bits_x);
      return;
    }
    const double row = row_of(cell, state->in_cell.per_cell);
    if (2 * half >= begin) *point++ = asc_jitter_place(state->in_cell, cell - row * state->side, bits_x);
    if (2 * half + 1 < end) *point++ = asc_jitter_place(state->in_cell, row, bits_y);
  }
}

/* --- many at a time -------------------------------------------------------------------------------------------------
 */

ASC_INLINE void cell_columns(const jittered_state *state, const double *cells, const uint32_t *bits_x,
                             const uint32_t *bits_y, double *column_x, double *column_y) {
  const double side = state->side;
  const asc_jitter jitter = state->in_cell;
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) {
    const double row = row_of(cells[i], jitter.per_cell);
    column_x[i] = asc_jitter_place(jitter, cells[i] - row * side, bits_x[i]);
    column_y[i] = asc_jitter_place(jitter, row, bits_y[i]);
  }
}

ASC_INLINE void stratum_column(asc_jitter jitter, const double *strata, const uint32_t *bits, double *column) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) column[i] = asc_jitter_place(jitter, strata[i], bits[i]);
}

/* The columns [begin, end) of one quad of RUN samples or fewer. */
ASC_VECTORISE
static void make_columns(const jittered_state *state, const quad *of, double (*cells)[RUN], uint64_t first,
                         uint32_t count, uint32_t begin, uint32_t end, double *points, size_t stride) {
  for (uint32_t done = 0; done < count; done += ASC_LANES) {
    asc_tile tile;
    for (size_t half = begin / 2; 2 * half < end; half++) {
      uint32_t bits_x[ASC_LANES], bits_y[ASC_LANES];
      asc_draw_lanes(of->start[half], first + done, bits_x, bits_y);
      if (of->alone[half])
        stratum_column(state->in_stratum, cells[half] + done, bits_x, tile.column[2 * half]);
      else
        cell_columns(state, cells[half] + done, bits_x, bits_y, tile.column[2 * half], tile.column[2 * half + 1]);
    }
    const uint32_t rows = count - done < ASC_LANES ? count - done : ASC_LANES;
    asc_tile_write(&tile, begin, end, 0, rows, points + (size_t)done * stride, stride);
  }
}

static void fill_quad(const jittered_state *state, const asc_range *range, const quad *of, uint32_t begin, uint32_t end,
                      double *points) {
  const size_t stride = range->dimension_count;
  for (size_t done = 0; done < range->sample_count; done += RUN) {
    const uint64_t first = range->first_sample + done;
    const size_t left = range->sample_count - done;
    double cells[2][RUN];
    for (uint32_t half = begin / 2; 2 * half < end; half++)
      if (of->shuffled[half])
        asc_permutation_run(&of->shuffle[half], first, cells[half]);
      else
        for (uint64_t i = 0; i < RUN; i++) cells[half][i] = (double)(first + i);
    make_columns(state, of, cells, first, left < RUN ? (uint32_t)left : RUN, begin, end, points + done * stride,
                 stride);
  }
}

#define FEW 4 /* samples that are quicker made one by one */

ASC_APART void fill_range(const jittered_state *state, const asc_range *range, asc_key key, double *points) {
  const uint32_t first = range->first_dimension, past = first + range->dimension_count;
  for (uint32_t q = first / QUAD; q * QUAD < past; q++) {
    const uint32_t begin = q * QUAD < first ? first % QUAD : 0, end = past - q * QUAD < QUAD ? past - q * QUAD : QUAD;
    double *columns = points + (q * QUAD + begin - first);
    if (range->sample_count > FEW) {
      quad of;
      make_quad(state, key, q, &of);
      fill_quad(state, range, &of, begin, end, columns);
      continue;
    }
    for (uint32_t i = 0; i < range->sample_count; i++)
      make_point(state, key, q, range->first_sample + i, begin, end, columns + (size_t)i * range->dimension_count);
  }
}

static asc_status jittered_fill(const void *opaque, const asc_range *range, double *points) {
  const jittered_state *state = opaque;
  const asc_key key = asc_pixel_key(state->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t begin = range->first_dimension % QUAD, end = begin + range->dimension_count;
  if (range->sample_count == 1 && end <= QUAD)
    make_point(state, key, range->first_dimension / QUAD, range->first_sample, begin, end, points);
  else
    fill_range(state, range, key, points);
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

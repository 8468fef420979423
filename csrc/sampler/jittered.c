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
  uint64_t samples, seed_mix, side;
  double per_side;
  uint32_t dimensions;
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
                            .side = side,
                            .per_side = side ? 1.0 / (double)side : 0.0,
                            .dimensions = config->dimensions,
                            .in_cell = asc_jitter_of(side),
                            .in_stratum = asc_jitter_of(config->samples)};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* Four dimensions, two pairs: the random bits of a sample's two cells are one block. */
typedef struct quad {
  uint32_t index;
  int alone[2]; /* the pair lacks its second dimension */
  asc_permutation shuffle[2];
} quad;

static void make_quad(const jittered_state *state, asc_key key, uint32_t index, quad *made) {
  made->index = index;
  for (uint32_t half = 0; half < 2; half++) {
    const uint32_t pair = 2 * index + half;
    made->alone[half] = 2 * pair + 1 == state->dimensions;
    if (pair > 0 && 2 * pair < state->dimensions) asc_permutation_make(&made->shuffle[half], state->samples, key, pair);
  }
}

/* The whole part of cell / side. The half keeps the product away from whole numbers: by half a 2^24th, where its
 * rounding errors stay below 2^-26. */
ASC_INLINE double row_of(double cell, double per_side) { return (double)(int32_t)((cell + 0.5) * per_side); }

/* --- one point ------------------------------------------------------------------------------------------------------
 */

/* The dimensions [begin, end) of the quad. */
static void make_point(const jittered_state *state, const quad *of, asc_key key, uint64_t sample, uint32_t begin,
                       uint32_t end, double *point) {
  const asc_block bits = asc_hash(key, sample, of->index, ASC_PURPOSE_STRATUM);
  const double side = (double)state->side;
  for (uint32_t half = begin / 2; 2 * half < end; half++) {
    const uint32_t x = 2 * half, y = x + 1;
    const double cell = (double)(2 * of->index + half > 0 ? asc_permutation_at(&of->shuffle[half], sample) : sample);
    if (of->alone[half]) {
      *point = (cell + asc_jitter_unit(state->in_stratum, bits.word[x])) / (double)state->samples;
      return;
    }
    const double row = row_of(cell, state->per_side);
    if (x >= begin) *point++ = (cell - row * side + asc_jitter_unit(state->in_cell, bits.word[x])) / side;
    if (y < end) *point++ = (row + asc_jitter_unit(state->in_cell, bits.word[y])) / side;
  }
}

/* --- many at a time -------------------------------------------------------------------------------------------------
 */

ASC_INLINE void cell_columns(const jittered_state *state, const double *cells, const uint32_t *bits_x,
                             const uint32_t *bits_y, double *column_x, double *column_y) {
  const double side = (double)state->side, per_side = state->per_side;
  const asc_jitter jitter = state->in_cell;
  for (int i = 0; i < ASC_LANES; i++) {
    const double row = row_of(cells[i], per_side);
    column_x[i] = (cells[i] - row * side + asc_jitter_unit(jitter, bits_x[i])) / side;
    column_y[i] = (row + asc_jitter_unit(jitter, bits_y[i])) / side;
  }
}

ASC_INLINE void stratum_column(const double *strata, const uint32_t *bits, double count, asc_jitter jitter,
                               double *column) {
  for (int i = 0; i < ASC_LANES; i++) column[i] = (strata[i] + asc_jitter_unit(jitter, bits[i])) / count;
}

/* The columns [begin, end) of one quad of RUN samples or fewer. */
ASC_VECTORISE
static void make_columns(const jittered_state *state, const quad *of, asc_key key, double (*cells)[RUN], uint64_t first,
                         uint32_t count, uint32_t begin, uint32_t end, double *points, size_t stride) {
  for (uint32_t done = 0; done < count; done += ASC_LANES) {
    asc_lanes bits;
    asc_tile tile;
    asc_hash_lanes(key, first + done, of->index, ASC_PURPOSE_STRATUM, &bits);
    for (uint32_t half = begin / 2; 2 * half < end; half++) {
      const uint32_t d = 2 * half;
      if (of->alone[half])
        stratum_column(cells[half] + done, bits.word[d], (double)state->samples, state->in_stratum, tile.column[d]);
      else
        cell_columns(state, cells[half] + done, bits.word[d], bits.word[d + 1], tile.column[d], tile.column[d + 1]);
    }
    const uint32_t rows = count - done < ASC_LANES ? count - done : ASC_LANES;
    asc_tile_write(&tile, begin, end, 0, rows, points + done * stride, stride);
  }
}

static void fill_quad(const jittered_state *state, const asc_range *range, asc_key key, const quad *of, uint32_t begin,
                      uint32_t end, double *points) {
  const size_t stride = range->dimension_count;
  for (size_t done = 0; done < range->sample_count; done += RUN) {
    const uint64_t first = range->first_sample + done;
    const size_t left = range->sample_count - done;
    double cells[2][RUN];
    for (uint32_t half = begin / 2; 2 * half < end; half++)
      if (2 * of->index + half > 0)
        asc_permutation_run(&of->shuffle[half], first, cells[half]);
      else
        for (uint64_t i = 0; i < RUN; i++) cells[half][i] = (double)(first + i);
    make_columns(state, of, key, cells, first, left < RUN ? (uint32_t)left : RUN, begin, end, points + done * stride,
                 stride);
  }
}

#define FEW 4 /* samples that are quicker made one by one */

static asc_status jittered_fill(const void *opaque, const asc_range *range, double *points) {
  const jittered_state *state = opaque;
  const asc_key key = asc_pixel_key(state->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t first = range->first_dimension, past = first + range->dimension_count;
  for (uint32_t q = first / QUAD; q * QUAD < past; q++) {
    const uint32_t begin = q * QUAD < first ? first % QUAD : 0, end = past - q * QUAD < QUAD ? past - q * QUAD : QUAD;
    double *columns = points + (q * QUAD + begin - first);
    quad of;
    make_quad(state, key, q, &of);
    if (range->sample_count > FEW) {
      fill_quad(state, range, key, &of, begin, end, columns);
      continue;
    }
    for (uint32_t i = 0; i < range->sample_count; i++)
      make_point(state, &of, key, range->first_sample + i, begin, end, columns + (size_t)i * range->dimension_count);
  }
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

/* N rooks: N points of which no two share a row or column of the N x N grid, in any two dimensions; a Latin hypercube.
 *
 * Source: Shirley 1991, "Discrepancy as a quality measure for sample distributions",
 * Eurographics 1991; McKay, Beckman, Conover 1979, "A comparison of three methods for selecting values of input
 * variables in the analysis of output from a computer code". Point i lies in cell p_d(i) of dimension d, p_d a random
 * permutation: in the first dimension too, so that each point by itself is uniform in every dimension.
 *
 * A uniform place in the cell; centred=1: its centre; corner=1: its lower end, the lattice i/N (which is biased by half
 * a cell, as the rule of left corners is). */
#include <stdlib.h>

#include "pattern.h"
#include "permutation.h"
#include "tile.h"

#define QUAD ASC_TILE_COLUMNS
#define RUN ASC_PERMUTATION_RUN

typedef struct n_rooks_state {
  uint64_t samples, seed_mix;
  uint32_t dimensions;
  int jittered;
  double offset; /* in the cell, where not jittered */
  asc_jitter jitter;
} n_rooks_state;

static asc_status n_rooks_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const int centred = config->values[0] != 0.0, corner = config->values[1] != 0.0;
  if (centred && corner)
    return asc_fail(error, ASC_INVALID_VALUE, "n-rooks: points lie at the centre or the corner: say one of them");
  if (config->samples > ASC_JITTER_CELLS) return asc_fail(error, ASC_UNSUPPORTED, "n-rooks has at most 2^48 points");
  n_rooks_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "n-rooks: out of memory");
  *state = (n_rooks_state){.samples = config->samples,
                           .seed_mix = asc_seed_mix(config->seed),
                           .dimensions = config->dimensions,
                           .jittered = !centred && !corner,
                           .offset = centred ? 0.5 : 0.0,
                           .jitter = asc_jitter_of(config->samples)};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* Four dimensions. */
typedef struct quad {
  asc_permutation permutation[QUAD];
  uint64_t start[QUAD / 2]; /* of the random bits of the samples in two dimensions */
} quad;

/* Those in [begin, end). */
static void make_quad(const n_rooks_state *state, asc_key key, uint32_t index, uint32_t begin, uint32_t end,
                      quad *made) {
  for (uint32_t d = begin; d < end; d++)
    asc_permutation_make(&made->permutation[d], state->samples, key, index * QUAD + d);
  for (uint32_t half = 0; half < QUAD / 2; half++)
    made->start[half] = asc_draw(key, index * QUAD / 2 + half, ASC_PURPOSE_STRATUM);
}

/* The columns [begin, end) of one quad of one sample. */
ASC_VECTORISE
static void make_point(const n_rooks_state *state, asc_key key, uint32_t quad_index, uint64_t sample, uint32_t begin,
                       uint32_t end, double *point) {
  const uint32_t past = quad_index * QUAD + end;
  uint64_t bits = 0;
  for (uint32_t d = quad_index * QUAD + begin; d < past; d++, point++) {
    const double cell = (double)asc_permutation_image(state->samples, key, d, sample);
    if (!state->jittered) {
      *point = (cell + state->offset) / (double)state->samples;
      continue;
    }
    if (d % 2 == 0 || d == quad_index * QUAD + begin)
      bits = asc_draw_at(asc_draw(key, d / 2, ASC_PURPOSE_STRATUM), sample);
    *point = asc_jitter_place(state->jitter, cell, (uint32_t)(d % 2 ? bits : bits >> 32));
  }
}

ASC_INLINE void jitter_column(asc_jitter jitter, const double *cells, const uint32_t *bits, double *column) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) column[i] = asc_jitter_place(jitter, cells[i], bits[i]);
}

ASC_INLINE void offset_column(const double *cells, double offset, double count, double *column) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) column[i] = (cells[i] + offset) / count;
}

/* The columns [begin, end) of one quad of RUN samples or fewer. */
ASC_VECTORISE
static void make_columns(const n_rooks_state *state, const quad *of, double (*cells)[RUN], uint64_t first,
                         uint32_t count, uint32_t begin, uint32_t end, double *points, size_t stride) {
  for (uint32_t done = 0; done < count; done += ASC_LANES) {
    asc_tile tile;
    uint32_t bits[QUAD][ASC_LANES];
    for (size_t half = begin / 2; state->jittered && 2 * half < end; half++)
      asc_draw_lanes(of->start[half], first + done, bits[2 * half], bits[2 * half + 1]);
    for (uint32_t d = begin; d < end; d++)
      if (state->jittered)
        jitter_column(state->jitter, cells[d] + done, bits[d], tile.column[d]);
      else
        offset_column(cells[d] + done, state->offset, (double)state->samples, tile.column[d]);
    const uint32_t rows = count - done < ASC_LANES ? count - done : ASC_LANES;
    asc_tile_write(&tile, begin, end, 0, rows, points + done * stride, stride);
  }
}

#define FEW 4 /* samples that are quicker made one by one */

ASC_APART void fill_range(const n_rooks_state *state, const asc_range *range, asc_key key, double *points) {
  const uint32_t low = range->first_dimension, past = low + range->dimension_count;
  const size_t count = range->sample_count, stride = range->dimension_count;
  for (uint32_t q = low / QUAD; q * QUAD < past; q++) {
    const uint32_t begin = q * QUAD < low ? low % QUAD : 0, end = past - q * QUAD < QUAD ? past - q * QUAD : QUAD;
    double *columns = points + (q * QUAD + begin - low), cells[QUAD][RUN];
    for (size_t i = 0; i < count && count <= FEW; i++)
      make_point(state, key, q, range->first_sample + i, begin, end, columns + i * stride);
    if (count <= FEW) continue;
    quad of;
    make_quad(state, key, q, begin, end, &of);
    for (size_t done = 0; done < count; done += RUN) {
      const uint64_t first = range->first_sample + done;
      for (uint32_t d = begin; d < end; d++) asc_permutation_run(&of.permutation[d], first, cells[d]);
      make_columns(state, &of, cells, first, count - done < RUN ? (uint32_t)(count - done) : RUN, begin, end,
                   columns + done * stride, stride);
    }
  }
}

static asc_status n_rooks_fill(const void *opaque, const asc_range *range, double *points) {
  const n_rooks_state *state = opaque;
  const asc_key key = asc_pixel_key(state->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t begin = range->first_dimension % QUAD, end = begin + range->dimension_count;
  if (range->sample_count == 1 && end <= QUAD)
    make_point(state, key, range->first_dimension / QUAD, range->first_sample, begin, end, points);
  else
    fill_range(state, range, key, points);
  return ASC_OK;
}

static const asc_parameter n_rooks_parameters[] = {
    {"centred", ASC_INTEGER, NULL, 0, 1, 0, "1: at the centres of the cells"},
    {"corner", ASC_INTEGER, NULL, 0, 1, 0, "1: at the lower corners of the cells, on the lattice i/N"},
};

const asc_sampler_interface asc_sampler_n_rooks = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "n-rooks",
    .title = "a random permutation in each dimension",
    .source = "Shirley 1991; McKay, Beckman, Conover 1979",
    .parameters = n_rooks_parameters,
    .parameter_count = 2,
    .create = n_rooks_create,
    .destroy = free,
    .fill = n_rooks_fill,
};

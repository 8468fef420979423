/* Sobol's sequence in base 2, natural order, index 0 kept.
 *
 * Source: Sobol 1967; directions of Joe and Kuo 2008, "Constructing Sobol sequences with better two-dimensional
 * projections" (new-joe-kuo-6). scramble:
 *   shift   each dimension of each pixel moved modulo 1 (Cranley and Patterson 1976)
 *   digit   a random digital shift: the same 32 random bits XOR-ed to all points of a dimension and pixel
 *   owen    nested uniform scrambling (Owen 1995) by the hash of owen.h, which says how uniform it is: all 128 ways of
 *           flipping the first three digits equally often, in each dimension. Any such hash keeps nets nets; the tests
 *           hold that.
 *   owen-full  the same with a flip of its own for every prefix of digits, by owen_full.h: all 2^32 - 1 ways of each
 *           dimension independent, at some times the cost.
 * Values have 32 bits: they are multiples of 2^-32 (but for shift). */
#include <stdlib.h>
#include <string.h>

#include "owen.h"
#include "owen_full.h"
#include "pattern.h"
#include "sobol_directions.h"
#include "tile.h"
#if ASC_HAS_LEVELS
#include <immintrin.h>
#endif

#define BITS 32
#define BYTES 4
#define QUAD ASC_TILE_COLUMNS

enum { SCRAMBLE_NONE, SCRAMBLE_SHIFT, SCRAMBLE_DIGIT, SCRAMBLE_OWEN, SCRAMBLE_OWEN_FULL };

/* Four dimensions. A point's bits are the XOR of the directions of its index's bits: `byte` has those XORs for the 256
 * values of each eight bits of an index, the four dimensions side by side; `low` has them again for the lowest four
 * bits, a dimension at a time, since points are also made ASC_LANES = 16 at a time. For owen all are stored reversed.
 */
typedef struct quad {
  uint32_t byte[BYTES][256][QUAD];
  uint32_t low[QUAD][ASC_LANES];
} quad;

typedef struct sobol_state {
  uint64_t seed_mix;
  int scramble;
  quad quads[];
} sobol_state;

/* Bratley and Fox 1988, Algorithm 659: m_k = 2 a_1 m_(k-1) ^ ... ^ 2^(s-1) a_(s-1) m_(k-s+1) ^ 2^s m_(k-s) ^ m_(k-s) */
static void make_directions(uint32_t dimension, uint32_t direction[BITS]) {
  if (dimension == 0) {
    for (uint32_t k = 0; k < BITS; k++) direction[k] = 1u << (BITS - 1 - k);
    return;
  }
  const asc_sobol_polynomial *polynomial = &asc_sobol_polynomials[dimension];
  const uint32_t degree = polynomial->degree;
  const uint32_t *initial = asc_sobol_initial + polynomial->first;
  for (uint32_t k = 0; k < BITS; k++) {
    if (k < degree) {
      direction[k] = initial[k] << (BITS - 1 - k);
      continue;
    }
    uint32_t v = direction[k - degree] ^ (direction[k - degree] >> degree);
    for (uint32_t j = 1; j < degree; j++)
      if ((polynomial->coefficients >> (degree - 1 - j)) & 1u) v ^= direction[k - j];
    direction[k] = v;
  }
}

static void make_quad(quad *made, uint32_t first_dimension, uint32_t dimensions, int reversed) {
  memset(made, 0, sizeof *made);
  for (uint32_t d = 0; d < QUAD && first_dimension + d < dimensions; d++) {
    uint32_t direction[BITS];
    make_directions(first_dimension + d, direction);
    for (uint32_t bit = 0; bit < BITS; bit++) {
      const uint32_t added = reversed ? asc_reverse_bits(direction[bit]) : direction[bit], half = 1u << bit % 8;
      for (uint32_t i = 0; i < half; i++) made->byte[bit / 8][half + i][d] = made->byte[bit / 8][i][d] ^ added;
    }
    for (uint32_t i = 0; i < ASC_LANES; i++) made->low[d][i] = made->byte[0][i][d];
  }
}

static asc_status sobol_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions > ASC_SOBOL_DIMENSIONS)
    return asc_fail(error, ASC_UNSUPPORTED, "sobol has at most %d dimensions", ASC_SOBOL_DIMENSIONS);
  if (config->samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "sobol has 32 bits, so at most 2^32 points");
  const uint32_t quads = (config->dimensions + QUAD - 1) / QUAD;
  sobol_state *state = malloc(sizeof *state + quads * sizeof(quad));
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "sobol: out of memory");
  state->seed_mix = asc_seed_mix(config->seed);
  state->scramble = (int)config->values[0];
  for (uint32_t q = 0; q < quads; q++)
    make_quad(&state->quads[q], q * QUAD, config->dimensions, state->scramble == SCRAMBLE_OWEN);
  const uint32_t randomised = state->scramble == SCRAMBLE_NONE ? 0 : ASC_TRAIT_RANDOMISED;
  *made = (asc_sampler_state){state, ASC_TRAIT_SEQUENCE | randomised, ASC_NET_END};
  return ASC_OK;
}

/* The random bits of the four dimensions of a quad, for digit. */
ASC_INLINE void draw_bits(asc_key key, uint32_t quad_index, uint32_t bits[QUAD]) {
  for (uint32_t d = 0; d < QUAD; d += 2) {
    const uint64_t drawn = asc_draw(key, (quad_index * QUAD + d) / 2, ASC_PURPOSE_SCRAMBLE);
    bits[d] = (uint32_t)drawn;
    bits[d + 1] = (uint32_t)(drawn >> 32);
  }
}
/* What owen_full.h takes for a dimension of a quad. */
ASC_INLINE uint64_t full_start(asc_key key, uint32_t quad_index, uint32_t dimension) {
  return asc_draw(key, quad_index * QUAD + dimension, ASC_PURPOSE_SCRAMBLE);
}

/* The XOR of the directions of an index's bits. */
ASC_INLINE void add_directions(const quad *of, uint32_t index, uint32_t bits[QUAD]) {
  for (uint32_t k = 0; k < BYTES; k++)
    for (uint32_t d = 0; d < QUAD; d++) bits[d] ^= of->byte[k][(index >> (8 * k)) & 255u][d];
}

/* --- owen, four values at a time
 * ------------------------------------------------------------------------------------------------------
 */

/* A part of the columns of one quad: the columns [begin, begin + width), width 1, 2 or 4, of the samples [first, last],
 * of pixels one after the other. */
typedef struct owen_run {
  const quad *of;
  uint32_t quad_index, begin, width, first, last;
  double *points;
  size_t stride;
  const asc_key *keys;
  size_t pixels;
} owen_run;

#define FOUR(name) name##_baseline
#include "sobol_owen.h"
#if ASC_HAS_LEVELS
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v3")
#define FOUR(name) name##_v3
#include "sobol_owen.h"
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
#include "sobol_owen_sixteen.h"
#pragma GCC pop_options
#endif

/* --- one point ------------------------------------------------------------------------------------------------------
 */

/* All four dimensions of one point, not scrambled by owen (but by owen-full). */
ASC_VECTORISE
static void make_plain_point(const quad *of, uint32_t quad_index, uint32_t index, int scramble, asc_key key,
                             double values[QUAD]) {
  uint32_t bits[QUAD] = {0}, random[QUAD] = {0};
  add_directions(of, index, bits);
  if (scramble == SCRAMBLE_DIGIT) draw_bits(key, quad_index, random);
  if (scramble == SCRAMBLE_OWEN_FULL)
    for (uint32_t d = 0; d < QUAD; d++) bits[d] = asc_owen_full(bits[d], full_start(key, quad_index, d));
  for (uint32_t d = 0; d < QUAD; d++) values[d] = asc_unit_of_bits(bits[d] ^ random[d]);
  if (scramble == SCRAMBLE_SHIFT)
    for (uint32_t d = 0; d < QUAD; d++) values[d] = asc_rotate(values[d], asc_rotation(key, quad_index * QUAD + d));
}

ASC_INLINE void make_point(const quad *of, uint32_t quad_index, uint32_t index, int scramble, asc_key key,
                           double values[QUAD]) {
  if (scramble != SCRAMBLE_OWEN) make_plain_point(of, quad_index, index, scramble, key, values);
#if ASC_HAS_LEVELS
  else if (ASC_TAKES_V3)
    owen_point_v3(of, quad_index, index, key, values);
#endif
  else
    owen_point_baseline(of, quad_index, index, key, values);
}

/* --- many at a time -------------------------------------------------------------------------------------------------
 */

ASC_INLINE void plain_column(const uint32_t low[ASC_LANES], uint32_t high, double values[ASC_LANES]) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) values[i] = asc_unit_of_bits(high ^ low[i]);
}

ASC_INLINE void full_column(const uint32_t low[ASC_LANES], uint32_t high, uint64_t start, double values[ASC_LANES]) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) values[i] = asc_unit_of_bits(asc_owen_full(high ^ low[i], start));
}

ASC_INLINE void rotate_column(double shift, double values[ASC_LANES]) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) values[i] = asc_rotate(values[i], shift);
}

/* The columns [begin, end) of one quad of the samples [first, last], not scrambled by owen (but by owen-full). */
ASC_VECTORISE
static void make_columns(const quad *of, uint32_t quad_index, int scramble, asc_key key, uint32_t begin, uint32_t end,
                         uint32_t first, uint32_t last, double *points, size_t stride) {
  uint32_t random[QUAD] = {0};
  double shift[QUAD];
  uint64_t start[QUAD];
  const int full = scramble == SCRAMBLE_OWEN_FULL;
  if (scramble == SCRAMBLE_DIGIT) draw_bits(key, quad_index, random);
  for (uint32_t d = 0; d < QUAD; d++) shift[d] = asc_rotation(key, quad_index * QUAD + d);
  for (uint32_t d = 0; d < QUAD && full; d++) start[d] = full_start(key, quad_index, d);
  for (uint32_t block = first / ASC_LANES; block <= last / ASC_LANES; block++) {
    asc_tile tile;
    uint32_t high[QUAD] = {0};
    add_directions(of, block * ASC_LANES, high);
    for (uint32_t d = begin; d < end && full; d++) full_column(of->low[d], high[d], start[d], tile.column[d]);
    for (uint32_t d = begin; d < end && !full; d++) plain_column(of->low[d], high[d] ^ random[d], tile.column[d]);
    for (uint32_t d = begin; d < end && scramble == SCRAMBLE_SHIFT; d++) rotate_column(shift[d], tile.column[d]);
    const uint32_t from = block == first / ASC_LANES ? first % ASC_LANES : 0;
    const uint32_t to = block == last / ASC_LANES ? last % ASC_LANES + 1 : ASC_LANES;
    asc_tile_write(&tile, begin, end, from, to, points, stride);
    points += (to - from) * stride;
  }
}

/* The same by owen, of pixels one after the other. */
static void make_owen_columns(owen_run run, uint32_t begin, uint32_t end) {
  for (uint32_t d = begin; d < end; d += run.width, run.points += run.width) {
    run.begin = d;
    run.width = end - d == 4 ? 4 : end - d >= 2 ? 2 : 1;
#if ASC_HAS_LEVELS
    if (ASC_TAKES_V4) {
      owen_rows_v4(&run);
      continue;
    }
#endif
    owen_run one = run;
    for (size_t i = 0; i < run.pixels; i++, one.points += run.stride * (run.last - run.first + 1)) {
#if ASC_HAS_LEVELS
      if (ASC_TAKES_V3) {
        owen_rows_v3(&one, run.keys[i]);
        continue;
      }
#endif
      owen_rows_baseline(&one, run.keys[i]);
    }
  }
}

/* `keys`: of pixels, one after the other, of which all but owen take one. */
static void fill_many(const sobol_state *state, const asc_range *range, const asc_key *keys, size_t pixels,
                      double *points) {
  const uint32_t first = (uint32_t)range->first_sample, last = (uint32_t)(first + range->sample_count - 1);
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  const size_t stride = range->dimension_count;
  for (uint32_t q = begin / QUAD; q * QUAD < end; q++) {
    const uint32_t from = q * QUAD < begin ? begin % QUAD : 0, to = end - q * QUAD < QUAD ? end - q * QUAD : QUAD;
    double *columns = points + (q * QUAD + from - begin);
    const quad *of = &state->quads[q];
    if (state->scramble == SCRAMBLE_OWEN)
      make_owen_columns((owen_run){of, q, 0, 0, first, last, columns, stride, keys, pixels}, from, to);
    else
      make_columns(of, q, state->scramble, *keys, from, to, first, last, columns, stride);
  }
}

/* The dimensions [begin, end) of one point. */
static void fill_one(const sobol_state *state, uint32_t begin, uint32_t end, uint32_t index, asc_key key,
                     double *point) {
  for (uint32_t q = begin / QUAD; q * QUAD < end; q++) {
    const uint32_t from = q * QUAD < begin ? begin % QUAD : 0, to = end - q * QUAD < QUAD ? end - q * QUAD : QUAD;
    double values[QUAD];
    make_point(&state->quads[q], q, index, state->scramble, key, values);
    for (uint32_t d = from; d < to; d++) *point++ = values[d];
  }
}

#define FEW 4 /* samples that are quicker made one by one than as part of a block */

ASC_APART void fill_range(const sobol_state *state, const asc_range *range, asc_key key, double *points) {
  const uint32_t begin = range->first_dimension, count = range->dimension_count, index = (uint32_t)range->first_sample;
  if (range->sample_count > FEW) {
    fill_many(state, range, &key, 1, points);
    return;
  }
  for (uint32_t i = 0; i < range->sample_count; i++)
    fill_one(state, begin, begin + count, index + i, key, points + (size_t)i * count);
}

static asc_status sobol_fill(const void *opaque, const asc_range *range, double *points) {
  const sobol_state *state = opaque;
  const asc_key key = asc_pixel_key(state->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t q = range->first_dimension / QUAD, from = range->first_dimension % QUAD;
  if (range->sample_count != 1 || from + range->dimension_count > QUAD) {
    fill_range(state, range, key, points);
    return ASC_OK;
  }
  const uint32_t index = (uint32_t)range->first_sample;
  if (range->dimension_count == QUAD) {
    make_point(&state->quads[q], q, index, state->scramble, key, points);
    return ASC_OK;
  }
  double values[QUAD];
  make_point(&state->quads[q], q, index, state->scramble, key, values);
  asc_copy_few(values + from, range->dimension_count, points);
  return ASC_OK;
}

#define TOGETHER 16 /* pixels */

static asc_status sobol_fill_pixels(const void *opaque, const asc_range *range, size_t pixels, double *points) {
  const sobol_state *state = opaque;
  const size_t values = range->sample_count * range->dimension_count;
  const int together = state->scramble == SCRAMBLE_OWEN && range->sample_count > FEW;
  asc_range at = *range;
  for (size_t done = 0, count; done < pixels; done += count, points += count * values) {
    count = !together ? 1 : pixels - done < TOGETHER ? pixels - done : TOGETHER;
    at.pixel_x = range->pixel_x + (int32_t)done;
    if (!together) {
      (void)sobol_fill(state, &at, points);
      continue;
    }
    asc_key keys[TOGETHER];
    for (size_t i = 0; i < count; i++) keys[i] = asc_pixel_key(state->seed_mix, at.pixel_x + (int32_t)i, at.pixel_y);
    fill_many(state, &at, keys, count, points);
  }
  return ASC_OK;
}

static const asc_parameter sobol_parameters[] = {
    {"scramble", ASC_CHOICE, "none|shift|digit|owen|owen-full", 0, 0, SCRAMBLE_NONE,
     "none, a random shift modulo 1, a random digital shift, or Owen's nested uniform scrambling: by a hash, or with "
     "each "
     "of its flips drawn"},
};

const asc_sampler_interface asc_sampler_sobol = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "sobol",
    .title = "Sobol's sequence, Joe and Kuo's directions",
    .source = "Sobol 1967; Joe and Kuo 2008; Owen 1995; Laine and Karras 2011",
    .parameters = sobol_parameters,
    .parameter_count = 1,
    .create = sobol_create,
    .destroy = free,
    .fill = sobol_fill,
    .fill_pixels = sobol_fill_pixels,
};

/* Progressive multi-jittered (0,2)-sequences in base 2: of any aligned run of 2^m points, every elementary interval of
 * 2^-a x 2^-(m-a) holds one. A point is put in a stratum that is free, at random within it.
 *
 * Source: Christensen, Kensler, Kilpatrick 2018, "Progressive multi-jittered sample sequences"; Pharr 2019, "Efficient
 * generation of points that satisfy two-dimensional elementary intervals"; Helmer, Christensen, Kensler 2021,
 * "Stochastic generation of (t, s) sample sequences".
 *
 * Which strata are free? Let the first 2^m points be there, and q be one of the next 2^m. In each elementary interval
 * of area 2^-m there is one point p already, and q must lie in the other half, both ways of halving. The column of q,
 * 2^-m wide, so gives its digit m+1 of x and its digit 1 of y; then the interval 2^-(m-1) x 1/2 gives digit 2 of y, and
 * so on: the column of q and the points that are there give m+1 digits of its y. So as a set of strata the next 2^m
 * points are forced; at random are only the digits below, and the order: which of the two free quarters of a cell comes
 * first. Sobol's first two dimensions are such a sequence (x the radical inverse, y that of Pascal's matrix mod 2 times
 * the index), so every one is Sobol's, with the digits that each point has below its stratum drawn anew, in an order
 * drawn anew. That is nested uniform scrambling (Owen 1995), of the digits of x, of y, and of the index (from its
 * highest digit, so that aligned runs stay aligned runs); Helmer et al. say the same of the digits.
 *
 * So it is done here, without a table and so without a table's end: the digits of x and of y by the hash of owen.h, and
 * the order by a hash like it, on the index with its highest digit first, that has what makes products of three digits
 * as well: all 2^11 orders of the points 2 to 15, each within its own generation, are equally likely to within the
 * tests' sight, of 65,536 pixels.
 *
 * Beside sobol:scramble=owen: as sets, runs of 2^m points of its first two dimensions have this distribution; it has
 * Sobol's order, and one sequence of all dimensions, of which only some pairs are (0,2)-sequences. Here (0,1), (2,3),
 * ... are independent sequences, each (0,2), in orders of their own, as many as one likes, with no quality in the
 * projections to other pairs but that of independent strata.
 *
 * The order turns the place of index 0 too, and all others by the same bits, which changes nothing in distribution, as
 * it turns all x and y by the same digits. Values have 32 bits. */
#include <stdlib.h>
#include <string.h>

#include "owen.h"
#include "pattern.h"
#include "tile.h"
#if ASC_HAS_LEVELS
#include <immintrin.h>
#endif

#define QUAD ASC_TILE_COLUMNS

typedef struct pmj02_state {
  uint64_t seed_mix;
} pmj02_state;

static asc_status pmj02_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "pmj02 has 32 bits, so at most 2^32 points");
  pmj02_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "pmj02: out of memory");
  state->seed_mix = asc_seed_mix(config->seed);
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED | ASC_TRAIT_SEQUENCE, ASC_NET_END};
  return ASC_OK;
}

/* The columns [begin, end) of pair number `pair`, 0 <= begin < end <= 2, of the samples first ... last. */
typedef struct pair_run {
  uint32_t pair, begin, end, first, last;
  double *points;
  size_t stride;
} pair_run;

#define FOUR(name) name##_baseline
#include "pmj02_four.h"
#if ASC_HAS_LEVELS
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v3")
#define FOUR(name) name##_v3
#include "pmj02_four.h"
#pragma GCC pop_options
#endif

/* Both pairs of a quad of one sample. */
ASC_INLINE void make_point(asc_key key, uint32_t quad, uint32_t index, double values[QUAD]) {
#if ASC_HAS_LEVELS
  if (ASC_TAKES_V3) {
    point_v3(key, quad, index, values);
    return;
  }
#endif
  point_baseline(key, quad, index, values);
}

static void make_rows(asc_key key, const pair_run *run) {
#if ASC_HAS_LEVELS
  if (ASC_TAKES_V3) {
    rows_v3(key, run);
    return;
  }
#endif
  rows_baseline(key, run);
}

#define FEW 4 /* samples that are quicker made one by one */

ASC_APART void fill_range(const asc_range *range, asc_key key, double *points) {
  const uint32_t begin = range->first_dimension, stride = range->dimension_count, end = begin + stride;
  const uint32_t first = (uint32_t)range->first_sample, last = (uint32_t)(first + range->sample_count - 1);
  if (range->sample_count > FEW) {
    for (uint32_t pair = begin / 2; 2 * pair < end; pair++) {
      const uint32_t from = 2 * pair < begin ? 1 : 0, to = end - 2 * pair < 2 ? 1 : 2;
      make_rows(key, &(pair_run){pair, from, to, first, last, points + (2 * pair + from - begin), stride});
    }
    return;
  }
  for (uint32_t i = 0; i < range->sample_count; i++)
    for (uint32_t q = begin / QUAD; q * QUAD < end; q++) {
      double values[QUAD];
      make_point(key, q, first + i, values);
      for (uint32_t d = 0; d < QUAD; d++)
        if (q * QUAD + d >= begin && q * QUAD + d < end) *points++ = values[d];
    }
}

static asc_status pmj02_fill(const void *opaque, const asc_range *range, double *points) {
  const pmj02_state *state = opaque;
  const asc_key key = asc_pixel_key(state->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t from = range->first_dimension % QUAD, count = range->dimension_count;
  if (range->sample_count != 1 || from + count > QUAD) {
    fill_range(range, key, points);
    return ASC_OK;
  }
  double values[QUAD];
  make_point(key, range->first_dimension / QUAD, (uint32_t)range->first_sample, values);
  asc_copy_few(values + from, count, points);
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_pmj02 = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "pmj02",
    .title = "progressive multi-jittered (0,2)-sequence",
    .source = "Christensen, Kensler, Kilpatrick 2018; Helmer, Christensen, Kensler 2021",
    .create = pmj02_create,
    .destroy = free,
    .fill = pmj02_fill,
};

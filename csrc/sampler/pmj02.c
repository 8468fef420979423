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
 * So it is done here: each node of each of the three trees has a bit of its own from a hash. A node is the digits
 * before a digit; all digits that a point is the first to enter come from one word.
 *
 * Beside sobol:scramble=owen: as sets, runs of 2^m points of its first two dimensions have this distribution, as far as
 * its scrambling is uniform; it has Sobol's order, and one sequence of all dimensions, of which only some pairs are
 * (0,2)-sequences. Here (0,1), (2,3), ... are independent sequences, each (0,2), in orders of their own, as many as one
 * likes, with no quality in the projections to other pairs but that of independent strata.
 *
 * The order keeps index 0 where it is, which changes nothing in distribution (turning all indices by the same bits
 * turns all x and y by the same digits) and keeps each run 2^m ... 2^(m+1) - 1 in place. Values have 32 bits. */
#include <stdlib.h>

#include "lanes.h"
#include "vectorise.h"

#define BITS 32
#define MOST_TABLE_BITS 10 /* 4 KiB for each coordinate, within the first-level cache */

typedef struct pmj02_state {
  uint64_t seed;
} pmj02_state;

static asc_status pmj02_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "pmj02 has 32 bits, so at most 2^32 points");
  pmj02_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "pmj02: out of memory");
  state->seed = config->seed;
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED | ASC_TRAIT_SEQUENCE, ASC_NET_END};
  return ASC_OK;
}

/* The keys of the trees of one pair of dimensions of one pixel. */
typedef struct pair_keys {
  asc_key coordinate[2], order;
} pair_keys;

/* One block for seed, pixel and pair, not two by way of the stream's key: that is half the time of a single point. */
static pair_keys keys_of(uint64_t seed, const asc_range *range, uint32_t pair) {
  const uint32_t counter[4] = {(uint32_t)range->pixel_x, (uint32_t)range->pixel_y, pair, ASC_PURPOSE_SCRAMBLE};
  const uint32_t seed_words[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
  const asc_block block = asc_philox(counter, seed_words);
  const uint32_t *word = block.word;
  /* The sum of two keys is independent of each of them. */
  return (pair_keys){{{{word[0], word[1]}}, {{word[2], word[3]}}}, {{word[0] + word[2], word[1] + word[3]}}};
}

/* The bits of the nodes that share `prefix`: a mixer of two multiplications, like those of MurmurHash3 and of Wellons
 * 2018, "Prospecting for hash functions", but that the first multiplier is random: with both fixed, bits of
 * neighbouring nodes were seen to depend on each other (by 0.4 %). */
static inline uint32_t draw(asc_key key, uint32_t prefix) {
  uint32_t x = prefix ^ key.word[0];
  x ^= x >> 16;
  x *= key.word[1] | 1u;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}

/* Which digits of a number turn, the leading one in the highest bit; `digits` is the number reversed, so that the
 * digits before the p-th are its lowest p - 1 bits. */
static inline uint32_t turned_digits(asc_key key, uint32_t digits) {
  uint32_t turned = 0;
  for (uint32_t p = 0; p < BITS; p++) turned |= draw(key, digits & ((1u << p) - 1u)) & (0x80000000u >> p);
  return turned;
}

/* Pascal's matrix mod 2 times the digits of an index: digit k is the sum of those digits m of which k is a subset, as
 * bits (Lucas). Its reverse is Sobol's second dimension. */
static inline uint32_t times_pascal(uint32_t x) {
  x ^= (x >> 1) & 0x55555555u;
  x ^= (x >> 2) & 0x33333333u;
  x ^= (x >> 4) & 0x0f0f0f0fu;
  x ^= (x >> 8) & 0x00ff00ffu;
  return x ^ ((x >> 16) & 0x0000ffffu);
}

/* One point. */
ASC_VECTORISE
static void make_point(const pair_keys *keys, uint32_t index, uint32_t digits[2]) {
  const uint32_t turned = turned_digits(keys->order, asc_reverse_bits(index)) ^ draw(keys->order, 0);
  const uint32_t place = index ^ turned, pascal = times_pascal(place);
  digits[0] = asc_reverse_bits(place) ^ turned_digits(keys->coordinate[0], place);
  digits[1] = asc_reverse_bits(pascal) ^ turned_digits(keys->coordinate[1], pascal);
}

/* Many points: the coordinates of the first 2^bits places are in a table, and a run of indices shares all but its
 * lowest digits. */
typedef struct coordinate_table {
  uint32_t bits, digits[1u << MOST_TABLE_BITS];
} coordinate_table;

/* Each place's coordinate from that in whose stratum it must lie: the digits before its own are those of the place
 * without its highest bit, but for the last, and its own are drawn. */
ASC_VECTORISE
static void make_table(asc_key key, coordinate_table *table) {
  table->digits[0] = draw(key, 0);
  for (uint32_t m = 0; m < table->bits; m++) {
    const uint32_t count = 1u << m, last = 0x80000000u >> m, own = last - 1u;
    const uint32_t *restrict before = table->digits;
    uint32_t *restrict next = table->digits + count;
    for (uint32_t i = 0; i < count; i++) next[i] = ((before[i] & ~own) ^ last) | (draw(key, count + i) & own);
  }
}

/* The places of the indices begin + i 2^shift, whose digits before bit shift + 4 are in `shared` already, and of which
 * the next four are to be known. */
static inline void make_places(asc_key key, uint32_t begin, uint32_t shift, uint32_t shared,
                               uint32_t places[ASC_LANES]) {
  static const uint32_t reversed[ASC_LANES] = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  const uint32_t above = asc_reverse_bits(begin), four = 15u << shift, common = shared ^ (draw(key, 0) & four);
  uint32_t turned[ASC_LANES] = {0};
  for (uint32_t p = BITS - 4 - shift, end = p + 4; p < end; p++)
    for (uint32_t i = 0; i < ASC_LANES; i++)
      turned[i] |= draw(key, (above | reversed[i] << (BITS - 4 - shift)) & ((1u << p) - 1u)) & (0x80000000u >> p);
  for (uint32_t i = 0; i < ASC_LANES; i++) places[i] = common ^ i << shift ^ turned[i];
}

/* The coordinates of the places `begin` ... `begin` + 15, or of 16 products with Pascal's matrix. From the highest bit
 * to the table's, each bit that is set draws the digits after it. */
static inline void make_coordinates(asc_key key, const coordinate_table *table, uint32_t begin,
                                    double values[ASC_LANES]) {
  const uint32_t below = (1u << table->bits) - 1u;
  const uint32_t *known = table->digits + (begin & below);
  uint32_t digits[ASC_LANES] = {0}, open = UINT32_MAX, last = 0;
  for (uint32_t rest = begin & ~below; rest;) {
    const uint32_t m = BITS - 1 - (uint32_t)__builtin_clz(rest);
    const uint32_t own = (0x80000000u >> m) - 1u, prefix = begin & ((2u << m) - 1u);
    for (uint32_t i = 0; i < ASC_LANES; i++) digits[i] |= draw(key, prefix + i) & open & own;
    last |= 0x80000000u >> m;
    open = ~own;
    rest ^= 1u << m;
  }
  for (int i = 0; i < ASC_LANES; i++) values[i] = (double)((digits[i] | (known[i] & open)) ^ last) * 0x1p-32;
}

/* A run of points: those coordinates of which there is a table, in the order of places (of products with Pascal's
 * matrix), and where each index finds its own. */
typedef struct coordinate_run {
  double values[2][ASC_LANES];
  uint32_t at[2][ASC_LANES];
} coordinate_run;

/* What the places of each of the 16 runs from `begin`, a multiple of 256, share. */
ASC_VECTORISE
static void make_group(asc_key key, uint32_t begin, uint32_t shared[ASC_LANES]) {
  const uint32_t turned = turned_digits(key, asc_reverse_bits(begin)) ^ draw(key, 0);
  make_places(key, begin, 4, (begin ^ turned) & ~255u, shared);
}

ASC_VECTORISE
static void make_run(const pair_keys *keys, const coordinate_table *const tables[2], uint32_t begin, uint32_t shared,
                     coordinate_run *run) {
  uint32_t places[ASC_LANES];
  make_places(keys->order, begin, 0, shared, places);
  const uint32_t lowest = ASC_LANES - 1, pascal = times_pascal(shared);
  for (uint32_t i = 0; i < ASC_LANES; i++) {
    run->at[0][i] = places[i] & lowest;
    run->at[1][i] = times_pascal(run->at[0][i]) ^ (pascal & lowest); /* the product is linear */
  }
  if (tables[0]) make_coordinates(keys->coordinate[0], tables[0], shared, run->values[0]);
  if (tables[1]) make_coordinates(keys->coordinate[1], tables[1], pascal & ~lowest, run->values[1]);
}

static void fill_one_by_one(const asc_range *range, const pair_keys *keys, uint32_t pair, double *points) {
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  for (size_t i = 0; i < range->sample_count; i++) {
    uint32_t digits[2];
    make_point(keys, (uint32_t)(range->first_sample + i), digits);
    for (uint32_t half = 0; half < 2; half++) {
      const uint32_t dimension = 2 * pair + half;
      if (dimension >= begin && dimension < end)
        points[i * range->dimension_count + (dimension - begin)] = digits[half] * 0x1p-32;
    }
  }
}

static void fill_in_runs(const asc_range *range, const pair_keys *keys, uint32_t pair, double *points) {
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  coordinate_table space[2];
  const coordinate_table *tables[2] = {NULL, NULL};
  for (uint32_t half = 0; half < 2; half++) {
    const uint32_t dimension = 2 * pair + half;
    if (dimension < begin || dimension >= end) continue;
    uint32_t bits = 4;
    while (bits < MOST_TABLE_BITS && range->sample_count >> (bits + 1)) bits++;
    space[half].bits = bits;
    make_table(keys->coordinate[half], &space[half]);
    tables[half] = &space[half];
  }
  uint32_t shared[ASC_LANES];
  for (uint64_t first = asc_first_run(range); first < range->first_sample + range->sample_count; first += ASC_LANES) {
    const asc_run part = asc_run_at(range, first);
    const uint32_t which = (uint32_t)(first / ASC_LANES) % ASC_LANES;
    if (which == 0 || part.row == 0) make_group(keys->order, (uint32_t)first & ~255u, shared);
    coordinate_run run;
    make_run(keys, tables, (uint32_t)first, shared[which], &run);
    for (uint32_t half = 0; half < 2; half++) {
      const uint32_t dimension = 2 * pair + half;
      if (!tables[half]) continue;
      double *column = points + part.row * range->dimension_count + (dimension - begin);
      for (uint32_t i = part.from; i < part.to; i++)
        column[(size_t)(i - part.from) * range->dimension_count] = run.values[half][run.at[half][i]];
    }
  }
}

static asc_status pmj02_fill(const void *opaque, const asc_range *range, double *points) {
  const pmj02_state *state = opaque;
  const uint32_t last = (range->first_dimension + range->dimension_count - 1) / 2;
  for (uint32_t pair = range->first_dimension / 2; pair <= last; pair++) {
    const pair_keys keys = keys_of(state->seed, range, pair);
    (range->sample_count < 4 ? fill_one_by_one : fill_in_runs)(range, &keys, pair, points);
  }
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

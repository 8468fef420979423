/* The quality parameter t of a net: the least t for which the N = base^m points are a (t, m, s)-net, from 0, the best,
 * to m, which any N points are.
 *
 * A (t, m, s)-net has base^t points in each elementary interval of volume base^(t - m), of every shape: base^-k_1 by
 * ... by base^-k_s with k_1 + ... + k_s = m - t (Niederreiter 1987, "Point sets and sequences with small discrepancy",
 * definition 2.2; Sobol 1967 in base 2). Found by counting, from t = 0 up, each t until a shape fails it. That is at
 * most binomial(m + s, s) shapes of N counts each; MOST_COUNTS of them are made.
 *
 * Intervals of a base that is a power of 2 are told apart exactly. In other bases their borders are no double, and a
 * coordinate up to 2^-48 below one, which is what rounding in making it may have cost, counts as on it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure.h"

#define MOST_COUNTS ((uint64_t)1 << 30) /* two or three seconds */
#define MOST_POINTS ((uint64_t)1 << 30)
#define NEAR 0x1p-48

enum { BASE };

static const asc_parameter parameters[] = {
    {"base", ASC_INTEGER, NULL, 2.0, 0x1p20, 2.0, "of the net: N is a power of it"},
};

typedef struct net_search {
  const asc_point_set *set;
  uint32_t base, digits; /* N = base^digits */
  uint32_t *cells;       /* of [dimension][point]: the coordinate's first `digits` digits, as a whole number */
  uint32_t *interval;    /* of [chosen dimensions][point]: the interval along the dimensions chosen so far */
  uint32_t *inside;      /* points in each interval */
  uint32_t full;         /* as many as there are to be */
  uint64_t counts;       /* made so far */
} net_search;

static uint32_t power(uint32_t base, uint32_t exponent) {
  uint32_t result = 1;
  for (uint32_t i = 0; i < exponent; i++) result *= base;
  return result;
}

/* The interval of a point when one more dimension is cut into `pieces`, each of `width` cells of its own. */
static inline uint32_t refined(const net_search *net, uint32_t coarse, uint32_t pieces, uint32_t cell, uint32_t k,
                               uint32_t width) {
  return coarse * pieces + (net->base == 2 ? cell >> (net->digits - k) : cell / width);
}

static void refine(const net_search *net, uint32_t dimension, uint32_t k, const uint32_t *coarse, uint32_t *fine) {
  const size_t n = net->set->count;
  const uint32_t *cells = net->cells + dimension * n;
  const uint32_t pieces = power(net->base, k), width = power(net->base, net->digits - k);
  for (size_t i = 0; i < n; i++) fine[i] = refined(net, coarse[i], pieces, cells[i], k, width);
}

/* Whether, with one last dimension cut into base^k, no interval has more than its share, and so, the shares being N in
 * all, none less. */
static int is_even(net_search *net, uint32_t dimension, uint32_t k, const uint32_t *coarse) {
  const size_t n = net->set->count;
  const uint32_t *cells = net->cells + dimension * n;
  const uint32_t pieces = power(net->base, k), width = power(net->base, net->digits - k);
  memset(net->inside, 0, n / net->full * sizeof *net->inside);
  for (size_t i = 0; i < n; i++)
    if (++net->inside[refined(net, coarse[i], pieces, cells[i], k, width)] > net->full) {
      net->counts += i;
      return 0;
    }
  net->counts += n;
  return 1;
}

/* Whether all shapes are even that add `left` digits, at least one, in dimensions from `first` on. `depth` dimensions
 * have been cut: at most as many as there are digits. */
static int are_even(net_search *net, uint32_t depth, uint32_t first, uint32_t left) {
  const size_t n = net->set->count;
  const uint32_t s = net->set->dimensions;
  uint32_t *interval = net->interval + depth * n;
  for (uint32_t dimension = first; dimension < s; dimension++) {
    if (net->counts > MOST_COUNTS || !is_even(net, dimension, left, interval)) return 0;
    for (uint32_t k = 1; k < left && dimension + 1 < s; k++) {
      refine(net, dimension, k, interval, interval + n);
      net->counts += n;
      if (!are_even(net, depth + 1, dimension + 1, left - k)) return 0;
    }
  }
  return 1;
}

/* ASC_UNSUPPORTED where a coordinate is 1, which lies in no interval. */
static asc_status read_digits(net_search *net, asc_error *error) {
  const size_t n = net->set->count;
  const uint32_t s = net->set->dimensions;
  const double scale = (double)n;
  const int rounded = (net->base & (net->base - 1)) != 0;
  for (size_t i = 0; i < n; i++)
    for (uint32_t d = 0; d < s; d++) {
      const double x = net->set->points[i * s + d], scaled = x * scale;
      if (x == 1.0)
        return asc_fail(error, ASC_UNSUPPORTED, "t-value is of points in [0, 1): point %zu has a coordinate of 1", i);
      double cell = floor(scaled);
      if (rounded && cell + 1.0 < scale && cell + 1.0 - scaled <= NEAR * scale) cell += 1.0;
      net->cells[d * n + i] = (uint32_t)cell;
    }
  return ASC_OK;
}

/* Any set has t = m at least: all of it in the cube. */
static asc_status find_t(net_search *net, asc_measurement *made, asc_error *error) {
  for (uint32_t t = 0; t <= net->digits; t++) {
    net->full = power(net->base, t);
    if (t == net->digits || are_even(net, 0, 0, net->digits - t)) {
      asc_measured(made, (double)t);
      return ASC_OK;
    }
    if (net->counts > MOST_COUNTS) break;
  }
  return asc_fail(error, ASC_UNSUPPORTED,
                  "t of %zu points in %u dimensions takes more than 2^30 counts of a point in an interval: take fewer "
                  "dimensions or points",
                  net->set->count, net->set->dimensions);
}

static asc_status t_value_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                   asc_error *error) {
  const size_t n = set->count;
  net_search net = {.set = set, .base = (uint32_t)values[BASE]};
  if (n > MOST_POINTS) return asc_fail(error, ASC_UNSUPPORTED, "t-value is of up to 2^30 points; these are %zu", n);
  uint64_t points = 1;
  for (; points < n; points *= net.base) net.digits++;
  if (points != n)
    return asc_fail(error, ASC_UNSUPPORTED, "a net in base %u has a power of %u points; these are %zu", net.base,
                    net.base, n);
  const size_t depth = net.digits < set->dimensions ? net.digits : set->dimensions;
  uint32_t *memory = calloc(n * (set->dimensions + depth + 2), sizeof *memory);
  if (!memory) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  net.cells = memory;
  net.interval = net.cells + n * set->dimensions;
  net.inside = net.interval + n * (depth + 1);
  asc_status status = read_digits(&net, error);
  if (status == ASC_OK) status = find_t(&net, made, error);
  free(memory);
  return status;
}

const asc_measure_interface asc_measure_t_value = {
    .name = "t-value",
    .title = "least t of which the points are a (t, m, s)-net, exact; N = base^m, t from 0, the best, to m",
    .source = "Sobol 1967; Niederreiter 1987",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .least_dimensions = 1,
    .most_dimensions = ASC_ANY_DIMENSION,
    .quick_points = (uint64_t)1 << 20,
    .evaluate = t_value_evaluate,
};

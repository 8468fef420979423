/* The discrepancy of unanchored boxes: sup over boxes [a, b] x [c, d] of |n/N - area|, in two dimensions, exact.
 *
 * What a box has too many it has most of with its sides at points' coordinates and the border counted in; what it
 * lacks, with its sides at points' coordinates or at 0 and 1 and the border left out (Niederreiter 1992, "Random number
 * generation and quasi-Monte Carlo methods", ch. 2; Dobkin, Gunopulos and Maass 1996, "Computing the maximum
 * bichromatic discrepancy, with applications to computer graphics and machine learning", reduce it to what follows).
 *
 * Between two sides a and b the best c and d are the ends of the run with the largest sum: one pass over the points of
 * the strip by their y. For all a in one range and b in another, the points of the widest strip with the width of the
 * narrowest bound what is too much, those of the narrowest with the width of the widest what is lacking, by one pass
 * too. So ranges are split as long as their bound is above the best that is known, the most promising first; at last
 * they hold one side each. Passes are made for 16 pairs of ranges at a time: O(N^3) at worst, in N^3/96 steps a sign,
 * where nothing can be pruned (sets of very low discrepancy); for random points the time grows as N^1.9. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "coordinates.h"
#include "measure.h"
#include "vectorise.h"

#define MOST_POINTS ((size_t)1 << 24)
#define SPLIT 4        /* parts of a range */
#define PAIRS 16       /* of parts of two ranges */
#define MOST_LEVELS 13 /* of ranges, each SPLIT times as large as the last: 4^12 = 2^24 */

/* Points by rising y, each with the rank of its x among the sides. */
typedef struct strip {
  double *rank, *y;
  size_t count;
} strip;

/* Pairs of ranges: points with a rank from `from` to `to` are in, and the width counts N `width`. */
typedef struct range_pairs {
  double from[PAIRS], to[PAIRS], width[PAIRS], best[PAIRS];
} range_pairs;

typedef struct box_search {
  const asc_point_set *set;
  int across; /* the dimension of the sides that are paired; the other one is swept */
  int closed;
  double *sides; /* distinct, rising */
  size_t side_count;
  strip strips[MOST_LEVELS + 1]; /* the points between the ranges of each level, the whole set last */
  double best;                   /* in points */
  int best_closed;
  double lower[2], upper[2]; /* of the best box, [0] across */
} box_search;

/* The largest sum of a run for each pair: of 1 a point less the area where `closed`, from a point to a point; else of
 * the area less the points between the ends, which are points' y, 0 and 1. A run's sum is the difference of two sums
 * from the start. Of points with equal y, of which all count where the border is closed, the first has the least sum
 * before it and the last the largest after it; and the other way round where it is open. Points that are not in the
 * pair's ranges may be ends of a run: that never makes it better than the best. */
ASC_INLINE void best_runs(const strip *points, range_pairs *pairs, const int closed) {
  double counted[PAIRS] = {0.0}, low[PAIRS] = {0.0}, best[PAIRS] = {0.0};
  double from[PAIRS], to[PAIRS], width[PAIRS];
  memcpy(from, pairs->from, sizeof from);
  memcpy(to, pairs->to, sizeof to);
  memcpy(width, pairs->width, sizeof width);
  for (size_t i = 0; i < points->count; i++) {
    const double rank = points->rank[i], y = points->y[i];
    for (size_t p = 0; p < PAIRS; p++) {
      const double area = width[p] * y;
      const double before = closed ? counted[p] - area : area - counted[p];
      counted[p] += ((rank >= from[p]) & (rank <= to[p])) ? 1.0 : 0.0;
      const double after = closed ? counted[p] - area : area - counted[p];
      const double begin = closed ? before : after;
      if (closed) low[p] = begin < low[p] ? begin : low[p];
      const double sum = (closed ? after : before) - low[p];
      best[p] = sum > best[p] ? sum : best[p];
      if (!closed) low[p] = begin < low[p] ? begin : low[p];
    }
  }
  for (size_t p = 0; p < PAIRS; p++) {
    const double sum = closed ? 0.0 : width[p] - counted[p] - low[p];
    pairs->best[p] = sum > best[p] ? sum : best[p];
  }
}

ASC_VECTORISE
static void most_excess(const strip *points, range_pairs *pairs) { best_runs(points, pairs, 1); }

ASC_VECTORISE
static void most_lack(const strip *points, range_pairs *pairs) { best_runs(points, pairs, 0); }

/* Finds the ends of the run that one of the two found for a pair, by the same steps. */
static void keep_box(box_search *search, const strip *points, const range_pairs *pairs, size_t p, size_t a, size_t b) {
  const int closed = search->closed;
  double counted = 0.0, low = 0.0, low_y = 0.0, best = 0.0;
  for (size_t i = 0; i <= points->count; i++) {
    const int end = i == points->count;
    if (end && closed) break;
    const double y = end ? 1.0 : points->y[i], area = pairs->width[p] * y;
    const double in = !end && points->rank[i] >= pairs->from[p] && points->rank[i] <= pairs->to[p] ? 1.0 : 0.0;
    const double to_low = closed ? counted - area : area - (counted + in);
    if (closed && to_low < low) low = to_low, low_y = y;
    const double sum = closed ? counted + in - area - low : area - counted - low;
    if (sum > best) {
      best = sum;
      search->lower[1] = low_y;
      search->upper[1] = y;
    }
    if (!closed && to_low < low) low = to_low, low_y = y;
    counted += in;
  }
  search->lower[0] = search->sides[a];
  search->upper[0] = search->sides[b];
  search->best = pairs->best[p];
  search->best_closed = closed;
}

/* The ranges are parts of those from `first` and from `last` on; bounds of the whole pairs. */
static void bound_pairs(const box_search *search, const strip *points, size_t first, size_t last, size_t size,
                        range_pairs *pairs) {
  const double count = (double)search->set->count, *sides = search->sides;
  for (size_t p = 0; p < PAIRS; p++) {
    const size_t a = first + p / SPLIT * size, b = last + p % SPLIT * size;
    pairs->from[p] = 1.0;
    pairs->to[p] = pairs->width[p] = 0.0;
    if (a >= search->side_count || b >= search->side_count) continue;
    const size_t a_end = a + size < search->side_count ? a + size - 1 : search->side_count - 1;
    const size_t b_end = b + size < search->side_count ? b + size - 1 : search->side_count - 1;
    if (a > b_end) continue;
    const double width = search->closed ? sides[b] - sides[a_end] : sides[b_end] - sides[a];
    pairs->width[p] = count * (width > 0.0 ? width : 0.0);
    pairs->from[p] = search->closed ? (double)a : (double)a_end + 1.0;
    pairs->to[p] = search->closed ? (double)b_end : (double)b - 1.0;
  }
  if (search->closed)
    most_excess(points, pairs);
  else
    most_lack(points, pairs);
}

/* All boxes whose sides are within SPLIT^level from `first` and from `last` on. */
static void visit(box_search *search, size_t level, size_t first, size_t last) {
  const strip *points = &search->strips[level];
  const size_t size = (size_t)1 << 2 * (level - 1);
  range_pairs pairs;
  bound_pairs(search, points, first, last, size, &pairs);
  for (;;) {
    size_t p = 0;
    for (size_t k = 1; k < PAIRS; k++)
      if (pairs.best[k] > pairs.best[p]) p = k;
    if (!(pairs.best[p] > search->best)) return;
    const size_t a = first + p / SPLIT * size, b = last + p % SPLIT * size;
    if (size == 1) {
      keep_box(search, points, &pairs, p, a, b);
      return;
    }
    pairs.best[p] = 0.0;
    strip *inner = &search->strips[level - 1];
    const double from = (double)a, to = (double)(b + size - 1);
    size_t count = 0;
    for (size_t i = 0; i < points->count; i++) {
      inner->rank[count] = points->rank[i];
      inner->y[count] = points->y[i];
      count += (points->rank[i] >= from) & (points->rank[i] <= to);
    }
    inner->count = count;
    visit(search, level - 1, a, b);
  }
}

static size_t distinct(const asc_coordinate *sorted, size_t count) {
  size_t found = 1;
  for (size_t i = 1; i < count; i++) found += sorted[i].value != sorted[i - 1].value;
  return found;
}

/* Fills the sides, with 0 and 1, and the strip of all points. */
static void prepare(box_search *search, strip *all, asc_coordinate *sorted, double *rank) {
  const size_t n = search->set->count;
  asc_sort_coordinates(search->set, 1, sorted);
  const size_t in_y = distinct(sorted, n);
  asc_sort_coordinates(search->set, 0, sorted);
  search->across = in_y < distinct(sorted, n); /* there are the fewer pairs */
  if (search->across) asc_sort_coordinates(search->set, 1, sorted);
  double *sides = search->sides;
  size_t count = 1;
  sides[0] = 0.0;
  for (size_t i = 0; i < n; i++) {
    if (sorted[i].value > sides[count - 1]) sides[count++] = sorted[i].value;
    rank[sorted[i].point] = (double)(count - 1);
  }
  if (sides[count - 1] < 1.0) sides[count++] = 1.0;
  search->side_count = count;
  asc_sort_coordinates(search->set, !search->across, sorted);
  for (size_t i = 0; i < n; i++) {
    all->y[i] = sorted[i].value;
    all->rank[i] = rank[sorted[i].point];
  }
  all->count = n;
}

static void measure_best(const box_search *search, asc_measurement *made) {
  const size_t n = search->set->count;
  const int across = search->across;
  for (int d = 0; d < 2; d++) {
    made->witness[d] = search->lower[d ^ across];
    made->witness[2 + d] = search->upper[d ^ across];
  }
  const double *lower = made->witness, *upper = made->witness + 2;
  size_t inside = 0;
  for (size_t i = 0; i < n; i++) {
    const double x = search->set->points[2 * i], y = search->set->points[2 * i + 1];
    inside += search->best_closed ? (x >= lower[0]) & (x <= upper[0]) & (y >= lower[1]) & (y <= upper[1])
                                  : (x > lower[0]) & (x < upper[0]) & (y > lower[1]) & (y < upper[1]);
  }
  const long double area = ((long double)upper[0] - lower[0]) * ((long double)upper[1] - lower[1]);
  asc_measured(made, (double)fabsl((long double)inside / (long double)n - area));
  made->closed = (uint32_t)search->best_closed;
  made->witness_count = 4;
}

static asc_status box_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                               asc_error *error) {
  (void)values;
  const size_t n = set->count;
  if (n > MOST_POINTS) return asc_fail(error, ASC_UNSUPPORTED, "box is of up to 2^24 points");
  size_t levels = 1;
  while ((size_t)1 << 2 * levels < n + 2) levels++;
  const size_t doubles = (levels + 1) * 2 * n + 2 * n + 2;
  char *memory = calloc(1, doubles * sizeof(double) + n * sizeof(asc_coordinate));
  if (!memory) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  box_search search = {.set = set};
  asc_coordinate *sorted = (asc_coordinate *)memory;
  double *next = (double *)(sorted + n);
  for (size_t level = 1; level <= levels; level++, next += 2 * n) search.strips[level] = (strip){next, next + n, 0};
  search.sides = next;
  prepare(&search, &search.strips[levels], sorted, next + n + 2);
  for (search.closed = 1; search.closed >= 0; search.closed--) visit(&search, levels, 0, 0);
  measure_best(&search, made);
  free(memory);
  return ASC_OK;
}

const asc_measure_interface asc_measure_box = {
    .name = "box",
    .title = "largest |n/N - area| over boxes, exact; met at the box of these lower and upper corners",
    .source = "Dobkin, Gunopulos and Maass 1996",
    .least_dimensions = 2,
    .most_dimensions = 2,
    .quick_points = 2000,
    .evaluate = box_evaluate,
};

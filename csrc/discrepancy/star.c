/* The star discrepancy: sup over boxes [0, x) of |n/N - volume|, exact.
 *
 * The extremes are met where each side of the box lies at a point's coordinate or at 1, with the points of the border
 * counted in (more points than volume) or out (less); Niederreiter 1972 has it in one dimension, Bundschuh and Zhu
 * 1993, "A method for exact calculation of the discrepancy of low-dimensional finite point sets", in more.
 *
 * In two dimensions a line is swept along x. For every candidate y_j the excess is the line a_j + s b_j in s, the swept
 * width, and a new point adds one to the a_j on one side of it. The candidates are kept in blocks of about sqrt(N),
 * each with the upper hull of its lines, along which the best only moves forward as s grows: a point changes one block
 * inside and others by a common amount, so that the whole takes O(N^1.5). Further dimensions are taken one by one, each
 * of its candidates with the points that lie below: O(N^2.5) and O(N^3.5). */
#include <math.h>
#include <stdlib.h>

#include "coordinates.h"
#include "measure.h"
#include "vectorise.h"

#define MOST_DIMENSIONS 4
#define MOST_POINTS ((size_t)1 << 24)
#define LEAST_BLOCK 32
#define PARTS 8 /* blocks that are looked at side by side */

typedef struct star_search {
  const asc_point_set *set;
  int closed;
  double best; /* in points: n - N volume, or N volume - n where the border is open */
  int best_closed;
  double where[MOST_DIMENSIONS];
  double corner[MOST_DIMENSIONS];   /* of the box that is looked at, from its third dimension on */
  uint32_t *order[MOST_DIMENSIONS]; /* the points by each coordinate */
  uint32_t *level;                  /* of a point: how many dimensions from the third on it lies below the corner in */
  uint32_t *rank;                   /* of a point: where the candidates begin that it changes, or end */
  double *slope, *excess;           /* of each candidate, by rising slope: b_j and a_j */
  uint32_t *hull;                   /* block by block, the candidates on its hull */
  double *common, *now_excess, *now_slope, *next_excess, *next_slope; /* of each block */
  uint32_t *hull_count, *hull_at;
  size_t candidates, block, blocks;
} star_search;

/* In one dimension there is a second, in which every point counts and which does not change a volume. */
static double coordinate(const star_search *search, uint32_t point, uint32_t dimension) {
  if (dimension >= search->set->dimensions) return search->closed ? 1.0 : 0.0;
  return search->set->points[(size_t)point * search->set->dimensions + dimension];
}

/* What a block's best line is, and the one that it will give way to. */
static void show_line(star_search *search, size_t block) {
  const uint32_t *hull = search->hull + block * search->block;
  const uint32_t at = search->hull_at[block], now = hull[at];
  search->now_excess[block] = search->excess[now];
  search->now_slope[block] = search->slope[now];
  const int last = at + 1 == search->hull_count[block];
  search->next_excess[block] = last ? -INFINITY : search->excess[hull[at + 1]];
  search->next_slope[block] = last ? 0.0 : search->slope[hull[at + 1]];
}

static size_t block_end(const star_search *search, size_t block) {
  const size_t end = (block + 1) * search->block;
  return end < search->candidates ? end : search->candidates;
}

/* The hull of a block's lines from s on: Andrew's monotone chain, slopes being sorted. */
static void make_hull(star_search *search, size_t block, double s) {
  const double *slope = search->slope, *excess = search->excess;
  uint32_t *hull = search->hull + block * search->block, count = 0;
  for (uint32_t j = (uint32_t)(block * search->block); j < block_end(search, block); j++) {
    while (count > 0 && excess[hull[count - 1]] <= excess[j]) count--; /* never better again: its slope is smaller */
    while (count > 1) {
      const uint32_t p = hull[count - 2], q = hull[count - 1];
      if ((excess[q] - excess[p]) * (slope[j] - slope[p]) > (excess[j] - excess[p]) * (slope[q] - slope[p])) break;
      count--;
    }
    hull[count++] = j;
  }
  uint32_t at = 0;
  while (at + 1 < count && excess[hull[at + 1]] + s * slope[hull[at + 1]] >= excess[hull[at]] + s * slope[hull[at]])
    at++;
  search->hull_count[block] = count;
  search->hull_at[block] = at;
  show_line(search, block);
}

/* Counts a point: from `rank` on in the candidates where the border is open, below `rank` where it is closed. */
static void count_point(star_search *search, uint32_t rank, double s) {
  const double change = search->closed ? 1.0 : -1.0;
  const size_t inside = rank / search->block;
  const size_t from = search->closed ? 0 : inside + 1;
  const size_t to = search->closed ? (inside < search->blocks ? inside : search->blocks) : search->blocks;
  for (size_t block = from; block < to; block++) search->common[block] += change;
  if (inside >= search->blocks) return;
  const size_t first = search->closed ? inside * search->block : rank;
  const size_t end = search->closed ? rank : block_end(search, inside);
  if (first == end) return;
  for (size_t j = first; j < end; j++) search->excess[j] += change;
  make_hull(search, inside, s);
}

/* The best over blocks at s, once none of them has a better line further on; tells whether one had. */
ASC_VECTORISE
static double best_line(const star_search *search, double s, int *moves) {
  const double *common = search->common, *excess = search->now_excess, *slope = search->now_slope;
  const double *next_excess = search->next_excess, *next_slope = search->next_slope;
  double best[PARTS];
  int better = 0;
  for (size_t p = 0; p < PARTS; p++) best[p] = -INFINITY;
  for (size_t block = 0; block < search->blocks; block += PARTS) /* arrays are padded */
    for (size_t p = 0; p < PARTS; p++) {
      const double now = excess[block + p] + s * slope[block + p];
      const double next = next_excess[block + p] + s * next_slope[block + p];
      better |= next > now;
      const double value = common[block + p] + now;
      best[p] = value > best[p] ? value : best[p];
    }
  *moves = better;
  for (size_t p = 1; p < PARTS; p++) best[0] = best[p] > best[0] ? best[p] : best[0];
  return best[0];
}

static void move_on(star_search *search, double s) {
  for (size_t block = 0; block < search->blocks; block++) {
    while (search->next_excess[block] + s * search->next_slope[block] >
           search->now_excess[block] + s * search->now_slope[block]) {
      search->hull_at[block]++;
      show_line(search, block);
    }
  }
}

static void look(star_search *search, double x, double s) {
  int moves;
  double best = best_line(search, s, &moves);
  if (moves) {
    move_on(search, s);
    best = best_line(search, s, &moves);
  }
  if (!(best > search->best)) return;
  search->best = best;
  search->best_closed = search->closed;
  for (uint32_t d = 2; d < search->set->dimensions; d++) search->where[d] = search->corner[d];
  search->where[0] = x;
  for (size_t block = 0; block < search->blocks; block++)
    if (search->common[block] + (search->now_excess[block] + s * search->now_slope[block]) == best)
      search->where[1] = fabs(search->now_slope[block]);
}

/* Whether a point lies below the corner in all dimensions from the third on. */
static int is_in(const star_search *search, uint32_t point) {
  return search->level[point] + 2 >= search->set->dimensions;
}

/* The candidates are the points' y coordinates, and 1 where the border is open; and each point's rank among them. */
static void make_candidates(star_search *search) {
  const size_t n = search->set->count;
  const uint32_t *order = search->order[1];
  size_t count = 0;
  double last = -1.0;
  for (size_t k = 0; k < n; k++) {
    const uint32_t point = order[search->closed ? n - 1 - k : k];
    if (!is_in(search, point)) continue;
    const double y = coordinate(search, point, 1);
    if (count == 0 || y != last) search->slope[count++] = search->closed ? -y : y;
    last = y;
    search->rank[point] = (uint32_t)count;
  }
  if (!search->closed && (count == 0 || last < 1.0)) search->slope[count++] = 1.0;
  search->candidates = count;
  search->block = (size_t)sqrt((double)count);
  if (search->block < LEAST_BLOCK) search->block = LEAST_BLOCK;
  search->blocks = (count + search->block - 1) / search->block;
  for (size_t j = 0; j < count; j++) search->excess[j] = 0.0;
  for (size_t block = 0; block < search->blocks; block++) {
    search->common[block] = 0.0;
    make_hull(search, block, 0.0);
  }
  for (size_t block = search->blocks; block % PARTS; block++) {
    search->common[block] = search->now_slope[block] = search->next_slope[block] = 0.0;
    search->now_excess[block] = search->next_excess[block] = -INFINITY;
  }
}

/* The best box over x and y among the points that are in, `share` being the box's extent in all further dimensions. */
static void sweep(star_search *search, double share) {
  const size_t n = search->set->count;
  const uint32_t *order = search->order[0];
  make_candidates(search);
  if (search->candidates == 0) return;
  const double scale = (double)n * share;
  double x = -1.0;
  for (size_t k = 0; k < n;) {
    x = coordinate(search, order[k], 0);
    if (!search->closed) look(search, x, scale * x);
    for (; k < n && coordinate(search, order[k], 0) == x; k++)
      if (is_in(search, order[k])) count_point(search, search->rank[order[k]], scale * x);
    if (search->closed) look(search, x, scale * x);
  }
  if (!search->closed && x < 1.0) look(search, 1.0, scale);
}

/* Looks at all boxes, their corner's dimensions from `dimension` down to the third one by one. */
static void descend(star_search *search, uint32_t dimension, double share) {
  if (dimension < 2) {
    sweep(search, share);
    return;
  }
  const size_t n = search->set->count;
  const uint32_t *order = search->order[dimension];
  double z = -1.0;
  for (size_t k = 0; k < n;) {
    z = coordinate(search, order[k], dimension);
    const size_t first = k;
    for (; k < n && coordinate(search, order[k], dimension) == z; k++)
      if (search->closed) search->level[order[k]]++;
    search->corner[dimension] = z;
    /* An open box holds no more excess than its volume. */
    if (search->closed || (double)n * share * z > search->best) descend(search, dimension - 1, share * z);
    if (!search->closed)
      for (size_t i = first; i < k; i++) search->level[order[i]]++;
  }
  search->corner[dimension] = 1.0;
  if (!search->closed && z < 1.0) descend(search, dimension - 1, share);
  for (size_t i = 0; i < n; i++) search->level[order[i]]--;
}

/* All memory of a search in one piece: doubles first, then the 32-bit arrays. */
static void *allot(star_search *search, asc_coordinate **sorted) {
  const size_t n = search->set->count + 1, padded = n + PARTS;
  const size_t doubles = 2 * n + 5 * padded, words = (MOST_DIMENSIONS + 2) * n + n + LEAST_BLOCK + 2 * padded;
  char *memory = calloc(1, n * sizeof(asc_coordinate) + doubles * sizeof(double) + words * sizeof(uint32_t));
  if (!memory) return NULL;
  *sorted = (asc_coordinate *)memory;
  double *next = (double *)(*sorted + n);
  double **const candidate[] = {&search->slope, &search->excess};
  for (size_t i = 0; i < 2; i++, next += n) *candidate[i] = next;
  double **const block[] = {&search->common, &search->now_excess, &search->now_slope, &search->next_excess,
                            &search->next_slope};
  for (size_t i = 0; i < 5; i++, next += padded) *block[i] = next;
  uint32_t *word = (uint32_t *)next;
  for (size_t d = 0; d < MOST_DIMENSIONS; d++, word += n) search->order[d] = word;
  search->level = word, word += n;
  search->rank = word, word += n;
  search->hull = word, word += n + LEAST_BLOCK;
  search->hull_count = word, word += padded;
  search->hull_at = word;
  return memory;
}

static void sort_points(star_search *search, asc_coordinate *sorted) {
  for (uint32_t d = 0; d < search->set->dimensions; d++) {
    asc_sort_coordinates(search->set, d, sorted);
    for (uint32_t i = 0; i < search->set->count; i++) search->order[d][i] = sorted[i].point;
  }
  if (search->set->dimensions == 1) /* in the second dimension all are equal */
    for (uint32_t i = 0; i < search->set->count; i++) search->order[1][i] = i;
}

static asc_status star_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                asc_error *error) {
  (void)values;
  if (set->count > MOST_POINTS)
    return asc_fail(error, ASC_UNSUPPORTED, "star is exact for up to 2^24 points; star-bounds takes more");
  star_search search = {.set = set};
  asc_coordinate *sorted = NULL;
  void *memory = allot(&search, &sorted);
  if (!memory) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  sort_points(&search, sorted);
  for (search.closed = 0; search.closed < 2; search.closed++) descend(&search, set->dimensions - 1, 1.0);
  free(memory);
  long double volume = 1.0L, inside = 0.0L;
  for (uint32_t d = 0; d < set->dimensions; d++) volume *= search.where[d];
  for (size_t i = 0; i < set->count; i++) {
    int in = 1;
    for (uint32_t d = 0; d < set->dimensions; d++) {
      const double x = set->points[i * set->dimensions + d];
      in &= search.best_closed ? x <= search.where[d] : x < search.where[d];
    }
    inside += in;
  }
  asc_measured(made, (double)fabsl(inside / (long double)set->count - volume));
  made->closed = (uint32_t)search.best_closed;
  made->witness_count = set->dimensions;
  for (uint32_t d = 0; d < set->dimensions; d++) made->witness[d] = search.where[d];
  return ASC_OK;
}

const asc_measure_interface asc_measure_star = {
    .name = "star",
    .title = "largest |n/N - volume| over boxes [0, x), exact; met at the corner x",
    .source = "Niederreiter 1972; Bundschuh and Zhu 1993",
    .least_dimensions = 1,
    .most_dimensions = MOST_DIMENSIONS,
    .quick_points = 100000,
    .evaluate = star_evaluate,
};

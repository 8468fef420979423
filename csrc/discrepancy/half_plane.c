/* The half-plane discrepancy: sup over half-planes A of |n(A)/N - area(A and the unit square)|, exact.
 *
 * What an open half-plane lacks, its closed complement has too much: so the sup is that of n/N - area over closed ones.
 * Of those that hold the same points the one with the least area touches them. It goes through two of them, or it turns
 * about one, whose distance to each end of its chord is then the same (the area changes with the angle by half the
 * difference of their squares). A point (x, y) from the nearest corner halves the chord from (2x, 0) to (0, 2y), and
 * cuts off 2xy; on the border that is the side of the square. So there are N^2/2 lines through two points and N others.
 * (de Berg 1996, "Computing half-plane and strip discrepancy of planar point sets", has the lines through two points
 * dual.)
 *
 * About each point, a pivot, the others are sorted by the direction of their line; the counts on both sides of each
 * line follow from the place in that order. Of lines in one direction all points count as on the line: prefixes of
 * them, which a tilt would give, have the same area and fewer points.
 *
 * Directions are rounded. Those within SAME of each other are taken for one, so that no point on a line is missed;
 * points that are taken for it wrongly lie within 2.6e-15 of it, so that a half-plane that does hold them has no more
 * than 1.5 times this in area besides. An exact test of orientation could not make more of the result.
 *
 * The sort: one pass into as many buckets as points, or by digits where many share a bucket; then by insertion. All of
 * it takes O(N^2). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "halfplane_area.h"
#include "measure.h"
#include "vectorise.h"

#define MOST_POINTS ((size_t)1 << 24)
#define PARTS 8 /* lines that are looked at side by side */
/* Keys are sorted by digits where insertion would take longer: the sum of the squares of the buckets' sizes tells. */
#define CROWDED 20000u
#define CROWDED_SHARE 32u
#define DIGITS (size_t)6 /* of 11 bits */
#define RADIX (size_t)2048

/* A direction (dx, dy), turned by pi if need be so that dy >= 0, has the key -dx / (|dx| + dy), which rises from -1 to
 * 1 with the angle. The last bit of a key says whether it was turned. With eps = 2^-53 the differences, their sum and
 * the quotient add up to 2.25 eps at most, the bit to 1 (2 at the ends): two keys of one line are within 8 eps. */
#define SAME 0x1p-50
#define TURNED UINT64_C(1)
/* The key of a point that equals the pivot, sorted last; and a key's least size, so that its last bit is no denormal.
 */
#define NO_DIRECTION 3.0
#define LEAST_KEY 0x1p-100

typedef struct direction {
  double dx, dy;
} direction;

typedef struct plane_search {
  size_t count;
  double *xs, *ys;
  double *keys, *sorted; /* of the lines through the pivot */
  double *left, *right;  /* points on the closed left and right side of each */
  int32_t *bucket;       /* of each key */
  uint32_t *ends;        /* of each bucket */
  uint32_t *unturned;    /* how many of the first so many keys were not turned */
  uint32_t *digits;      /* how often each is met at each place */
  size_t buckets, lines, equal;
  double best; /* in points: n - N area */
  double best_count;
  direction best_direction; /* the half-plane lies to the right of it */
  size_t best_pivot;
} plane_search;

static int is_turned(double key) {
  uint64_t bits;
  memcpy(&bits, &key, sizeof bits);
  return (int)(bits & TURNED);
}

/* A digit of the bits of a key, made to rise with it: the sign turned round, below 0 all others too. */
static inline size_t digit(double key, size_t place) {
  uint64_t bits;
  memcpy(&bits, &key, sizeof bits);
  bits ^= bits >> 63 ? UINT64_MAX : UINT64_C(1) << 63;
  return (size_t)(bits >> 11 * place) % RADIX;
}

/* The keys of all lines through the pivot, and their buckets, of which the last is that of points without one. */
ASC_VECTORISE
static void make_keys(const plane_search *search, double x, double y) {
  const double *xs = search->xs, *ys = search->ys;
  double *keys = search->keys;
  int32_t *bucket = search->bucket;
  const double scale = 0.5 * (double)search->buckets;
  const int32_t last = (int32_t)search->buckets + 1;
  for (size_t i = 0; i < search->count; i++) {
    const double dx = xs[i] - x, dy = ys[i] - y, extent = fabs(dx) + fabs(dy);
    const int turned = (dy < 0.0) | ((dy == 0.0) & (dx < 0.0));
    double key = (turned ? dx : -dx) / (extent > 0.0 ? extent : 1.0);
    key = copysign(fabs(key) > LEAST_KEY ? fabs(key) : LEAST_KEY, key);
    key = extent > 0.0 ? key : NO_DIRECTION;
    uint64_t bits;
    memcpy(&bits, &key, sizeof bits);
    bits = (bits & ~TURNED) | (turned ? TURNED : 0);
    memcpy(&key, &bits, sizeof key);
    keys[i] = key;
    const int32_t place = (int32_t)((key + 1.0) * scale);
    bucket[i] = place < last ? place : last;
  }
}

/* Sorts by digits, the last first: for keys that crowd in few buckets. The counts of lines are not made yet, so their
 * memory is free. */
static void sort_by_digits(plane_search *search) {
  const size_t n = search->count;
  const double *from = search->keys;
  memset(search->digits, 0, DIGITS * RADIX * sizeof *search->digits);
  for (size_t i = 0; i < n; i++)
    for (size_t d = 0; d < DIGITS; d++) search->digits[d * RADIX + digit(from[i], d)]++;
  for (size_t d = 0; d < DIGITS; d++) {
    uint32_t *ends = search->digits + d * RADIX, sum = 0;
    if (ends[digit(from[0], d)] == n) continue; /* all have the same */
    double *to = from == search->sorted ? search->left : search->sorted;
    for (size_t k = 0; k < RADIX; k++) {
      const uint32_t size = ends[k];
      ends[k] = sum;
      sum += size;
    }
    for (size_t i = 0; i < n; i++) to[ends[digit(from[i], d)]++] = from[i];
    from = to;
  }
  if (from != search->sorted) memcpy(search->sorted, from, n * sizeof *from);
}

/* Sorts the keys; search->lines of them are lines. */
static void sort_keys(plane_search *search) {
  const size_t n = search->count, buckets = search->buckets + 2;
  const int32_t *bucket = search->bucket;
  uint32_t *ends = search->ends, sum = 0;
  uint64_t crowding = 0;
  double *sorted = search->sorted;
  memset(ends, 0, buckets * sizeof *ends);
  for (size_t i = 0; i < n; i++) ends[bucket[i]]++;
  search->equal = ends[buckets - 1];
  search->lines = n - search->equal;
  for (size_t k = 0; k < buckets; k++) {
    const uint32_t size = ends[k];
    if (k + 1 < buckets) crowding += (uint64_t)size * size;
    ends[k] = sum;
    sum += size;
  }
  if (crowding > CROWDED + CROWDED_SHARE * (uint64_t)n) {
    sort_by_digits(search);
    return;
  }
  for (size_t i = 0; i < n; i++) sorted[ends[bucket[i]]++] = search->keys[i];
  for (size_t i = 1; i < search->lines; i++) {
    const double key = sorted[i];
    size_t k = i;
    for (; k > 0 && sorted[k - 1] > key; k--) sorted[k] = sorted[k - 1];
    sorted[k] = key;
  }
}

/* The points on both closed sides of a line, given that keys[begin] to keys[end - 1] are on it. */
static void count_sides(const plane_search *search, size_t begin, size_t end, double *left, double *right) {
  const uint32_t *unturned = search->unturned;
  const size_t all = unturned[search->lines];
  *left = (double)(all - unturned[begin] + (end - unturned[end]) + search->equal);
  *right = (double)(unturned[end] + (search->lines - begin) - (all - unturned[begin]) + search->equal);
}

static void count_lines(plane_search *search) {
  const double *sorted = search->sorted;
  uint32_t *unturned = search->unturned, sum = 0;
  for (size_t k = 0; k < search->lines; k++) {
    unturned[k] = sum;
    sum += !is_turned(sorted[k]);
  }
  unturned[search->lines] = sum;
  for (size_t k = 0, begin = 0, end = 0; k < search->lines; k++) {
    while (sorted[begin] < sorted[k] - SAME) begin++;
    while (end < search->lines && sorted[end] <= sorted[k] + SAME) end++;
    count_sides(search, begin, end, &search->left[k], &search->right[k]);
  }
}

/* What a line through (x, y) has on its right side: the area of a X + b Y >= m, a + b = 1, the square mirrored so that
 * b is not negative. The smaller side of the two is a triangle or a trapezoid; `cut` is where the first ends. */
static inline double right_area(double key, double x, double y) {
  const double b = fabs(key), a = 1.0 - b > 0x1p-200 ? 1.0 - b : 0x1p-200;
  const double m = a * x + b * (key >= 0.0 ? y : 1.0 - y);
  const double rest = m < 0.5 ? m : 1.0 - m, near = rest > 0.0 ? rest : 0.0; /* b may be above 1 by its last bit */
  const double lower = a < b ? a : b, upper = a < b ? b : a, cut = near < lower ? near : lower;
  const double smaller = (2.0 * near - cut) * cut / (2.0 * lower * upper);
  return m < 0.5 ? 1.0 - smaller : smaller;
}

/* The most that a line of the pivot has too many on one of its sides. The arrays are padded. */
ASC_VECTORISE
static double best_excess(const plane_search *search, double x, double y) {
  const double *keys = search->sorted, *left = search->left, *right = search->right;
  const double points = (double)search->count;
  double best[PARTS] = {0.0};
  for (size_t k = 0; k < search->lines; k += PARTS)
    for (size_t p = 0; p < PARTS; p++) {
      const double area = right_area(keys[k + p], x, y);
      const double on_left = left[k + p] - points * (1.0 - area), on_right = right[k + p] - points * area;
      const double excess = on_left > on_right ? on_left : on_right;
      best[p] = excess > best[p] ? excess : best[p];
    }
  for (size_t p = 1; p < PARTS; p++) best[0] = best[p] > best[0] ? best[p] : best[0];
  return best[0];
}

/* Keeps the better side of a line through the pivot. */
static void keep(plane_search *search, size_t pivot, direction along, const double counts[2], double area) {
  const double points = (double)search->count;
  const double excess[2] = {counts[0] - points * (1.0 - area), counts[1] - points * area};
  const int right = excess[1] > excess[0];
  if (!(excess[right] > search->best)) return;
  search->best = excess[right];
  search->best_count = counts[right];
  search->best_pivot = pivot;
  search->best_direction = right ? along : (direction){-along.dx, -along.dy};
}

/* Finds the line again that best_excess saw, and the point that it goes through. */
static void keep_line(plane_search *search, size_t pivot, double best) {
  const double x = search->xs[pivot], y = search->ys[pivot], points = (double)search->count;
  for (size_t k = 0; k < search->lines; k++) {
    const double key = search->sorted[k], area = right_area(key, x, y);
    const double counts[2] = {search->left[k], search->right[k]};
    if (counts[0] - points * (1.0 - area) < best && counts[1] - points * area < best) continue;
    size_t other = 0;
    while (search->keys[other] != key) other++;
    const double sign = is_turned(key) ? -1.0 : 1.0;
    const direction along = {sign * (search->xs[other] - x), sign * (search->ys[other] - y)};
    keep(search, pivot, along, counts, area);
    return;
  }
}

/* A line through the pivot that need not meet another point; not turned, so dy > 0, or dy = 0 and dx > 0. */
static void look_along(plane_search *search, size_t pivot, direction along) {
  const double *sorted = search->sorted, exact = -along.dx / (fabs(along.dx) + along.dy);
  const double key = fabs(exact) > LEAST_KEY ? exact : LEAST_KEY;
  size_t place = 0, above = search->lines; /* bisection: the first key that is not below */
  while (place < above) {
    const size_t middle = place + (above - place) / 2;
    if (sorted[middle] < key - SAME)
      place = middle + 1;
    else
      above = middle;
  }
  size_t end = place;
  while (end < search->lines && sorted[end] <= key + SAME) end++;
  double counts[2];
  count_sides(search, place, end, &counts[0], &counts[1]);
  keep(search, pivot, along, counts, right_area(key, search->xs[pivot], search->ys[pivot]));
}

static void turn_about(plane_search *search, size_t pivot) {
  const double x = search->xs[pivot], y = search->ys[pivot];
  make_keys(search, x, y);
  sort_keys(search);
  count_lines(search);
  for (size_t k = search->lines; k % PARTS; k++) {
    search->sorted[k] = 0.5;
    search->left[k] = search->right[k] = 0.0;
  }
  const double best = best_excess(search, x, y);
  if (best > search->best) keep_line(search, pivot, best);
  /* The chord that the pivot halves cuts off the corner nearest to it. */
  const double across = x < 0.5 ? x : 1.0 - x, up = y < 0.5 ? y : 1.0 - y;
  direction along = {(x < 0.5) == (y < 0.5) && up > 0.0 ? -across : across, up};
  if (across == 0.0 && up == 0.0) along.dx = 1.0; /* at a corner any line that cuts nothing off */
  look_along(search, pivot, along);
}

/* All memory of a search in one piece. */
static void *allot(plane_search *search, size_t n) {
  const size_t padded = n + PARTS;
  search->buckets = 16;
  while (search->buckets < n) search->buckets *= 2;
  const size_t words = search->buckets + 2 + DIGITS * RADIX + padded;
  double *memory = calloc(1, 6 * padded * sizeof(double) + words * sizeof(uint32_t) + padded * sizeof(int32_t));
  if (!memory) return NULL;
  double *next = memory;
  double **const rows[] = {&search->xs, &search->ys, &search->keys, &search->sorted, &search->left, &search->right};
  for (size_t i = 0; i < sizeof rows / sizeof *rows; i++, next += padded) *rows[i] = next;
  search->bucket = (int32_t *)next;
  search->ends = (uint32_t *)(search->bucket + padded);
  search->digits = search->ends + search->buckets + 2;
  search->unturned = search->digits + DIGITS * RADIX;
  return memory;
}

static asc_status half_plane_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                      asc_error *error) {
  (void)values;
  const size_t n = set->count;
  if (n > MOST_POINTS) return asc_fail(error, ASC_UNSUPPORTED, "half-plane is of up to 2^24 points");
  plane_search search = {.count = n};
  void *memory = allot(&search, n);
  if (!memory) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < n; i++) {
    search.xs[i] = set->points[2 * i];
    search.ys[i] = set->points[2 * i + 1];
  }
  for (size_t pivot = 0; pivot < n; pivot++) turn_about(&search, pivot);
  /* Scaled, so that points that are ever so close still make a line that goes through them. */
  int exponent;
  (void)frexp(fmax(fabs(search.best_direction.dx), fabs(search.best_direction.dy)), &exponent);
  const double a = ldexp(search.best_direction.dy, -exponent) + 0.0; /* no -0 */
  const double b = 0.0 - ldexp(search.best_direction.dx, -exponent);
  const long double x = search.xs[search.best_pivot], y = search.ys[search.best_pivot];
  const double c = (double)-(a * x + b * y);
  free(memory);
  asc_measured(made, search.best_count / (double)n - asc_halfplane_area(a, b, c));
  made->closed = 1;
  made->witness_count = 3;
  made->witness[0] = a;
  made->witness[1] = b;
  made->witness[2] = c;
  return ASC_OK;
}

const asc_measure_interface asc_measure_half_plane = {
    .name = "half-plane",
    .title = "largest |n/N - area| over half-planes, exact; met where a x + b y + c >= 0",
    .source = "de Berg 1996",
    .least_dimensions = 2,
    .most_dimensions = 2,
    .quick_points = 8000,
    .evaluate = half_plane_evaluate,
};

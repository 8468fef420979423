/* The minimum distance: between the two closest points, on the torus, where 0 and 1 are one, or in the cube.
 *
 * The points are parted at the median of their widest extent, down to leaves of a few (Bentley 1975, "Multidimensional
 * binary search trees used for associative searching"), and pairs of nodes are compared from the top down, unless their
 * boxes are further apart than the closest pair so far (Gray and Moore 2001, "N-body problems in statistical
 * learning"). In few dimensions that is O(N log N) however the points lie; in many it tends to N^2 / 2. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "measure.h"

#define MOST_POINTS ((size_t)1 << 31)
#define LEAF 8
/* Coordinates are scaled, that squares of differences down to 2^-1011 do not underflow. */
#define SCALE 0x1p500

enum { TORUS };

static const asc_parameter parameters[] = {
    {"torus", ASC_INTEGER, NULL, 0.0, 1.0, 1.0, "1: 0 and 1 are one; 0: they are apart"},
};

typedef struct pair_search {
  uint32_t dimensions, levels; /* of nodes above the leaves */
  size_t count;
  double period;  /* infinite in the cube */
  double *points; /* scaled, in the order of the tree */
  double *boxes;  /* of each node, numbered as in a heap from 1 on: its least coordinates, then its greatest */
  uint64_t state; /* of the choice of pivots, which changes the time alone */
  double best;    /* squared */
  const double *closest[2];
} pair_search;

static double *point_at(const pair_search *search, size_t index) { return search->points + index * search->dimensions; }

static double *box_of(const pair_search *search, size_t node) { return search->boxes + 2 * node * search->dimensions; }

/* A node's points begin where the one before it ends. `place` is counted along the level, from 0. */
static size_t begin_of(const pair_search *search, uint32_t level, size_t place) {
  return (size_t)(((uint64_t)search->count * place) >> level);
}

static void swap_points(double *a, double *b, uint32_t dimensions) {
  for (uint32_t d = 0; d < dimensions; d++) {
    const double kept = a[d];
    a[d] = b[d];
    b[d] = kept;
  }
}

/* Moves the points of [first, last] so that none before `middle` has a greater coordinate than it and none after a
 * smaller one: Hoare 1961, "Algorithm 65: find". The pivots are chosen at random, so that no order is a slow one. */
static void part(pair_search *search, ptrdiff_t first, ptrdiff_t last, ptrdiff_t middle, uint32_t along) {
  const uint32_t dimensions = search->dimensions;
  const double *coordinate = search->points + along;
  while (first < last) {
    search->state = search->state * 6364136223846793005u + 1442695040888963407u; /* Knuth's MMIX */
    const size_t chosen = (size_t)first + (search->state >> 33) % (size_t)(last - first + 1);
    const double pivot = coordinate[chosen * dimensions];
    ptrdiff_t i = first, j = last;
    while (i <= j) {
      while (coordinate[(size_t)i * dimensions] < pivot) i++;
      while (coordinate[(size_t)j * dimensions] > pivot) j--;
      if (i <= j) swap_points(point_at(search, (size_t)i++), point_at(search, (size_t)j--), dimensions);
    }
    if (middle <= j)
      last = j;
    else if (middle >= i)
      first = i;
    else
      return;
  }
}

/* Makes the node's box and, above the leaves, parts its points: as many calls deep as there are levels. */
static void build(pair_search *search, uint32_t level, size_t place) {
  const size_t begin = begin_of(search, level, place), end = begin_of(search, level, place + 1);
  const uint32_t dimensions = search->dimensions;
  double *least = box_of(search, ((size_t)1 << level) + place), *most = least + dimensions;
  memcpy(least, point_at(search, begin), dimensions * sizeof *least);
  memcpy(most, least, dimensions * sizeof *most);
  for (size_t i = begin + 1; i < end; i++) {
    const double *point = point_at(search, i);
    for (uint32_t d = 0; d < dimensions; d++) {
      least[d] = point[d] < least[d] ? point[d] : least[d];
      most[d] = point[d] > most[d] ? point[d] : most[d];
    }
  }
  if (level == search->levels) return;
  uint32_t widest = 0;
  for (uint32_t d = 1; d < dimensions; d++)
    if (most[d] - least[d] > most[widest] - least[widest]) widest = d;
  const size_t middle = begin_of(search, level + 1, 2 * place + 1);
  part(search, (ptrdiff_t)begin, (ptrdiff_t)end - 1, (ptrdiff_t)middle, widest);
  build(search, level + 1, 2 * place);
  build(search, level + 1, 2 * place + 1);
}

/* How far it is from the larger coordinate over the border to the smaller one: each of the two is near the border,
 * where their difference would lose what is small. */
static double the_other_way(const pair_search *search, double larger, double smaller) {
  return (search->period - larger) + smaller;
}

/* Squared: no two points of two nodes are closer. */
static double boxes_apart(const pair_search *search, size_t a, size_t b) {
  const uint32_t dimensions = search->dimensions;
  const double *a_least = box_of(search, a), *a_most = a_least + dimensions;
  const double *b_least = box_of(search, b), *b_most = b_least + dimensions;
  double sum = 0.0;
  for (uint32_t d = 0; d < dimensions; d++) {
    const int a_below = a_most[d] < b_least[d], b_below = b_most[d] < a_least[d];
    if (!a_below && !b_below) continue;
    const double across = a_below ? b_least[d] - a_most[d] : a_least[d] - b_most[d];
    const double around =
        a_below ? the_other_way(search, b_most[d], a_least[d]) : the_other_way(search, a_most[d], b_least[d]);
    const double gap = across < around ? across : around;
    sum += gap * gap;
  }
  return sum;
}

static void compare_points(pair_search *search, const double *a, const double *b) {
  double sum = 0.0;
  for (uint32_t d = 0; d < search->dimensions; d++) {
    const double across = fabs(a[d] - b[d]);
    const double around = a[d] > b[d] ? the_other_way(search, a[d], b[d]) : the_other_way(search, b[d], a[d]);
    const double apart = across < around ? across : around;
    sum += apart * apart;
  }
  if (sum >= search->best) return;
  search->best = sum;
  search->closest[0] = a;
  search->closest[1] = b;
}

/* Compares the points of two nodes of a level, or of one with each other where they are the same. */
static void compare_nodes(pair_search *search, uint32_t level, size_t a, size_t b) {
  if (a != b && boxes_apart(search, ((size_t)1 << level) + a, ((size_t)1 << level) + b) >= search->best) return;
  if (level < search->levels) {
    compare_nodes(search, level + 1, 2 * a, 2 * b);
    compare_nodes(search, level + 1, 2 * a + 1, 2 * b + 1);
    compare_nodes(search, level + 1, 2 * a, 2 * b + 1);
    if (a != b) compare_nodes(search, level + 1, 2 * a + 1, 2 * b);
    return;
  }
  const size_t a_end = begin_of(search, level, a + 1), b_end = begin_of(search, level, b + 1);
  for (size_t i = begin_of(search, level, a); i < a_end; i++)
    for (size_t j = a == b ? i + 1 : begin_of(search, level, b); j < b_end; j++)
      compare_points(search, point_at(search, i), point_at(search, j));
}

static asc_status min_distance_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                        asc_error *error) {
  const uint32_t dimensions = set->dimensions;
  pair_search search = {.dimensions = dimensions, .count = set->count, .best = INFINITY};
  search.period = values[TORUS] != 0.0 ? SCALE : INFINITY;
  if (set->count < 2) return asc_fail(error, ASC_UNSUPPORTED, "min-distance is of two points or more; this is one");
  if (set->count > MOST_POINTS) return asc_fail(error, ASC_UNSUPPORTED, "min-distance is of up to 2^31 points");
  while (set->count >> search.levels > LEAF) search.levels++;
  const size_t nodes = (size_t)2 << search.levels;
  search.points = calloc(set->count * dimensions, sizeof *search.points);
  search.boxes = malloc(2 * nodes * dimensions * sizeof *search.boxes);
  if (!search.points || !search.boxes) {
    free(search.points);
    free(search.boxes);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  }
  for (size_t i = 0; i < set->count * dimensions; i++) search.points[i] = set->points[i] * SCALE;
  build(&search, 0, 0);
  compare_nodes(&search, 0, 0, 0);
  asc_measured(made, sqrt(search.best) / SCALE);
  if (2 * dimensions <= ASC_WITNESS_MOST)
    for (uint32_t i = 0; i < 2; i++)
      for (uint32_t d = 0; d < dimensions; d++) made->witness[made->witness_count++] = search.closest[i][d] / SCALE;
  free(search.points);
  free(search.boxes);
  return ASC_OK;
}

const asc_measure_interface asc_measure_min_distance = {
    .name = "min-distance",
    .title = "distance of the two closest points, exact, on the torus or off it; both points in up to four dimensions",
    .source = "Bentley 1975; Gray and Moore 2001",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .least_dimensions = 1,
    .most_dimensions = ASC_ANY_DIMENSION,
    .quick_points = 1000000,
    .evaluate = min_distance_evaluate,
};

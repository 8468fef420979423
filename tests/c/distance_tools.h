/* What the tests of patterns that keep a distance share. Distances are told as a share of the largest that n points of
 * the torus can keep (Lagae and Dutre 2008). Include after cmocka.h. */
#ifndef DISTANCE_TOOLS_H
#define DISTANCE_TOOLS_H

#include <math.h>
#include <stddef.h>

#define PI 3.14159265358979323846
#define ROUNDING 1e-14 /* of a distance below 1: the coordinates near 1 and the periods of the torus */

static inline double densest(size_t n) { return sqrt(2.0 / (sqrt(3.0) * (double)n)); }

static inline double squared_distance(const double *a, const double *b, int toroidal) {
  double dx = fabs(a[0] - b[0]), dy = fabs(a[1] - b[1]);
  if (toroidal && dx > 0.5) dx = 1.0 - dx;
  if (toroidal && dy > 0.5) dy = 1.0 - dy;
  return dx * dx + dy * dy;
}

static inline double distance(const double *a, const double *b, int toroidal) {
  return sqrt(squared_distance(a, b, toroidal));
}

/* From `place` to the nearest of n points. */
static inline double nearest(const double *points, size_t n, const double *place, int toroidal) {
  double least = 4.0;
  for (size_t i = 0; i < n; i++) {
    const double squared = squared_distance(points + 2 * i, place, toroidal);
    if (squared < least) least = squared;
  }
  return sqrt(least);
}

static inline double least_distance(const double *points, size_t n, int toroidal) {
  double least = 2.0;
  for (size_t i = 1; i < n; i++) least = fmin(least, nearest(points, i, points + 2 * i, toroidal));
  return least;
}

/* Sums over patterns, to compare two ways of making them. */
typedef struct tally {
  double sum, squares;
} tally;

static inline void count_in(tally *one, double value) {
  one->sum += value;
  one->squares += value * value;
}

/* The difference of two means in standard errors; below 5 but for one of two million. */
static inline double standard_errors(const tally *a, const tally *b, double patterns) {
  const double variance = (a->squares + b->squares - (a->sum * a->sum + b->sum * b->sum) / patterns) / patterns;
  return fabs(a->sum - b->sum) / patterns / sqrt(variance / patterns);
}

#endif

/* poisson-disk: darts that keep their distance. test_blue_noise.c has what it shares with its kin. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "distance_tools.h"
#include "sampler_tools.h"
#include "stream.h"

#define MOST 4096

/* Relaxed or not: no two points closer than min(radius, 0.95 * sqrt(sqrt(3) / (2 pi))) r_max. */
static void darts_keep_the_distance_that_is_promised(void **state) {
  (void)state;
  const size_t counts[] = {1, 2, 3, 4, 5, 16, 64, 257};
  const char *const radii[] = {"0.25", "0.5", "0.75", "1"};
  const double bound = 0.95 * sqrt(sqrt(3.0) / (2.0 * PI));
  for (size_t c = 0; c < 8; c++)
    for (size_t r = 0; r < 4; r++)
      for (int toroidal = 0; toroidal < 2; toroidal++) {
        char spec[64];
        (void)snprintf(spec, sizeof spec, "poisson-disk:radius=%s,toroidal=%d", radii[r], toroidal);
        asc_sampler *sampler = make(spec, counts[c], 2, 1);
        const double promised = fmin(strtod(radii[r], NULL), bound) * densest(counts[c]);
        for (int32_t pixel = 0; pixel < 20; pixel++) {
          double points[257 * 2];
          fill(sampler, pixel, 0, 0, counts[c], 0, 2, points);
          const double least = least_distance(points, counts[c], toroidal);
          if (least < promised - ROUNDING) fail_msg("%s, %zu points: %g < %g", spec, counts[c], least, promised);
        }
        asc_sampler_destroy(sampler);
      }
}

/* From 256 points on the default radius is kept (20,000 patterns were: none was relaxed), where the darts of `random`
 * come far closer. */
static void the_default_distance_is_kept(void **state) {
  (void)state;
  static double points[1024 * 2];
  const char *const specs[] = {"poisson-disk", "poisson-disk:toroidal=0", "random"};
  for (size_t s = 0; s < 3; s++)
    for (uint64_t seed = 0; seed < 5; seed++) {
      points_of(specs[s], 1024, 2, seed, points);
      assert_int_equal(least_distance(points, 1024, s != 1) > 0.75 * densest(1024) - ROUNDING, s < 2);
    }
}

/* How many of the first points keep a distance. */
static size_t prefix_that_keeps(const double *points, size_t n, double kept, int toroidal) {
  size_t first = 1;
  while (first < n && nearest(points, first, points + 2 * first, toroidal) > kept) first++;
  return first;
}

/* The radius of the densest packing cannot be kept. The points before the first that comes closer leave no place free:
 * none of a fine grid of places. */
static void the_radius_is_relaxed_where_no_dart_fits(void **state) {
  (void)state;
  enum { N = 256, PROBES = 500 };
  static double points[N * 2];
  for (int toroidal = 0; toroidal < 2; toroidal++) {
    points_of(toroidal ? "poisson-disk:radius=1" : "poisson-disk:radius=1,toroidal=0", N, 2, 3, points);
    const size_t first = prefix_that_keeps(points, N, densest(N) - ROUNDING, toroidal);
    assert_true(first < N);
    for (int y = 0; y < PROBES; y++)
      for (int x = 0; x < PROBES; x++) {
        const double place[2] = {(x + 0.5) / PROBES, (y + 0.5) / PROBES};
        assert_true(nearest(points, first, place, toroidal) < densest(N));
      }
  }
}

/* Discs thrown until none fits cover 0.547 of the plane (Feder 1980; 0.54707 in Zhang and Torquato 2013), that is discs
 * of half the distance kept. The share of 2,470 discs varies by 0.4 %; the bound is 5 standard errors of four. */
static void darts_come_to_rest_at_the_published_density(void **state) {
  (void)state;
  static double points[MOST * 2];
  double covered = 0.0;
  for (uint64_t seed = 0; seed < 4; seed++) {
    points_of("poisson-disk:radius=1", MOST, 2, seed, points);
    const size_t first = prefix_that_keeps(points, MOST, densest(MOST) - ROUNDING, 1);
    covered += (double)first * PI * densest(MOST) * densest(MOST) / 4.0 / 4.0;
  }
  assert_true(fabs(covered - 0.54707) < 0.01 * 0.54707);
}

/* Plain dart throwing, each dart against all points. */
static void throw_plainly(asc_stream *stream, size_t n, double radius, double *points) {
  for (size_t placed = 0; placed < n;) {
    double *dart = points + 2 * placed;
    dart[0] = asc_stream_unit(stream);
    dart[1] = asc_stream_unit(stream);
    placed += nearest(points, placed, dart, 1) >= radius;
  }
}

#define SHELLS 3

/* Pairs of the first n points at up to 1.1, 1.1 to 1.4 and 1.4 to 2 radii. */
static void count_pairs(const double *points, size_t n, double radius, double pairs[SHELLS]) {
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < i; j++) {
      const double radii = distance(points + 2 * i, points + 2 * j, 1) / radius;
      if (radii < 2.0) pairs[radii < 1.1 ? 0 : radii < 1.4 ? 1 : 2] += 1.0;
    }
}

static void darts_are_those_of_plain_throwing(void **state) {
  (void)state;
  enum { N = 40, PATTERNS = 600 };
  tally tallies[2][2 * SHELLS] = {{{0.0, 0.0}}};
  const double radius = 0.7 * densest(N);
  asc_sampler *sampler = make("poisson-disk:radius=0.7", N, 2, 5);
  asc_stream stream;
  asc_stream_begin(&stream, asc_stream_key(99, 0, 0), 0);
  for (int32_t pattern = 0; pattern < PATTERNS; pattern++)
    for (int plainly = 0; plainly < 2; plainly++) {
      double points[N * 2], pairs[2 * SHELLS] = {0.0};
      if (plainly)
        throw_plainly(&stream, N, radius, points);
      else
        fill(sampler, pattern, 0, 0, N, 0, 2, points);
      count_pairs(points, N, radius, pairs);
      count_pairs(points, N / 2, radius, pairs + SHELLS); /* in the order of their placement */
      for (int k = 0; k < 2 * SHELLS; k++) count_in(&tallies[plainly][k], pairs[k]);
    }
  asc_sampler_destroy(sampler);
  for (int k = 0; k < 2 * SHELLS; k++) assert_true(standard_errors(&tallies[0][k], &tallies[1][k], PATTERNS) < 5.0);
}

/* Without the torus, points face each other across the edges. */
static void only_on_the_torus_are_edges_kept_apart(void **state) {
  (void)state;
  asc_sampler *torus = make("poisson-disk", 256, 2, 2), *square = make("poisson-disk:toroidal=0", 256, 2, 2);
  double points[256 * 2];
  fill(torus, 0, 0, 0, 256, 0, 2, points);
  assert_true(least_distance(points, 256, 1) >= 0.75 * densest(256) - ROUNDING);
  fill(square, 0, 0, 0, 256, 0, 2, points);
  assert_true(least_distance(points, 256, 0) >= 0.75 * densest(256) - ROUNDING);
  assert_true(least_distance(points, 256, 1) < 0.5 * densest(256));
  asc_sampler_destroy(torus);
  asc_sampler_destroy(square);
}

/* 2^20 points, checked with a grid whose cells are as wide as the distance: each against its 3 x 3 cells. */
static void many_darts_keep_their_distance(void **state) {
  (void)state;
#ifdef __SANITIZE_ADDRESS__
  const uint32_t n = 1u << 16; /* twenty times slower */
#else
  const uint32_t n = 1u << 20;
#endif
  const double kept = 0.75 * densest(n) - ROUNDING;
  const uint32_t side = (uint32_t)(1.0 / kept);
  double *points = malloc(n * 2 * sizeof *points);
  uint32_t *first = calloc((size_t)side * side, sizeof *first), *next = malloc(n * sizeof *next);
  assert_true(points && first && next);
  points_of("poisson-disk", n, 2, 1, points);
  for (uint32_t i = 0; i < n; i++) {
    const uint32_t column = (uint32_t)(points[2 * i] * side), row = (uint32_t)(points[2 * i + 1] * side);
    for (uint32_t k = 0; k < 9; k++) {
      const uint32_t x = (column + side + k % 3 - 1) % side, y = (row + side + k / 3 - 1) % side;
      for (uint32_t j = first[y * side + x]; j; j = next[j - 1])
        assert_true(distance(points + (size_t)2 * i, points + (size_t)2 * (j - 1), 1) >= kept);
    }
    next[i] = first[row * side + column];
    first[row * side + column] = i + 1;
  }
  free(points);
  free(first);
  free(next);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(darts_keep_the_distance_that_is_promised),
      cmocka_unit_test(the_default_distance_is_kept),
      cmocka_unit_test(the_radius_is_relaxed_where_no_dart_fits),
      cmocka_unit_test(darts_come_to_rest_at_the_published_density),
      cmocka_unit_test(darts_are_those_of_plain_throwing),
      cmocka_unit_test(only_on_the_torus_are_edges_kept_apart),
      cmocka_unit_test(many_darts_keep_their_distance),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

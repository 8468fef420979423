/* Nets, sequences and lattices: zaremba, larcher-pillichshammer, pmj02, r2, lattice. test_nets.py has those of them
 * that are checked against exact arithmetic. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sampler_tools.h"

#define MOST 1024

/* How many of the 2^m points, for every shape 2^-a x 2^-(m-a), lie in an elementary interval that has one already. */
static int crowded(const double *points, uint32_t stride, int m) {
  int found = 0;
  for (int a = 0; a <= m; a++) {
    unsigned char seen[MOST] = {0};
    for (size_t i = 0; i < (size_t)1 << m; i++) {
      const int column = (int)(points[i * stride] * (1 << a)), row = (int)(points[i * stride + 1] * (1 << (m - a)));
      found += seen[(row << a) + column]++ != 0;
    }
  }
  return found;
}

static void larcher_pillichshammer_is_a_net(void **state) {
  (void)state;
  for (int m = 0; m <= 10; m++) {
    double points[MOST * 2];
    points_of("larcher-pillichshammer", (uint64_t)1 << m, 2, 0, points);
    assert_int_equal(crowded(points, 2, m), 0);
  }
}

/* The loop that defines y, at indices of all lengths and at the last. */
static void larcher_pillichshammer_is_its_definition(void **state) {
  (void)state;
  asc_sampler *sampler = make("larcher-pillichshammer", (uint64_t)1 << 32, 2, 0);
  for (uint64_t step = 0; step < 4000; step++) {
    const uint32_t index = step == 0 ? UINT32_MAX : (uint32_t)(step * 0x9e3779b9u) >> (step % 32);
    uint32_t y = 0, v = 1u << 31;
    for (uint32_t i = index; i; i >>= 1, v |= v >> 1)
      if (i & 1u) y ^= v;
    double point[2], expected[2] = {index * 0x1p-32, y * 0x1p-32};
    for (int d = 0; d < 2; d++) /* what sampler.h says of values next to 1 */
      if (expected[d] >= 1.0 - 0x1p-25) expected[d] = 1.0 - 0x1p-24;
    fill(sampler, 0, 0, index, 1, 0, 2, point);
    assert_true(point[0] == expected[0]);
    assert_true(point[1] == expected[1]);
  }
  asc_sampler_destroy(sampler);
}

/* Zaremba's digits only turn those of the radical inverse, the same for all points: still a net. */
static void finite_zaremba_is_a_net(void **state) {
  (void)state;
  for (int m = 0; m <= 10; m++) {
    double points[MOST * 2];
    points_of("zaremba:digits=finite", (uint64_t)1 << m, 2, 0, points);
    assert_int_equal(crowded(points, 2, m), 0);
  }
}

static void every_aligned_run_of_pmj02_is_a_net(void **state) {
  (void)state;
  const uint64_t seeds[] = {0, 77, UINT64_MAX};
  const int32_t places[][2] = {{0, 0}, {-5, 1 << 20}, {INT32_MAX, INT32_MIN}};
  const uint64_t firsts[] = {0, 5 * MOST, ((uint64_t)1 << 32) - MOST};
  for (size_t s = 0; s < 3; s++) {
    asc_sampler *sampler = make("pmj02", 1, 6, seeds[s]);
    for (size_t k = 0; k < 9; k++) {
      static double points[MOST * 6];
      fill(sampler, places[k % 3][0], places[k % 3][1], firsts[k / 3], MOST, 0, 6, points);
      for (size_t i = 0; i < (size_t)MOST * 6; i++) assert_true(points[i] * 0x1p32 == floor(points[i] * 0x1p32));
      for (size_t pair = 0; pair < 3; pair++)
        for (int m = 0; m <= 10; m++)
          for (size_t run = 0; run < (size_t)MOST >> m; run++)
            assert_int_equal(crowded(points + (run << m) * 6 + 2 * pair, 6, m), 0);
    }
    asc_sampler_destroy(sampler);
  }
}

/* Points by the table and by runs are those made one by one, at indices of all lengths. */
static void pmj02_is_the_same_one_by_one(void **state) {
  (void)state;
  asc_sampler *sampler = make("pmj02", 1, 5, 3);
  for (uint64_t step = 0; step < 60; step++) {
    const uint64_t first = ((uint64_t)0xfffffe00u >> (step % 32)) + step;
    static double points[300 * 5];
    fill(sampler, 4, 2, first > 0xfffffe00u ? 0xfffffe00u : first, 300, 0, 5, points);
    for (size_t i = step % 7; i < 300; i += 7) {
      double point[5];
      fill(sampler, 4, 2, (first > 0xfffffe00u ? 0xfffffe00u : first) + i, 1, 0, 5, point);
      assert_memory_equal(point, points + i * 5, sizeof point);
    }
  }
  asc_sampler_destroy(sampler);
}

/* Upper quantile 1 - 1e-6 of chi-squared with k degrees of freedom (Wilson and Hilferty 1931). */
static double chi_squared_limit(double k) {
  const double spread = 2.0 / (9.0 * k), root = 1.0 - spread + 4.7534243 * sqrt(spread);
  return k * root * root * root;
}

static void assert_equally_often(const unsigned *counts, size_t cells, double draws, const char *what) {
  double sum = 0.0;
  for (size_t i = 0; i < cells; i++) sum += (counts[i] - draws / (double)cells) * (counts[i] - draws / (double)cells);
  const double statistic = sum / (draws / (double)cells);
  if (statistic > chi_squared_limit((double)cells - 1.0)) fail_msg("%s: chi-squared %g", what, statistic);
}

#define PIXELS 65536

/* What is free in the first four points, to two digits: the cell of the first (16), the second digits of the second
 * (4), and which quarter comes third (2). All 128 are equally likely, and so are the 8 bits that come below, of one
 * point. */
static void pmj02_places_its_points_at_random(void **state) {
  (void)state;
  asc_sampler *sampler = make("pmj02", 4, 4, 8);
  static unsigned counts[2][128], below[2][256], joint[256];
  memset(counts, 0, sizeof counts);
  memset(below, 0, sizeof below);
  memset(joint, 0, sizeof joint);
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    double points[4][4];
    fill(sampler, pixel % 256, pixel / 256, 0, 4, 0, 4, points[0]);
    for (size_t pair = 0; pair < 2; pair++) {
      const double *first = points[0] + 2 * pair, *second = points[1] + 2 * pair, *third = points[2] + 2 * pair;
      const unsigned cell = (unsigned)(first[0] * 4) * 4 + (unsigned)(first[1] * 4);
      const unsigned digits = ((unsigned)(second[0] * 4) & 1u) * 2 + ((unsigned)(second[1] * 4) & 1u);
      const unsigned same_half = (first[0] < 0.5) == (third[0] < 0.5);
      counts[pair][cell * 8 + digits * 2 + same_half]++;
      const double *point = points[pixel % 4] + 2 * pair; /* digits 3 to 6 of x and y */
      below[pair][((unsigned)(point[0] * 64) & 15u) * 16 + ((unsigned)(point[1] * 64) & 15u)]++;
    }
    /* The pairs against each other: two digits of each coordinate of one point. */
    unsigned code = 0;
    for (int d = 0; d < 4; d++) code = code * 4 + (unsigned)(points[(pixel / 4) % 4][d] * 4);
    joint[code]++;
  }
  asc_sampler_destroy(sampler);
  for (size_t pair = 0; pair < 2; pair++) {
    assert_equally_often(counts[pair], 128, PIXELS, "first four points");
    assert_equally_often(below[pair], 256, PIXELS, "digits below");
  }
  assert_equally_often(joint, 256, PIXELS, "pairs against each other");
}

/* Where the third and fourth, fifth to eighth and ninth to sixteenth points come among those of their own generation is
 * free in the order's tree: 1, 3 and 7 bits, all 2048 equally likely. The first digits of x show them: for each point
 * of those generations, digit k of its place, up to what turns all of them, is digit k of x turned by that of point 0.
 */
static void pmj02_orders_its_points_at_random(void **state) {
  (void)state;
  asc_sampler *sampler = make("pmj02", 16, 2, 5);
  static unsigned counts[2048];
  memset(counts, 0, sizeof counts);
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    double points[16][2];
    fill(sampler, pixel % 256, pixel / 256, 0, 16, 0, 2, points[0]);
    unsigned place[16] = {
        0}; /* digit 1 of x is the lowest bit of the place; digit 2 is seen within its half, and so on */
    for (int k = 0; k < 4; k++)
      for (int i = 0; i < 16; i++) {
        int leader =
            0; /* the first point whose place agrees in the bits before k has bit k unset, as it is less than 2^k */
        for (int j = 0; j < 16 && k > 0; j++)
          if (j < (1 << k) && (place[j] & ((1u << k) - 1u)) == (place[i] & ((1u << k) - 1u))) leader = j;
        const unsigned digit = (unsigned)(points[i][0] * 16) >> (3 - k),
                       of_leader = (unsigned)(points[leader][0] * 16) >> (3 - k);
        place[i] |= ((digit ^ of_leader) & 1u) << k;
      }
    const unsigned code = (place[2] & 1u) | (place[4] & 3u) << 1 | (place[6] & 1u) << 3 | (place[8] & 7u) << 4 |
                          (place[10] & 1u) << 7 | (place[12] & 3u) << 8 | (place[14] & 1u) << 10;
    counts[code]++;
  }
  asc_sampler_destroy(sampler);
  assert_equally_often(counts, 2048, PIXELS, "order");
}

static void fibonacci_lattices_are_those_that_there_are(void **state) {
  (void)state;
  const uint64_t numbers[] = {1, 2, 3, 5, 8, 13, 55, 1346269, 8944394323791464u};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
    assert_int_equal(created("lattice", numbers[i], 2), ASC_OK);
  const uint64_t others[] = {4, 6, 100, 1346268, 8944394323791463u, (uint64_t)1 << 53};
  for (size_t i = 0; i < sizeof others / sizeof *others; i++)
    assert_int_equal(created("lattice", others[i], 2), ASC_UNSUPPORTED);
  const asc_sampler_desc desc = {sizeof desc, "lattice", 100, 2, 0};
  asc_sampler *sampler = NULL;
  asc_error error;
  assert_int_equal(asc_sampler_create(&desc, &sampler, &error), ASC_UNSUPPORTED);
  assert_non_null(strstr(error.text, "choose 89 or 144"));
}

/* Each coordinate of a lattice of rank 1 takes each of 0, 1/N, ... once, as z is a unit; and differences of points are
 * points. */
static void lattices_are_lattices(void **state) {
  (void)state;
  const uint32_t counts[] = {1, 2, 3, 7, 64, 89, 100, 1000};
  for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
    const uint32_t n = counts[k];
    static double points[1000 * 5];
    points_of("lattice", n, 5, 0, points);
    for (size_t d = 0; d < 5; d++) {
      unsigned char seen[1000] = {0};
      for (size_t i = 0; i < n; i++) {
        const uint32_t at = (uint32_t)lround(points[i * 5 + d] * n);
        assert_true(points[i * 5 + d] == (double)at / n);
        assert_int_equal(seen[at]++, 0);
        assert_int_equal(at, i * (uint32_t)lround(points[(n > 1 ? 5u : 0u) + d] * n) % n);
      }
    }
  }
}

/* Ends: how many points, how many dimensions, which index is the last. */
static void ends_are_as_stated(void **state) {
  (void)state;
  const uint64_t e32 = (uint64_t)1 << 32, e53 = (uint64_t)1 << 53;
  const struct {
    const char *spec;
    uint64_t samples;
    uint32_t dimensions;
    asc_status status;
  } ends[] = {
      {"zaremba", 1, 2, ASC_OK},
      {"zaremba", e53, 2, ASC_OK},
      {"zaremba:digits=finite", e53, 2, ASC_OK},
      {"zaremba", 16, 1, ASC_UNSUPPORTED},
      {"zaremba", 16, 1024, ASC_UNSUPPORTED},
      {"larcher-pillichshammer", e32, 2, ASC_OK},
      {"larcher-pillichshammer", e32 + 1, 2, ASC_UNSUPPORTED},
      {"larcher-pillichshammer", 16, 1, ASC_UNSUPPORTED},
      {"larcher-pillichshammer", 16, 1024, ASC_UNSUPPORTED},
      {"pmj02", e32, 1024, ASC_OK},
      {"pmj02", e32 + 1, 2, ASC_UNSUPPORTED},
      {"pmj02", 1, 1, ASC_OK},
      {"r2", e53, 1024, ASC_OK},
      {"r2", 1, 1, ASC_OK},
      {"r2", 1, 1u << 18, ASC_OK},
      {"r2", 1, (1u << 18) + 1, ASC_UNSUPPORTED},
      {"lattice", e53, 1, ASC_OK},
      {"lattice", 8, 1024, ASC_OK},
      {"lattice", 8, 1025, ASC_UNSUPPORTED},
      {"lattice", 1u << 20, 3, ASC_OK},
      {"lattice", (1u << 20) + 1, 3, ASC_UNSUPPORTED},
  };
  for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
    if (created(ends[i].spec, ends[i].samples, ends[i].dimensions) != ends[i].status)
      fail_msg("%s, %llu points, %u dimensions", ends[i].spec, (unsigned long long)ends[i].samples, ends[i].dimensions);
    if (ends[i].status) continue;
    static double row[1u << 18];
    asc_sampler *sampler = make(ends[i].spec, ends[i].samples, ends[i].dimensions, UINT64_MAX);
    const uint32_t d = ends[i].dimensions;
    const uint64_t end = strcmp(ends[i].spec, "r2") == 0      ? e53
                         : strcmp(ends[i].spec, "pmj02") == 0 ? e32
                                                              : ends[i].samples;
    fill(sampler, INT32_MIN, INT32_MAX, end - 1, 1, 0, d, row);
    for (uint32_t j = 0; j < d; j++) assert_true(row[j] >= 0.0 && (float)row[j] < 1.0f);
    const asc_range past = {0, 0, end, 1, 0, d};
    assert_int_equal(asc_sampler_fill(sampler, &past, row), ASC_UNSUPPORTED);
    asc_sampler_destroy(sampler);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(larcher_pillichshammer_is_a_net),
      cmocka_unit_test(larcher_pillichshammer_is_its_definition),
      cmocka_unit_test(finite_zaremba_is_a_net),
      cmocka_unit_test(every_aligned_run_of_pmj02_is_a_net),
      cmocka_unit_test(pmj02_is_the_same_one_by_one),
      cmocka_unit_test(pmj02_places_its_points_at_random),
      cmocka_unit_test(pmj02_orders_its_points_at_random),
      cmocka_unit_test(fibonacci_lattices_are_those_that_there_are),
      cmocka_unit_test(lattices_are_lattices),
      cmocka_unit_test(ends_are_as_stated),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

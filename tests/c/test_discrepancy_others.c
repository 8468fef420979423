/* star-bounds, dispersion, min-distance and t-value: what they promise whatever the points, and the extremes. That
 * their values are right is tested against fractions and scipy in tests/python/test_discrepancy_others.py. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/discrepancy.h"
#include "sampler_tools.h"

#define LAST (1.0 - 0x1p-53)

/* With so little work that sanitizers take seconds. */
static const char *const specs[] = {"star-bounds:work=1,iterations=200",
                                    "star-bounds:work=1,iterations=200,gap=0",
                                    "star-bounds:work=1,iterations=0,gap=0.001",
                                    "star-bounds:work=0,iterations=200",
                                    "dispersion",
                                    "dispersion:of=disc",
                                    "min-distance",
                                    "min-distance:torus=0",
                                    "t-value",
                                    "t-value:base=3"};
#define SPECS (sizeof specs / sizeof *specs)

static asc_status try_measure(const char *spec, const double *points, size_t count, uint32_t dimensions, uint64_t seed,
                              asc_measurement *made, asc_error *error) {
  const asc_discrepancy_desc desc = {sizeof desc, spec, points, count, dimensions, seed};
  *made = (asc_measurement){.struct_size = sizeof *made};
  return asc_discrepancy(&desc, made, error);
}

static asc_measurement measured(const char *spec, const double *points, size_t count, uint32_t dimensions) {
  asc_measurement made;
  asc_error error = {{0}};
  if (try_measure(spec, points, count, dimensions, 5, &made, &error)) fail_msg("%s: %s", spec, error.text);
  return made;
}

static double value(const char *spec, const double *points, size_t count) {
  return measured(spec, points, count, 2).value;
}

/* What holds for all results, of `count` points in whatever dimensions the measure does. */
static void check_contract(const char *spec, const double *points, size_t count, uint32_t dimensions) {
  asc_measurement made, again;
  asc_error error = {{0}};
  const asc_status status = try_measure(spec, points, count, dimensions, 5, &made, &error);
  if (status == ASC_UNSUPPORTED) {
    assert_true(strlen(error.text) > 20);
    return;
  }
  assert_int_equal(status, ASC_OK);
  assert_int_equal(try_measure(spec, points, count, dimensions, 5, &again, &error), ASC_OK);
  assert_memory_equal(&made, &again, sizeof made);
  assert_true(isfinite(made.value) && made.value >= 0.0);
  assert_true(made.lower <= made.value && made.value <= made.upper);
  assert_true(made.witness_count <= ASC_WITNESS_MOST);
  if (strncmp(spec, "star-bounds", 11) == 0) {
    assert_int_equal(made.certainty, ASC_BOUNDS);
    assert_true(made.upper <= 1.0 && made.value == made.lower);
  } else {
    assert_int_equal(made.certainty, ASC_EXACT);
    assert_true(made.lower == made.upper);
  }
}

static void results_keep_the_contract(void **state) {
  (void)state;
  enum { MOST = 512, DIMENSIONS = 9 };
  static double points[MOST * DIMENSIONS];
  static const size_t counts[] = {1, 2, 3, 9, 10, 64, MOST};
  for (uint32_t dimensions = 1; dimensions <= DIMENSIONS; dimensions += dimensions < 4 ? 1 : 5)
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
      points_of("random", counts[c], dimensions, 7, points);
      for (size_t i = 0; i < SPECS; i++) check_contract(specs[i], points, counts[c], dimensions);
    }
}

/* Sets without extent: all points at one place, on a line, on the border, next to 1. */
static void degenerate_sets_keep_the_contract(void **state) {
  (void)state;
  enum { N = 81 };
  static double points[N * 2];
  static const double places[][2] = {{0.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}, {0.5, 0.5}, {LAST, LAST}, {LAST, 0.0}};
  for (size_t p = 0; p < sizeof places / sizeof *places; p++)
    for (int along = 0; along < 4; along++) {
      for (size_t i = 0; i < N; i++) {
        const double share = (double)i / (N - 1);
        points[2 * i] = along & 1 ? share : places[p][0];
        points[2 * i + 1] = along & 2 ? share : places[p][1];
      }
      for (size_t i = 0; i < SPECS; i++)
        for (size_t n = 1; n <= N; n *= 3) check_contract(specs[i], points, n, 2);
    }
}

static void one_point_and_equal_points(void **state) {
  (void)state;
  enum { N = 64 };
  static double points[N * 2];
  for (size_t i = 0; i < N; i++) {
    points[2 * i] = 0.25;
    points[2 * i + 1] = 0.5;
  }
  for (size_t n = 1; n <= N; n += N - 1) {
    assert_true(value("star-bounds:gap=0", points, n) == 0.875);
    assert_true(value("dispersion", points, n) == 0.75);
    assert_true(value("dispersion:of=disc", points, n) == sqrt(0.75 * 0.75 + 0.25));
  }
  assert_true(value("min-distance", points, N) == 0.0);
  assert_true(value("t-value", points, N) == 6.0);
  assert_true(value("t-value", points, 1) == 0.0);
}

static void witnesses_attain_the_value(void **state) {
  (void)state;
  enum { N = 100 };
  static double points[N * 2];
  points_of("random", N, 2, 3, points);
  const asc_measurement box = measured("dispersion", points, N, 2), disc = measured("dispersion:of=disc", points, N, 2);
  const asc_measurement pair = measured("min-distance:torus=0", points, N, 2);
  assert_int_equal(box.witness_count, 4);
  assert_int_equal(disc.witness_count, 3);
  assert_int_equal(pair.witness_count, 4);
  assert_true((box.witness[2] - box.witness[0]) * (box.witness[3] - box.witness[1]) == box.value);
  assert_true(disc.witness[2] == disc.value);
  assert_float_equal(hypot(pair.witness[0] - pair.witness[2], pair.witness[1] - pair.witness[3]), pair.value, 1e-16);
  for (size_t i = 0; i < N; i++) {
    const double x = points[2 * i], y = points[2 * i + 1];
    assert_false(x > box.witness[0] && x < box.witness[2] && y > box.witness[1] && y < box.witness[3]);
    /* A rounding each of the differences, the squares, the sum and the root. */
    assert_true(hypot(x - disc.witness[0], y - disc.witness[1]) >= disc.value - 4 * 0x1p-53);
  }
}

static void refusals_say_why(void **state) {
  (void)state;
  static const double points[] = {0.5, 0.5, 0.25, 1.0, 0.75, 0.0};
  static const struct {
    const char *spec;
    size_t count;
    uint32_t dimensions;
    asc_status status;
    const char *says;
  } cases[] = {
      {"min-distance", 1, 2, ASC_UNSUPPORTED, "two points or more"},
      {"t-value", 3, 2, ASC_UNSUPPORTED, "power of 2 points"},
      {"t-value", 2, 2, ASC_UNSUPPORTED, "coordinate of 1"},
      {"dispersion", 2, 3, ASC_UNSUPPORTED, "2 dimensions"},
      {"dispersion:of=ball", 3, 2, ASC_INVALID_VALUE, "of"},
      {"star-bounds:gap=-1", 3, 2, ASC_INVALID_VALUE, "gap"},
      {"star-bounds:iterations=0.5", 3, 2, ASC_INVALID_VALUE, "iterations"},
      {"t-value:base=1", 1, 2, ASC_INVALID_VALUE, "base"},
      {"min-distance:torsu=1", 3, 2, ASC_UNKNOWN_KEY, "torus"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    asc_measurement made;
    asc_error error = {{0}};
    assert_int_equal(try_measure(cases[i].spec, points, cases[i].count, cases[i].dimensions, 0, &made, &error),
                     cases[i].status);
    if (!strstr(error.text, cases[i].says)) fail_msg("%s: %s", cases[i].spec, error.text);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(results_keep_the_contract),  cmocka_unit_test(degenerate_sets_keep_the_contract),
      cmocka_unit_test(one_point_and_equal_points), cmocka_unit_test(witnesses_attain_the_value),
      cmocka_unit_test(refusals_say_why),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

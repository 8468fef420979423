/* What holds of every registered measure, at the extremes too. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/discrepancy.h"

#define MOST_POINTS 300
#define MOST_DIMENSIONS 4
#define BELOW_ONE 0x1.fffffffffffffp-1 /* 1 - 2^-53 */

static asc_status measured(const char *spec, const double *points, size_t count, uint32_t dimensions, uint64_t seed,
                           asc_measurement *made, asc_error *error) {
  const asc_discrepancy_desc desc = {sizeof desc, spec, points, count, dimensions, seed};
  *made = (asc_measurement){.struct_size = sizeof *made};
  return asc_discrepancy(&desc, made, error);
}

/* The spec of a measure in which few edges, boxes or steps are drawn, so that tests are quick. */
static void quick_spec(const asc_measure_info *info, char spec[128]) {
  (void)snprintf(spec, 128, "%s", info->name);
  for (size_t k = 0; k < info->parameter_count; k++)
    if (strcmp(info->parameters[k].name, "draws") == 0 && info->parameters[k].fallback > 500)
      (void)snprintf(spec, 128, "%s:draws=500", info->name);
}

static asc_measure_info described(size_t index) {
  asc_measure_info info;
  assert_int_equal(asc_measure_describe(index, &info), ASC_OK);
  return info;
}

/* A measure may say that it does not do a set, with a reason. */
static void check_measurement(const char *spec, const double *points, size_t count, uint32_t dimensions) {
  asc_measurement made, again;
  asc_error error = {{0}};
  const asc_status status = measured(spec, points, count, dimensions, 7, &made, &error);
  if (status == ASC_UNSUPPORTED) {
    assert_true(strlen(error.text) > 0);
    return;
  }
  if (status) fail_msg("%s of %zu points in %u dimensions: %s", spec, count, dimensions, error.text);
  assert_int_equal(made.struct_size, sizeof made);
  assert_true(isfinite(made.value) && isfinite(made.standard_error) && made.standard_error >= 0.0);
  assert_true(made.lower <= made.value && made.value <= made.upper);
  if (made.certainty == ASC_EXACT) assert_true(made.lower == made.upper && made.standard_error == 0.0);
  if (made.certainty == ASC_BOUNDS) assert_true(made.value == made.lower || made.value == made.upper);
  assert_true(made.witness_count <= ASC_WITNESS_MOST && made.closed <= 1);
  for (uint32_t k = 0; k < made.witness_count; k++) assert_true(isfinite(made.witness[k]));
  assert_int_equal(measured(spec, points, count, dimensions, 7, &again, NULL), ASC_OK);
  assert_memory_equal(&made, &again, offsetof(asc_measurement, closed) + sizeof made.closed); /* no padding before */
}

static void every_measure_says_what_it_is(void **state) {
  (void)state;
  assert_true(asc_measure_count() > 0);
  asc_measure_info none;
  assert_int_equal(asc_measure_describe(asc_measure_count(), &none), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_measure_describe(0, NULL), ASC_INVALID_ARGUMENT);
  for (size_t i = 0; i < asc_measure_count(); i++) {
    const asc_measure_info info = described(i);
    assert_true(strlen(info.name) > 0 && strlen(info.title) > 0 && strlen(info.source) > 0);
    assert_true(info.quick_points > 0);
    assert_true(info.least_dimensions >= 1 && info.least_dimensions <= info.most_dimensions);
    char canonical[512];
    assert_int_equal(asc_measure_canonical(info.name, canonical, sizeof canonical, NULL), ASC_OK);
    assert_string_equal(canonical, info.name);
    for (size_t j = 0; j < i; j++) assert_string_not_equal(described(j).name, info.name);
  }
}

/* Fills every set of the list in `dimensions` dimensions; returns its number of points, 0 after the last. */
static size_t extreme_set(size_t index, uint32_t dimensions, double *points) {
  static const double single[] = {0.3, 0.5, 0.0, 1.0, BELOW_ONE, 0x1p-1074, 0x1p-53};
  const size_t singles = sizeof single / sizeof *single;
  const size_t count = index < singles ? 1 : 9;
  const size_t many = index < singles ? 0 : index - singles;
  if (many >= singles + 4) return 0;
  for (size_t i = 0; i < count; i++)
    for (uint32_t d = 0; d < dimensions; d++) {
      double *value = &points[i * dimensions + d];
      const double along = (double)i / 8.0; /* of nine points */
      if (index < singles)
        *value = single[index]; /* one point */
      else if (many < singles)
        *value = single[many]; /* equal points */
      else if (many == singles)
        *value = along; /* the diagonal */
      else if (many == singles + 1)
        *value = d ? 0.25 : along; /* a line */
      else if (many == singles + 2)
        *value = d == 0 ? (double)(i % 2) : along; /* two sides of the border */
      else
        *value = (double)(i >> d & 1u); /* the corners, some of them more than once */
    }
  return count;
}

static void extremes_are_measured(void **state) {
  (void)state;
  for (size_t m = 0; m < asc_measure_count(); m++) {
    const asc_measure_info info = described(m);
    char spec[128];
    quick_spec(&info, spec);
    for (uint32_t dimensions = 1; dimensions <= MOST_DIMENSIONS; dimensions++) {
      if (dimensions < info.least_dimensions || dimensions > info.most_dimensions) continue;
      double points[MOST_POINTS * MOST_DIMENSIONS];
      for (size_t index = 0;; index++) {
        const size_t count = extreme_set(index, dimensions, points);
        if (count == 0) break;
        check_measurement(spec, points, count, dimensions);
      }
    }
  }
}

/* Counts around the lengths of runs and blocks, where memory may be read past its end. */
static void counts_about_powers_of_two_are_measured(void **state) {
  (void)state;
  static const size_t counts[] = {2, 3, 31, 32, 33, 63, 64, 65, 255, 256, 257};
  double points[MOST_POINTS * 2];
  for (size_t i = 0; i < MOST_POINTS; i++) {
    points[2 * i] = (double)(i * 97 % MOST_POINTS) / MOST_POINTS;
    points[2 * i + 1] = (double)(i * i % MOST_POINTS) / MOST_POINTS;
  }
  for (size_t m = 0; m < asc_measure_count(); m++) {
    const asc_measure_info info = described(m);
    if (info.least_dimensions > 2 || info.most_dimensions < 2) continue;
    char spec[128];
    quick_spec(&info, spec);
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) check_measurement(spec, points, counts[k], 2);
  }
}

static void what_is_no_point_set_is_refused(void **state) {
  (void)state;
  const double wrong[] = {NAN, INFINITY, -INFINITY, -0x1p-1074, 0x1.0000000000001p0};
  for (size_t m = 0; m < asc_measure_count(); m++) {
    const asc_measure_info info = described(m);
    const uint32_t dimensions = info.least_dimensions;
    double points[3 * 8] = {0.0};
    asc_measurement made;
    asc_error error = {{0}};
    assert_true(dimensions <= 8);
    assert_int_equal(measured(info.name, NULL, 3, dimensions, 0, &made, &error), ASC_INVALID_ARGUMENT);
    assert_int_equal(measured(info.name, points, 0, dimensions, 0, &made, &error), ASC_INVALID_ARGUMENT);
    assert_int_equal(measured(info.name, points, 3, 0, 0, &made, &error), ASC_INVALID_ARGUMENT);
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
      points[3 * dimensions - 1] = wrong[k];
      assert_int_equal(measured(info.name, points, 3, dimensions, 0, &made, &error), ASC_INVALID_ARGUMENT);
      assert_non_null(strstr(error.text, "point 2"));
      assert_int_equal(measured(info.name, points, 3, dimensions, 0, &made, NULL), ASC_INVALID_ARGUMENT);
    }
    points[3 * dimensions - 1] = 0.0;
    if (info.most_dimensions < 8)
      assert_int_equal(measured(info.name, points, 3, info.most_dimensions + 1, 0, &made, &error), ASC_UNSUPPORTED);
    if (dimensions > 1)
      assert_int_equal(measured(info.name, points, 3, dimensions - 1, 0, &made, &error), ASC_UNSUPPORTED);
  }
}

static void requests_that_make_no_sense_are_refused(void **state) {
  (void)state;
  const double point[] = {0.5, 0.5};
  asc_measurement made = {.struct_size = sizeof made};
  asc_error error = {{0}};
  asc_discrepancy_desc desc = {sizeof desc, "l2-star", point, 1, 2, 0};
  assert_int_equal(asc_discrepancy(&desc, &made, &error), ASC_OK);
  assert_int_equal(asc_discrepancy(NULL, &made, &error), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_discrepancy(&desc, NULL, &error), ASC_INVALID_ARGUMENT);
  made.struct_size = 1;
  assert_int_equal(asc_discrepancy(&desc, &made, &error), ASC_INVALID_ARGUMENT);
  made.struct_size = sizeof made;
  desc.struct_size = 1;
  assert_int_equal(asc_discrepancy(&desc, &made, &error), ASC_INVALID_ARGUMENT);
  assert_int_equal(measured("l2-stat", point, 1, 2, 0, &made, &error), ASC_UNKNOWN_NAME);
  assert_non_null(strstr(error.text, "l2-star"));
  assert_int_equal(measured("l2-star:draws=3", point, 1, 2, 0, &made, &error), ASC_UNKNOWN_KEY);
  assert_int_equal(measured("edge-mean:draw=3", point, 1, 2, 0, &made, &error), ASC_UNKNOWN_KEY);
  assert_non_null(strstr(error.text, "draws"));
  assert_int_equal(measured("edge-mean:draws=1", point, 1, 2, 0, &made, &error), ASC_INVALID_VALUE);
  assert_int_equal(measured("edge-rms:draws=1", point, 1, 2, 0, &made, &error), ASC_INVALID_VALUE);
  assert_int_equal(measured("edge-max:edges=some", point, 1, 2, 0, &made, &error), ASC_INVALID_VALUE);
  char canonical[512];
  assert_int_equal(asc_measure_canonical("edge-max:edges=chord,draws=9", canonical, sizeof canonical, &error), ASC_OK);
  assert_string_equal(canonical, "edge-max:draws=9,edges=chord");
  assert_int_equal(asc_measure_canonical("edge-max:draws=9", canonical, 5, &error), ASC_INVALID_ARGUMENT);
}

/* More draws than one, and as many as do not fill a block of the hash. */
static void edges_of_every_kind_are_drawn(void **state) {
  (void)state;
  static const char *const kinds[] = {"isotropic", "angle-offset", "two-points", "chord"};
  static const char *const names[] = {"edge-rms", "edge-mean", "edge-max"};
  double points[MOST_POINTS * 2];
  for (size_t kind = 0; kind < 4; kind++)
    for (size_t name = 0; name < 3; name++)
      for (unsigned draws = 2; draws < 40; draws += 7) {
        char spec[128];
        (void)snprintf(spec, sizeof spec, "%s:draws=%u,edges=%s", names[name], draws, kinds[kind]);
        for (size_t index = 0, count = 1; count; index++) {
          count = extreme_set(index, 2, points);
          if (count) check_measurement(spec, points, count, 2);
        }
      }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_measure_says_what_it_is),           cmocka_unit_test(extremes_are_measured),
      cmocka_unit_test(counts_about_powers_of_two_are_measured), cmocka_unit_test(what_is_no_point_set_is_refused),
      cmocka_unit_test(requests_that_make_no_sense_are_refused), cmocka_unit_test(edges_of_every_kind_are_drawn),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The measures `box` and `half-plane`: contracts, extremes, sets whose discrepancy is known. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/discrepancy.h"
#include "halfplane_area.h"

#define LAST (1.0 - 0x1p-53) /* the last double below 1 */
#define MOST_POINTS 1600
#define ERROR 5e-15 /* of half-plane: directions within 2^-50 count as one; box errs by less */

static double points[2 * MOST_POINTS];

static void assert_near(double value, double expected, double error) {
  if (!(fabs(value - expected) <= error)) fail_msg("%.17g is not %.17g", value, expected);
}

static asc_measurement measured(const char *spec, const double *given, size_t count) {
  const asc_discrepancy_desc desc = {sizeof desc, spec, given, count, 2, 0};
  asc_measurement made = {.struct_size = sizeof made};
  asc_error error = {{0}};
  if (asc_discrepancy(&desc, &made, &error)) fail_msg("%s: %s", spec, error.text);
  assert_int_equal(made.certainty, ASC_EXACT);
  assert_true(made.lower == made.value && made.upper == made.value);
  return made;
}

static void assert_value(const char *spec, size_t count, double expected) {
  assert_near(measured(spec, points, count).value, expected, ERROR);
}

static void set_all(size_t count, double x, double y) {
  for (size_t i = 0; i < count; i++) points[2 * i] = x, points[2 * i + 1] = y;
}

/* The box is the point alone; the half-plane cuts off the corner nearest to it, twice its distances from the sides. */
static void one_point_or_many_equal_ones(void **state) {
  (void)state;
  static const struct {
    double x, y, half_plane;
  } cases[] = {{0.5, 0.5, 0.5},       {0.25, 0.125, 0.9375}, {0.75, 0.125, 0.9375}, {0.25, 0.875, 0.9375},
               {0.75, 0.875, 0.9375}, {0.0, 0.0, 1.0},       {1.0, 0.0, 1.0},       {0.0, 1.0, 1.0},
               {1.0, 1.0, 1.0},       {0.5, 0.0, 1.0},       {0.0, 0.3, 1.0},       {1.0, 0.3, 1.0},
               {0.3, 1.0, 1.0},       {LAST, LAST, 1.0},     {LAST, 0.5, 1.0},      {5e-324, 0.5, 1.0}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    for (size_t count = 1; count <= MOST_POINTS; count = count * 7 + 1) {
      set_all(count, cases[i].x, cases[i].y);
      assert_value("half-plane", count, cases[i].half_plane);
      assert_value("box", count, 1.0);
    }
}

/* N even points on a line: a degenerate box holds a level one whole, a half-plane all of it and half of the square. */
static void points_on_a_line(void **state) {
  (void)state;
  for (size_t n = 2; n <= 400; n += 57) {
    for (size_t i = 0; i < n; i++) points[2 * i] = (double)i / (double)(n - 1), points[2 * i + 1] = 0.25;
    assert_value("box", n, 1.0);
    assert_value("half-plane", n, 0.75);
    for (size_t i = 0; i < n; i++) points[2 * i + 1] = points[2 * i];
    assert_value("half-plane", n, 0.5);
    for (size_t i = 0; i < n; i++) points[2 * i + 1] = 1.0; /* on the border */
    assert_value("box", n, 1.0);
    assert_value("half-plane", n, 1.0);
  }
}

/* The corners: two of the four on a side of area 0, none of them in the open square. */
static void points_at_the_corners(void **state) {
  (void)state;
  const double corners[] = {0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0};
  assert_near(measured("half-plane", corners, 4).value, 0.5, ERROR);
  const asc_measurement made = measured("box", corners, 4);
  assert_true(made.value == 1.0);
  assert_int_equal(made.closed, 0);
  const double inside[] = {0.0, 0.0, 1.0, 1.0};
  assert_memory_equal(made.witness, inside, sizeof inside);
}

/* A half-plane whose edge is a row of a centred k x k grid has half of that row too many; the box of all points is k -
 * 1 steps wide. */
static void centred_grids(void **state) {
  (void)state;
  for (size_t k = 1; k <= 40; k++) {
    const double steps = (double)k;
    for (size_t i = 0; i < k * k; i++) {
      points[2 * i] = ((double)(i / k) + 0.5) / steps;
      points[2 * i + 1] = ((double)(i % k) + 0.5) / steps;
    }
    assert_value("half-plane", k * k, 1.0 / (2.0 * steps));
    assert_value("box", k * k, 1.0 - (steps - 1.0) * (steps - 1.0) / steps / steps);
  }
}

static void a_half_planes_witness_is_its_line(void **state) {
  (void)state;
  set_all(1, 0.25, 0.125);
  const asc_measurement made = measured("half-plane", points, 1);
  assert_int_equal(made.witness_count, 3);
  assert_int_equal(made.closed, 1);
  assert_near(made.witness[0] * 0.5 + made.witness[2], 0.0, 1e-16); /* the halved chord's ends */
  assert_near(made.witness[1] * 0.25 + made.witness[2], 0.0, 1e-16);
  assert_true(made.witness[2] > 0.0); /* the origin is in it */
}

static void areas_of_half_planes(void **state) {
  (void)state;
  assert_true(asc_halfplane_area(1.0, 0.0, -0.25) == 0.75);
  assert_true(asc_halfplane_area(-1.0, 0.0, 0.25) == 0.25);
  assert_true(asc_halfplane_area(0.0, 3.0, -1.5) == 0.5);
  assert_true(asc_halfplane_area(1.0, 1.0, -1.0) == 0.5);
  assert_true(asc_halfplane_area(-1.0, -1.0, 0x1p-20) == 0x1p-41);
  assert_true(asc_halfplane_area(1.0, 1e-300, -1.0) == 0.5e-300);
  assert_true(asc_halfplane_area(0.0, 0.0, -1.0) == 0.0);
  assert_true(asc_halfplane_area(0.0, 0.0, 0.0) == 1.0);
  assert_true(asc_halfplane_area(1e308, 1e308, -1e308) == 0.5);
}

static void other_dimensions_are_refused(void **state) {
  (void)state;
  static const char *const specs[] = {"box", "half-plane"};
  for (size_t i = 0; i < 2; i++)
    for (uint32_t dimensions = 1; dimensions <= 4; dimensions++) {
      const asc_discrepancy_desc desc = {sizeof desc, specs[i], points, 1, dimensions, 0};
      asc_measurement made = {.struct_size = sizeof made};
      asc_error error = {{0}};
      assert_int_equal(asc_discrepancy(&desc, &made, &error), dimensions == 2 ? ASC_OK : ASC_UNSUPPORTED);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_point_or_many_equal_ones),
      cmocka_unit_test(points_on_a_line),
      cmocka_unit_test(points_at_the_corners),
      cmocka_unit_test(centred_grids),
      cmocka_unit_test(a_half_planes_witness_is_its_line),
      cmocka_unit_test(areas_of_half_planes),
      cmocka_unit_test(other_dimensions_are_refused),
  };
  return cmocka_run_group_tests_name("discrepancy: box, half-plane", tests, NULL, NULL);
}

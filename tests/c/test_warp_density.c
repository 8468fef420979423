/* Densities that are constant in each cell of a grid: round trips, empty cells, any weights. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "warp_tools.h"

static asc_density *made(const double *weights, size_t columns, size_t rows) {
  const asc_density_desc desc = {sizeof desc, weights, columns, rows};
  asc_density *density = NULL;
  asc_error error = {{0}};
  if (asc_density_create(&desc, &density, &error)) fail_msg("%s", error.text);
  return density;
}

/* Returns the density at the point of u, after the round trip, the cell and the interval were looked at. */
static double visit(const asc_density *density, const double *weights, size_t columns, size_t rows, const double *u) {
  double point[2] = {0, 0}, back[2], pdf;
  assert_int_equal(asc_density_sample(density, u, 1, point), ASC_OK);
  assert_int_equal(asc_density_inverse(density, point, 1, back), ASC_OK);
  assert_int_equal(asc_density_pdf(density, point, 1, &pdf), ASC_OK);
  assert_true(pdf > 0.0);
  const uint32_t dimensions = asc_density_dimensions(density);
  for (uint32_t d = 0; d < dimensions; d++) {
    assert_true(point[d] >= 0.0 && point[d] < 1.0);
    /* A row's own density is at most `columns`, the marginal one at most `rows`. */
    const double conditioning = dimensions == 1 ? fmax(pdf, 1.0) : (double)(d == 0 ? columns : rows);
    if (fabs(back[d] - u[d]) > ASC_WARP_ROUND_TRIP * conditioning)
      fail_msg("u[%u] = %.17g comes back as %.17g", d, u[d], back[d]);
  }
  const size_t column = (size_t)(point[0] * (double)columns), row = (size_t)(point[1] * (double)(rows ? rows : 1));
  assert_true(weights[row * columns + column] > 0.0);
  return pdf;
}

static const double extremes[] = {0.0, 5e-324, 0x1p-53, 0x1p-24, 0.5, 1.0 - 0x1p-24, 1.0 - 0x1p-53, 1.0};
#define EXTREMES (sizeof extremes / sizeof *extremes)

/* Also where the cells have edges that are no binary fractions, and both ends are empty. */
static void empty_cells_are_never_met(void **state) {
  (void)state;
  for (size_t n = 3; n < 130; n++) {
    double weights[130] = {0};
    for (size_t i = 1; i + 1 < n; i++) weights[i] = i % 3 == 2 ? 0.0 : 0.1 + drawn((uint32_t)i, (uint32_t)n);
    asc_density *line = made(weights, n, 0);
    double whole = 0.0, sum = 0.0;
    for (size_t i = 0; i < n; i++) whole += weights[i];
    for (size_t i = 0; i < n; i++) { /* u at the edge of each cell, and one step to either side */
      for (int step = -1; step <= 1; step++) {
        double u = sum / whole;
        if (step) u = nextafter(u, step * 2.0);
        (void)visit(line, weights, n, 0, (double[]){fmin(fmax(u, 0.0), 1.0)});
      }
      sum += weights[i];
    }
    for (size_t i = 0; i < EXTREMES; i++) (void)visit(line, weights, n, 0, &extremes[i]);
    asc_density_destroy(line);
  }
  double grid[7 * 5] = {0};
  for (uint32_t i = 0; i < 7 * 5; i++) grid[i] = i / 5 % 3 == 0 || i % 5 == 0 || i % 4 == 0 ? 0.0 : drawn(i, 10);
  asc_density *plane = made(grid, 5, 7);
  for (size_t i = 0; i < EXTREMES; i++)
    for (size_t j = 0; j < EXTREMES; j++) (void)visit(plane, grid, 5, 7, (double[]){extremes[i], extremes[j]});
  for (uint32_t i = 0; i < 100000; i++) (void)visit(plane, grid, 5, 7, (double[]){drawn(i, 11), drawn(i, 12)});
  asc_density_destroy(plane);
}

/* Chi-squared of 33 degrees of freedom, as 34 cells are not empty: above 86.82 once in a million. */
static void cells_are_met_by_their_weight(void **state) {
  (void)state;
  double weights[40], whole = 0.0;
  for (uint32_t i = 0; i < 40; i++) whole += weights[i] = i % 7 == 3 ? 0.0 : 0.05 + drawn(i, 13);
  for (int plane = 0; plane < 2; plane++) {
    asc_density *density = plane ? made(weights, 8, 5) : made(weights, 40, 0);
    double counts[40] = {0}, statistic = 0.0;
    const uint32_t draws = 1 << 18;
    for (uint32_t i = 0; i < draws; i++) {
      double point[2] = {0, 0}, pdf;
      assert_int_equal(asc_density_sample(density, (double[]){drawn(i, 14), drawn(i, 15)}, 1, point), ASC_OK);
      const size_t cell = plane ? (size_t)(point[1] * 5) * 8 + (size_t)(point[0] * 8) : (size_t)(point[0] * 40);
      assert_int_equal(asc_density_pdf(density, point, 1, &pdf), ASC_OK);
      assert_true(fabs(pdf / (weights[cell] / whole * 40.0) - 1.0) < 1e-14); /* 40 sums, three quotients */
      counts[cell] += 1.0;
    }
    for (size_t i = 0; i < 40; i++) {
      const double expected = weights[i] / whole * draws;
      if (expected > 0.0)
        statistic += (counts[i] - expected) * (counts[i] - expected) / expected;
      else
        assert_true(counts[i] == 0.0);
    }
    if (statistic > 86.9) fail_msg("chi-squared %g", statistic);
    asc_density_destroy(density);
  }
}

/* Slopes of the map are 1/pdf, whichever cell: differences within a cell are exact but for rounding. */
static void slopes_are_the_inverse_of_the_pdf(void **state) {
  (void)state;
  const double weights[] = {3, 0, 1e-3, 2, 0.5, 0, 7, 1, 1e-2, 4, 1, 2};
  asc_density *plane = made(weights, 4, 3), *line = made(weights, 12, 0);
  for (uint32_t i = 0; i < 20000; i++) {
    const double h = 1e-7, u[2] = {0.01 + 0.98 * drawn(i, 16), 0.01 + 0.98 * drawn(i, 17)};
    double low[2], high[2], pdf, other;
    for (int two = 0; two < 2; two++) {
      const asc_density *density = two ? plane : line;
      const double ends[4] = {u[0] - h, u[1] - h, u[0] + h, u[1] + h};
      assert_int_equal(asc_density_sample(density, ends, 1, low), ASC_OK);
      assert_int_equal(asc_density_sample(density, two ? ends + 2 : ends + 2, 1, high), ASC_OK);
      assert_int_equal(asc_density_pdf(density, low, 1, &pdf), ASC_OK);
      assert_int_equal(asc_density_pdf(density, high, 1, &other), ASC_OK);
      if (pdf != other) continue; /* a border between */
      const double area = (high[0] - low[0]) / (2.0 * h) * (two ? (high[1] - low[1]) / (2.0 * h) : 1.0);
      assert_true(fabs(area * pdf - 1.0) < 1e-6 * fmax(1.0, pdf)); /* 1e-16/h, more where the cell is narrow in u */
    }
  }
  asc_density_destroy(plane);
  asc_density_destroy(line);
}

/* Weights of 60 decades, among them those that sums would overflow for or lose. */
static void weights_may_differ_by_any_factor(void **state) {
  (void)state;
  double weights[61], pdf;
  for (int i = 0; i <= 60; i++) weights[i] = pow(10.0, i % 2 ? 30 - i : i - 30);
  asc_density *density = made(weights, 61, 0);
  for (size_t i = 0; i < EXTREMES; i++) (void)visit(density, weights, 61, 0, &extremes[i]);
  for (uint32_t i = 0; i < 10000; i++) (void)visit(density, weights, 61, 0, (double[]){drawn(i, 18)});
  long double whole = 0.0L;
  for (int i = 0; i <= 60; i++) whole += weights[i];
  for (int i = 0; i <= 60; i++) { /* small ones keep all their digits */
    const double middle = (i + 0.5) / 61.0, expected = (double)(weights[i] * 61.0L / whole);
    assert_int_equal(asc_density_pdf(density, &middle, 1, &pdf), ASC_OK);
    assert_true(fabs(pdf / expected - 1.0) < 4.0 * DBL_EPSILON); /* two quotients, a product */
  }
  asc_density_destroy(density);
  const double huge[4] = {DBL_MAX, DBL_MAX, 0.0, DBL_MAX}, tiny[4] = {5e-324, 0.0, 5e-324, 5e-324};
  for (int which = 0; which < 4; which++) {
    const double *cells = which % 2 ? tiny : huge, u[2] = {0.75, 0.75};
    const size_t rows = which / 2 ? 2 : 0;
    density = made(cells, rows ? 2 : 4, rows);
    assert_true(fabs(visit(density, cells, rows ? 2 : 4, rows, u) - 4.0 / 3.0) < 4.0 * DBL_EPSILON);
    asc_density_destroy(density);
  }
}

/* A million cells: round trips, none empty met, the share of each exact within a step of the sum. */
static void a_million_cells(void **state) {
  (void)state;
  const size_t n = 1000000;
  double *weights = malloc(n * sizeof *weights);
  assert_non_null(weights);
  for (size_t i = 0; i < n; i++) weights[i] = i % 5 == 0 ? 0.0 : drawn((uint32_t)i, 19);
  for (size_t rows = 0; rows <= 1000; rows += 1000) {
    asc_density *density = made(weights, rows ? n / rows : n, rows);
    for (uint32_t i = 0; i < 20000; i++)
      (void)visit(density, weights, rows ? n / rows : n, rows, (double[]){drawn(i, 20), drawn(i, 21)});
    for (size_t i = 0; i < EXTREMES; i++)
      (void)visit(density, weights, rows ? n / rows : n, rows, (double[]){extremes[i], extremes[i]});
    asc_density_destroy(density);
  }
  free(weights);
}

static void one_cell_is_the_identity(void **state) {
  (void)state;
  const double weight = 0.3;
  asc_density *line = made(&weight, 1, 0), *plane = made(&weight, 1, 1);
  assert_int_equal(asc_density_dimensions(line), 1);
  assert_int_equal(asc_density_dimensions(plane), 2);
  assert_int_equal(asc_density_dimensions(NULL), 0);
  for (uint32_t i = 0; i < 1000; i++) {
    const double u[2] = {drawn(i, 22), drawn(i, 23)};
    double point[2], pdf;
    assert_int_equal(asc_density_sample(plane, u, 1, point), ASC_OK);
    assert_true(point[0] == u[0] && point[1] == u[1]);
    assert_int_equal(asc_density_sample(line, u, 2, point), ASC_OK); /* two points */
    assert_true(point[0] == u[0] && point[1] == u[1]);
    assert_int_equal(asc_density_pdf(plane, point, 1, &pdf), ASC_OK);
    assert_true(pdf == 1.0);
  }
  asc_density_destroy(line);
  asc_density_destroy(plane);
}

static void what_is_no_density_is_refused(void **state) {
  (void)state;
  const double bad[][4] = {{0, 0, 0, 0}, {1, NAN, 1, 1}, {1, 1, -1e-300, 1}, {1, 1, 1, INFINITY}, {-0.0, 0, 0, 0}};
  const char *const words[] = {"all weights are zero", "nan of row 0, column 1", "row 1, column 0",
                               "inf of row 1, column 1", "all weights are zero"};
  for (size_t i = 0; i < 5; i++) {
    asc_error error = {{0}};
    asc_density *density = (asc_density *)&error;
    const asc_density_desc desc = {sizeof desc, bad[i], 2, 2};
    assert_int_equal(asc_density_create(&desc, &density, &error), ASC_INVALID_VALUE);
    assert_null(density);
    if (!strstr(error.text, words[i])) fail_msg("%s", error.text);
    assert_int_equal(asc_density_create(&desc, &density, NULL), ASC_INVALID_VALUE);
  }
  const double good[4] = {1, 2, 0, 4};
  const asc_density_desc descs[] = {{0, good, 2, 2},
                                    {sizeof *descs, NULL, 2, 2},
                                    {sizeof *descs, good, 0, 2},
                                    {sizeof *descs, good, SIZE_MAX, 0},
                                    {sizeof *descs, good, 2, SIZE_MAX}};
  asc_density *density;
  for (size_t i = 0; i < 5; i++) assert_int_equal(asc_density_create(&descs[i], &density, NULL), ASC_INVALID_ARGUMENT);
  density = made(good, 4, 0);
  double out[2];
  const double outside[] = {-0x1p-60, 1.0 + DBL_EPSILON, NAN};
  for (size_t i = 0; i < 3; i++) {
    assert_int_equal(asc_density_sample(density, &outside[i], 1, out), ASC_INVALID_ARGUMENT);
    assert_int_equal(asc_density_inverse(density, &outside[i], 1, out), ASC_INVALID_ARGUMENT);
    assert_int_equal(asc_density_pdf(density, &outside[i], 1, out), i == 2 ? ASC_INVALID_ARGUMENT : ASC_OK);
    if (i < 2) assert_true(out[0] == 0.0);
  }
  const double empty = 0.6, end = 1.0;
  assert_int_equal(asc_density_inverse(density, &empty, 1, out), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_density_inverse(density, &end, 1, out), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_density_sample(NULL, &empty, 1, out), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_density_sample(density, NULL, 0, NULL), ASC_OK);
  asc_density_destroy(density);
  asc_density_destroy(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(empty_cells_are_never_met),
      cmocka_unit_test(cells_are_met_by_their_weight),
      cmocka_unit_test(slopes_are_the_inverse_of_the_pdf),
      cmocka_unit_test(weights_may_differ_by_any_factor),
      cmocka_unit_test(a_million_cells),
      cmocka_unit_test(one_cell_is_the_identity),
      cmocka_unit_test(what_is_no_density_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

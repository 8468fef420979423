/* Discrepancies where little is left of their terms: even points, many dimensions, both sides of the torus. What is
 * expected was worked out in whole numbers of the same doubles, and mpmath; the tolerance is of twelve digits. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/discrepancy.h"

#define TWELVE_DIGITS 1e-12

static asc_status measure(const char *spec, const double *points, size_t count, uint32_t dimensions, double *value,
                          asc_error *error) {
  const asc_discrepancy_desc desc = {sizeof desc, spec, points, count, dimensions, 0};
  asc_measurement made = {.struct_size = sizeof made};
  const asc_status status = asc_discrepancy(&desc, &made, error);
  *value = made.value;
  return status;
}

static void assert_value(const char *spec, const double *points, size_t count, uint32_t dimensions, double expected) {
  double value;
  asc_error error = {{0}};
  if (measure(spec, points, count, dimensions, &value, &error)) fail_msg("%s: %s", spec, error.text);
  if (!(fabs(value - expected) <= TWELVE_DIGITS * expected)) fail_msg("%s: %.17g is not %.17g", spec, value, expected);
}

/* Fibonacci's lattice has few differences, so that the same roundings come again and again; the square of its
 * discrepancies is some 1e-7 of their terms. */
static void even_points(void **state) {
  (void)state;
  enum { N = 1597, STEP = 987 };
  static double points[2 * N];
  for (size_t i = 0; i < N; i++) {
    points[2 * i] = ((double)i + 0.5) / N;
    points[2 * i + 1] = ((double)(i * STEP % N) + 0.5) / N;
  }
  assert_value("l2-star", points, N, 2, 0.000435603949133882802636925);
  assert_value("l2-extreme", points, N, 2, 0.000230817290832094956707005);
  assert_value("l2-centered", points, N, 2, 0.000488633341514982151048689);
  assert_value("l2-wrap", points, N, 2, 0.000604638293676716820031234);
  assert_value("l2-mixture", points, N, 2, 0.000583685215077531135827223);
  assert_value("l2-periodic", points, N, 2, 0.000484653974361760894281164);
  assert_value("edge-rms", points, N, 2, 0.000977469049359911128596878);
}

/* One point in the middle: each factor is 1/3 - 2 * 3/8 + 1/2 and so on, of which the powers are known. */
static void many_dimensions(void **state) {
  (void)state;
  enum { MOST = 3000 };
  static double points[MOST];
  for (size_t i = 0; i < MOST; i++) points[i] = 0.5;
  /* The largest term, 1/2^d, is all that a double sees at 300; the square is below the least double. */
  assert_value("l2-star", points, 1, 300, 0x1p-150);
  assert_value("l2-extreme", points, 1, 500, 0x1p-500);
  assert_value("l2-periodic", points, 1, 900, 0x1p-450);
  double value;
  const char *const beyond[] = {"l2-star", "l2-extreme", "l2-periodic", "l2-wrap", "l2-mixture"};
  for (size_t i = 0; i < sizeof beyond / sizeof *beyond; i++) {
    asc_error error = {{0}};
    assert_int_equal(measure(beyond[i], points, 1, MOST, &value, &error), ASC_NUMERIC);
    assert_non_null(strstr(error.text, "in 3000 dimensions the discrepancy, or its terms, are no doubles"));
  }
}

/* Their difference, near 1, has no digits for how far the first is from the border. */
static void both_sides_of_the_torus(void **state) {
  (void)state;
  const double last = 1.0 - 0x1p-53;
  for (double at = 0x1p-40; at > 0x1p-60; at *= 0.3) {
    const double points[] = {at, 0.5, last, 0.5, 0.25, 0.125, 0.625, 0.875};
    assert_value("min-distance", points, 4, 2, 0x1p-53 + at);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(even_points),
      cmocka_unit_test(many_dimensions),
      cmocka_unit_test(both_sides_of_the_torus),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

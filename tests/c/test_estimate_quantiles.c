/* Quantiles: closed forms, symmetry, order, what is refused. tests/python has them against SciPy and mpmath. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "aliascope/estimate.h"

#define CLOSE 1e-12 /* what the header promises, relative */
#define PI 3.141592653589793238462643383279502884L

static const double tails[] = {1e-300, 1e-100, 1e-20, 1e-12, 1e-6, 0.001, 0.05, 0.1, 0.1001, 0.25, 0.4, 0.4999999};
#define TAILS (sizeof tails / sizeof *tails)
static const double degrees[] = {1, 1.5, 2, 3, 10, 100, 1e3, 9999, 1e4, 1e6, 1e12};
#define DEGREES (sizeof degrees / sizeof *degrees)

static double student(double p, double of) {
  double x = NAN;
  assert_int_equal(asc_student_t_quantile(p, of, &x), ASC_OK);
  return x;
}

static double chi_squared(double p, double of) {
  double x = NAN;
  assert_int_equal(asc_chi_squared_quantile(p, of, &x), ASC_OK);
  return x;
}

static double upper(double q, double of) {
  double x = NAN;
  assert_int_equal(asc_chi_squared_upper_quantile(q, of, &x), ASC_OK);
  return x;
}

static void assert_near(double found, long double expected) {
  const long double off = fabsl((long double)found / expected - 1.0L);
  if (!(off < (long double)CLOSE)) fail_msg("%.17g, not %.17Lg", found, expected);
}

/* Student's with 1 degree is Cauchy's law, with 2 it is (2p - 1)/sqrt(2p(1 - p)); chi-squared with 2 is exponential,
 * with 1 the square of the normal law. */
static void closed_forms(void **state) {
  (void)state;
  for (size_t i = 0; i < TAILS; i++) {
    const long double p = tails[i];
    assert_near(student(tails[i], 1), -1.0L / tanl(PI * p));
    assert_near(student(tails[i], 2), -(1.0L - 2.0L * p) / sqrtl(2.0L * p * (1.0L - p)));
    assert_near(chi_squared(tails[i], 2), -2.0L * log1pl(-p));
    assert_near(upper(tails[i], 2), -2.0L * logl(p));
    double normal = NAN;
    assert_int_equal(asc_normal_quantile(0.5 * tails[i], &normal), ASC_OK);
    assert_near(upper(tails[i], 1), (long double)normal * normal);
  }
  double normal = NAN;
  assert_int_equal(asc_normal_quantile(0.975, &normal), ASC_OK);
  assert_near(normal, 1.959963984540054235524594430520551527956L);
}

static void halves_mirror_each_other(void **state) {
  (void)state;
  for (size_t i = 0; i < TAILS; i++) {
    const double p = tails[i], rest = 1.0 - p;
    double low = NAN, high = NAN;
    if (1.0 - rest != p) continue; /* 1 - p is rounded: not the same point */
    assert_int_equal(asc_normal_quantile(p, &low), ASC_OK);
    assert_int_equal(asc_normal_quantile(rest, &high), ASC_OK);
    assert_true(low == -high);
    for (size_t d = 0; d < DEGREES; d++) {
      assert_true(student(p, degrees[d]) == -student(rest, degrees[d]));
      assert_true(chi_squared(p, degrees[d]) == upper(rest, degrees[d]));
      assert_true(upper(p, degrees[d]) == chi_squared(rest, degrees[d]));
    }
  }
  double zero = NAN;
  assert_int_equal(asc_normal_quantile(0.5, &zero), ASC_OK);
  assert_true(zero == 0.0 && student(0.5, 7) == 0.0);
}

/* Also over the seams: of the middle and the tail, and of few and many degrees. */
static void they_grow_with_p_and_degrees(void **state) {
  (void)state;
  for (size_t d = 0; d < DEGREES; d++)
    for (double p = 1e-3; p < 0.998; p += 1e-3) {
      assert_true(student(p, degrees[d]) < student(p + 1e-3, degrees[d]));
      assert_true(chi_squared(p, degrees[d]) < chi_squared(p + 1e-3, degrees[d]));
    }
  /* Near 10^4 degrees t changes by (z^3 + z)/(4 * 10^8) a degree, which is 3e-6 of it at most, chi-squared by about 1.
   */
  for (size_t i = 0; i < TAILS; i++) {
    const double p = tails[i], t = student(p, 9999.9999999), more = student(p, 1e4);
    assert_true(fabs(more / t - 1.0) < 1e-12);
    assert_true(fabs(chi_squared(p, 9999.9999999) / chi_squared(p, 1e4) - 1.0) < 3e-10);
  }
  /* The law of many degrees is the normal one, but for (z^2 + 1)/(4 * 10^12). */
  for (size_t i = 0; i < TAILS; i++) {
    double normal = NAN;
    assert_int_equal(asc_normal_quantile(tails[i], &normal), ASC_OK);
    assert_true(fabs(student(tails[i], 1e12) / normal - 1.0) < 1e-9);
  }
}

static void what_is_refused(void **state) {
  (void)state;
  const double p[] = {0.0, 1.0, -0.5, 1.5, NAN}, bad[] = {0.0, 0.99, -1.0, 2e12, INFINITY, NAN};
  double x;
  for (int i = 0; i < 5; i++) {
    assert_int_equal(asc_normal_quantile(p[i], &x), ASC_INVALID_ARGUMENT);
    assert_int_equal(asc_student_t_quantile(p[i], 3, &x), ASC_INVALID_ARGUMENT);
    assert_int_equal(asc_chi_squared_quantile(p[i], 3, &x), ASC_INVALID_ARGUMENT);
    assert_int_equal(asc_chi_squared_upper_quantile(p[i], 3, &x), ASC_INVALID_ARGUMENT);
  }
  for (int i = 0; i < 6; i++) {
    assert_int_equal(asc_student_t_quantile(0.3, bad[i], &x), ASC_INVALID_ARGUMENT);
    assert_int_equal(asc_chi_squared_quantile(0.3, bad[i], &x), ASC_INVALID_ARGUMENT);
  }
  assert_int_equal(asc_normal_quantile(0.3, NULL), ASC_INVALID_ARGUMENT);
  /* Beyond the largest double, and below the least. */
  assert_int_equal(asc_student_t_quantile(5e-324, 1, &x), ASC_NUMERIC);
  assert_true(chi_squared(1e-300, 1) == 0.0);
}

/* Of so many degrees the search comes by the place at which the law is as the normal one, where terms are 0/0. About
 * the median Wilson and Hilferty 1931 have 12 digits: they leave terms of 1/degrees. */
static void the_median_of_many_degrees(void **state) {
  (void)state;
  const long double many = 142 * 0x1p28L, part = 1.0L - 2.0L / (9.0L * many);
  assert_near(chi_squared(0.5, (double)many), many * part * part * part);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(closed_forms),
      cmocka_unit_test(halves_mirror_each_other),
      cmocka_unit_test(they_grow_with_p_and_degrees),
      cmocka_unit_test(the_median_of_many_degrees),
      cmocka_unit_test(what_is_refused),
  };
  return cmocka_run_group_tests_name("estimate_quantiles", tests, NULL, NULL);
}

/* Means and variances: their digits, their laws (the lecture's "Probability Theory"), strata. */
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

#include "aliascope/estimate.h"
#include "warp_tools.h"

static asc_moments_summary summary_of(const asc_moments *of) {
  asc_moments_summary made;
  assert_int_equal(asc_moments_summarise(of, &made), ASC_OK);
  return made;
}

static asc_moments moments_of(const double *values, size_t n) {
  asc_moments made = {0};
  assert_int_equal(asc_moments_add(&made, values, n), ASC_OK);
  return made;
}

#define MANY 10000000u
#define LARGE 100000000.0
#define STEPS 0x1p20 /* u is a multiple of 2^-20, so that the sums of squares are whole numbers below 2^64 */

/* 10^7 values 1e8 + u, against sums of whole numbers, which are exact; what follows them is in long double. */
static void ten_digits_of_ten_million_values(void **state) {
  (void)state;
  enum { PART = 10000 };
  static double part[PART];
  asc_moments whole = {0}, merged = {0};
  uint64_t sum = 0, squares = 0;
  for (uint32_t first = 0; first < MANY; first += PART) {
    for (uint32_t i = 0; i < PART; i++) {
      const uint64_t steps = (uint64_t)(drawn(first + i, 1) * STEPS);
      part[i] = LARGE + (double)steps / STEPS;
      sum += steps;
      squares += steps * steps;
    }
    assert_int_equal(asc_moments_add(&whole, part, PART), ASC_OK);
    const asc_moments more = moments_of(part, PART);
    assert_int_equal(asc_moments_merge(&merged, &more), ASC_OK);
  }
  const long double mean = (long double)LARGE + (long double)sum / MANY / (long double)STEPS;
  const long double apart = (long double)squares - (long double)sum / MANY * (long double)sum;
  const long double variance = apart / (MANY - 1.0L) / (long double)(STEPS * STEPS);
  const asc_moments *both[] = {&whole, &merged};
  for (int i = 0; i < 2; i++) {
    const asc_moments_summary found = summary_of(both[i]);
    assert_int_equal(found.count, MANY);
    /* Ten digits are asked for; what rounding leaves of 10^7 additions is 3 * 10^-13 as a random walk. */
    assert_true(fabsl(found.mean / mean - 1.0L) < 1e-15L);
    assert_true(fabsl(found.variance / variance - 1.0L) < 1e-11L);
  }
}

static void few_values_and_refused_ones(void **state) {
  (void)state;
  asc_moments moments = {0};
  asc_moments_summary found = summary_of(&moments);
  assert_true(found.count == 0 && isnan(found.mean) && isnan(found.variance) && isnan(found.standard_error));
  double lower, upper;
  assert_int_equal(asc_moments_add(&moments, (double[]){3.0}, 1), ASC_OK);
  found = summary_of(&moments);
  assert_true(found.count == 1 && found.mean == 3.0 && isnan(found.variance) && isnan(found.standard_error));
  assert_int_equal(asc_moments_interval(&moments, 0.95, &lower, &upper), ASC_INVALID_ARGUMENT);
  const asc_moments before = moments;
  const double bad[] = {NAN, INFINITY, -INFINITY, DBL_MAX}; /* the last one's square is too large */
  for (int i = 0; i < 4; i++) {
    assert_int_equal(asc_moments_add(&moments, (double[]){5.0, bad[i]}, 2), ASC_NUMERIC);
    assert_memory_equal(&moments, &before, sizeof moments);
  }
  asc_moments none = {0};
  assert_int_equal(asc_moments_add(&none, (double[]){INFINITY}, 1), ASC_NUMERIC);
  assert_int_equal(none.count, 0);
  assert_int_equal(asc_moments_add(&moments, (double[]){5.0}, 1), ASC_OK);
  found = summary_of(&moments);
  assert_true(found.mean == 4.0 && found.variance == 2.0 && found.standard_error == 1.0);
  /* One degree of freedom: t of 3/4 is tan(pi/4) = 1. */
  assert_int_equal(asc_moments_interval(&moments, 0.5, &lower, &upper), ASC_OK);
  assert_true(fabs(lower - 3.0) < 1e-14 && fabs(upper - 5.0) < 1e-14);
  assert_int_equal(asc_moments_interval(&moments, 1.0, &lower, &upper), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_moments_interval(&moments, 0.0, &lower, &upper), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_moments_add(NULL, bad, 1), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_moments_add(&moments, NULL, 1), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_moments_add(&moments, NULL, 0), ASC_OK);
}

static void parts_and_merges(void **state) {
  (void)state;
  double values[1000];
  for (uint32_t i = 0; i < 1000; i++) values[i] = 1e6 * (drawn(i, 2) - 0.3);
  const asc_moments whole = moments_of(values, 1000);
  for (size_t at = 0; at <= 1000; at += 125) {
    asc_moments parts = moments_of(values, at);
    assert_int_equal(asc_moments_add(&parts, values + at, 1000 - at), ASC_OK);
    assert_memory_equal(&parts, &whole, sizeof whole); /* the same bits */
    asc_moments merged = moments_of(values, at);
    const asc_moments rest = moments_of(values + at, 1000 - at);
    assert_int_equal(asc_moments_merge(&merged, &rest), ASC_OK);
    const asc_moments_summary a = summary_of(&merged), b = summary_of(&whole);
    assert_int_equal(a.count, 1000);
    assert_true(fabs(a.mean - b.mean) < 1e6 * 1000 * DBL_EPSILON); /* 1000 additions of up to 1e6 */
    assert_true(fabs(a.variance / b.variance - 1.0) < 1000 * DBL_EPSILON);
  }
  asc_moments far = moments_of((double[]){1e200}, 1);
  const asc_moments near = moments_of((double[]){-1e200}, 1), kept = far;
  assert_int_equal(asc_moments_merge(&far, &near), ASC_NUMERIC);
  assert_memory_equal(&far, &kept, sizeof far);
}

/* E[aX + bY] = aE[X] + bE[Y], of samples as of expected values; V[aY] = a^2 V[Y]; V[X + Y] = V[X] + V[Y] where X and Y
 * are independent, and V[X + X] = 4 V[X] where they are not. */
static void the_laws_of_expectation_and_variance(void **state) {
  (void)state;
  enum { N = 1000000 };
  double *x = malloc(N * sizeof *x), *y = malloc(N * sizeof *y), *made = malloc(N * sizeof *made);
  for (uint32_t i = 0; i < N; i++) {
    x[i] = drawn(i, 3);
    y[i] = drawn(i, 4) * drawn(i, 5);
  }
  const asc_moments mx = moments_of(x, N), my = moments_of(y, N);
  const asc_moments_summary of_x = summary_of(&mx), of_y = summary_of(&my);
  /* E[U] = 1/2, V[U] = 1/12; E[UU'] = 1/4, V[UU'] = 1/9 - 1/16. Five standard errors: once in two million. */
  assert_true(fabs(of_x.mean - 0.5) < 5.0 * of_x.standard_error);
  assert_true(fabs(of_y.mean - 0.25) < 5.0 * of_y.standard_error);
  const double of_variance = 5.0 / sqrt((double)N);
  assert_true(fabs(of_x.variance * 12.0 - 1.0) < of_variance); /* (kurtosis - 1)^(1/2) = 0.9 times that, times five */
  assert_true(fabs(of_y.variance / (1.0 / 9 - 1.0 / 16) - 1.0) < 2.0 * of_variance);

  for (size_t i = 0; i < N; i++) made[i] = 4.0 * y[i];
  const asc_moments scaled = moments_of(made, N);
  assert_true(summary_of(&scaled).variance == 16.0 * of_y.variance); /* a power of two does not round */
  assert_true(summary_of(&scaled).mean == 4.0 * of_y.mean);

  for (size_t i = 0; i < N; i++) made[i] = 3.0 * x[i] - 2.0 * y[i];
  const asc_moments combined = moments_of(made, N);
  const asc_moments_summary sum = summary_of(&combined);
  assert_true(fabs(sum.mean - (3.0 * of_x.mean - 2.0 * of_y.mean)) < 1e-12); /* 10^6 roundings of 1e-16 as a walk */
  /* The sample covariance is within 5/sqrt(N) of none, in units of both deviations. */
  const double expected = 9.0 * of_x.variance + 4.0 * of_y.variance;
  assert_true(fabs(sum.variance - expected) < 12.0 * sqrt(of_x.variance * of_y.variance) * of_variance);

  for (size_t i = 0; i < N; i++) made[i] = x[i] + x[i];
  const asc_moments twice = moments_of(made, N);
  assert_true(summary_of(&twice).variance == 4.0 * of_x.variance);
  free(x);
  free(y);
  free(made);
}

static void strata_by_hand(void **state) {
  (void)state;
  /* Means 2 and 10, variances 2 and 8, sizes 1/4 and 3/4: V = 1/16 * 2/2 + 9/16 * 8/2. */
  const double low[] = {1.0, 3.0}, high[] = {8.0, 12.0};
  asc_stratum strata[] = {{1.0, moments_of(low, 2)}, {3.0, moments_of(high, 2)}};
  asc_stratified found;
  assert_int_equal(asc_stratify(strata, 2, &found), ASC_OK);
  assert_true(found.mean == 8.0);
  assert_true(fabs(found.standard_error - sqrt(1.0 / 16 + 9.0 / 4)) < 1e-15);
  const double spread = 1.0 / 256 + 81.0 / 16;
  assert_true(fabs(found.degrees - (37.0 / 16) * (37.0 / 16) / spread) < 1e-14);

  /* Shares in proportion to the values, n_j = 2 of N = 4: 1/N^2 sum of n_j V_j = (2 * 2 + 2 * 8)/16. */
  strata[1].size = 1.0;
  assert_int_equal(asc_stratify(strata, 2, &found), ASC_OK);
  assert_true(found.mean == 6.0 && fabs(found.standard_error - sqrt(1.25)) < 1e-15);

  /* One value each: pairs differ by 1 and 2; of five the last three are one group, whose mean is 3. */
  asc_stratum lone[5];
  const double values[] = {0.0, 1.0, 1.0, 3.0, 5.0};
  for (int i = 0; i < 5; i++) lone[i] = (asc_stratum){2.0, moments_of(&values[i], 1)};
  assert_int_equal(asc_stratify(lone, 4, &found), ASC_OK);
  assert_true(found.mean == 1.25 && fabs(found.standard_error - sqrt(5.0 / 16)) < 1e-15);
  assert_int_equal(asc_stratify(lone, 5, &found), ASC_OK);
  assert_true(fabs(found.mean - 2.0) < 1e-15);
  assert_true(fabs(found.standard_error - sqrt((1.0 + 1.5 * 8.0) / 25)) < 1e-15);
  /* Two have variances, of two degrees of freedom each here; a third shows none. */
  lone[0].moments = lone[1].moments = strata[0].moments;
  assert_int_equal(asc_stratify(lone, 3, &found), ASC_OK);
  assert_true(isfinite(found.mean) && isnan(found.standard_error) && isnan(found.degrees));
}

/* One value in each: what is squared are differences, which far from 0 are as exact; and degrees of freedom are the
 * same at every scale, the squares of variances being no doubles at some. */
static void strata_far_from_0_and_at_every_scale(void **state) {
  (void)state;
  asc_stratified near, far;
  for (double away = 1.0; away < 1e15; away *= 1000.0) {
    asc_stratum lone[5];
    const double values[] = {0.0, 0.5, 1.25, -1.0, 2.0};
    for (int step = 0; step < 2; step++) {
      for (int i = 0; i < 5; i++) {
        const double value = values[i] + step * away;
        lone[i] = (asc_stratum){0.1, moments_of(&value, 1)};
      }
      assert_int_equal(asc_stratify(lone, 5, step ? &far : &near), ASC_OK);
    }
    assert_true(fabs(far.standard_error - near.standard_error) <= 1e-15);
    assert_true(fabs(far.degrees - near.degrees) <= 1e-15);
  }
  for (double scale = 1e-150; scale < 1e151; scale *= 1e50) {
    const double few[] = {0.0, scale, 2.0 * scale}, more[] = {0.0, scale, scale, 0.0};
    const asc_stratum strata[] = {{1.0, moments_of(few, 3)}, {1.0, moments_of(more, 4)}};
    assert_int_equal(asc_stratify(strata, 2, &far), ASC_OK);
    /* Variances of the means 1/3 and 1/12, with 2 and 3 degrees. */
    assert_true(fabs(far.degrees - 25.0 / 144 / (1.0 / 18 + 1.0 / 432)) < 1e-14);
    assert_true(fabs(far.standard_error / scale - sqrt(5.0 / 48)) < 1e-15);
  }
}

static void strata_that_are_refused(void **state) {
  (void)state;
  const double value = 1.0;
  asc_stratum strata[] = {{1.0, moments_of(&value, 1)}, {1.0, {0}}};
  asc_stratified found;
  assert_int_equal(asc_stratify(strata, 2, &found), ASC_INVALID_ARGUMENT); /* no value */
  assert_int_equal(asc_stratify(strata, 0, &found), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_stratify(NULL, 1, &found), ASC_INVALID_ARGUMENT);
  const double sizes[] = {0.0, -1.0, NAN, INFINITY};
  for (int i = 0; i < 4; i++) {
    strata[0].size = sizes[i];
    assert_int_equal(asc_stratify(strata, 1, &found), ASC_INVALID_ARGUMENT);
  }
}

/* The variance that is stated is that of the estimate: over 4000 repetitions of 4 strata of u^2 with 3 values each, the
 * mean of the stated variances within 5 standard errors of the variance of the means and of the exact value. Collapsed
 * strata state more, by a known amount: the differences of the strata's means. */
static void the_stated_variance_is_that_of_repetitions(void **state) {
  (void)state;
  enum { REPETITIONS = 4000, STRATA = 4 };
  for (uint32_t each = 1; each <= 3; each += 2) {
    asc_moments means = {0}, stated = {0};
    for (uint32_t r = 0; r < REPETITIONS; r++) {
      asc_stratum strata[STRATA] = {{0}};
      for (uint32_t j = 0; j < STRATA; j++) {
        strata[j].size = 1.0;
        for (uint32_t i = 0; i < each; i++) {
          const double u = (j + drawn(r, 20 + 10 * each + STRATA * i + j)) / STRATA, value = u * u;
          assert_int_equal(asc_moments_add(&strata[j].moments, &value, 1), ASC_OK);
        }
      }
      asc_stratified found;
      assert_int_equal(asc_stratify(strata, STRATA, &found), ASC_OK);
      const double variance = found.standard_error * found.standard_error;
      assert_int_equal(asc_moments_add(&means, &found.mean, 1), ASC_OK);
      assert_int_equal(asc_moments_add(&stated, &variance, 1), ASC_OK);
    }
    /* Over [a, b]: E[u^2] = (b^3 - a^3)/(3 (b - a)), E[u^4] = (b^5 - a^5)/(5 (b - a)). */
    double exact = 0.0, level[STRATA];
    for (int j = 0; j < STRATA; j++) {
      const double a = j / 4.0, b = (j + 1) / 4.0;
      level[j] = (pow(b, 3) - pow(a, 3)) / 3.0 * 4.0;
      exact += ((pow(b, 5) - pow(a, 5)) / 5.0 * 4.0 - level[j] * level[j]) / (16.0 * each);
    }
    double expected = exact;
    for (int j = 0; each == 1 && j < STRATA; j += 2) expected += pow((level[j + 1] - level[j]) / 4.0, 2);
    const asc_moments_summary of_means = summary_of(&means), of_stated = summary_of(&stated);
    assert_true(fabs(of_stated.mean - expected) < 5.0 * of_stated.standard_error);
    assert_true(fabs(of_means.mean - 1.0 / 3) < 5.0 * of_means.standard_error);
    /* The variance of a variance of near normal values is 2/(n - 1) of its square. */
    assert_true(fabs(of_means.variance / exact - 1.0) < 5.0 * sqrt(2.0 / REPETITIONS));
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ten_digits_of_ten_million_values),
      cmocka_unit_test(few_values_and_refused_ones),
      cmocka_unit_test(parts_and_merges),
      cmocka_unit_test(the_laws_of_expectation_and_variance),
      cmocka_unit_test(strata_by_hand),
      cmocka_unit_test(strata_far_from_0_and_at_every_scale),
      cmocka_unit_test(strata_that_are_refused),
      cmocka_unit_test(the_stated_variance_is_that_of_repetitions),
  };
  return cmocka_run_group_tests_name("estimate_moments", tests, NULL, NULL);
}

/* Strata, quadrature rules, importance sampling; probabilities as integrals of densities. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "estimate_tools.h"

/* Sixteen cells, one sample in each: jittered samples. Each lies in its own cell, and the mean is theirs. */
static asc_status cells_met(void *context, size_t count, const asc_pixel *pixels, const double *points,
                            double *values) {
  (void)pixels;
  for (size_t i = 0; i < count; i++) {
    ((int *)context)[(int)(points[2 * i + 1] * 4) * 4 + (int)(points[2 * i] * 4)]++;
    values[i] = points[2 * i] + points[2 * i + 1];
  }
  return ASC_OK;
}

static void strata_hold_their_samples(void **state) {
  (void)state;
  asc_sampler *sampler = sampler_of("random", 64, 2);
  asc_estimator *estimator = estimator_of("stratified:n=48", sampler, 1);
  int met[16] = {0};
  const result found = estimated(estimator, (asc_group){7, 9, 1, 1}, cells_met, met);
  for (int i = 0; i < 16; i++) assert_int_equal(met[i], 3);
  assert_true(fabs(found.means[0] - 1.0) < 5.0 * found.errors[0]);
  /* V[x + y] = 1/6 in the pixel, 1/96 in a cell: sqrt(1/96/48) = 0.0147; its estimate, of 32 degrees, within a half.
   * Satterthwaite's degrees are 32 where all cells show the same variance, and about half of that where each has three
   * values. */
  assert_true(fabs(found.errors[0] / sqrt(1.0 / 96 / 48) - 1.0) < 0.5);
  assert_true(found.degrees[0] > 8.0 && found.degrees[0] <= 32.0);
  asc_estimator_destroy(estimator);
  asc_sampler_destroy(sampler);
}

/* x^7 y^6: Gauss and Legendre's rule of 4 points is exact up to degree 7, Clenshaw and Curtis' of 8 too. */
static asc_status powers(void *context, size_t count, const asc_pixel *pixels, const double *points, double *values) {
  (void)context, (void)pixels;
  for (size_t i = 0; i < count; i++) values[i] = pow(points[2 * i], 7) * pow(points[2 * i + 1], 6);
  return ASC_OK;
}

static void quadrature_rules_are_exact(void **state) {
  (void)state;
  const struct {
    const char *rule;
    uint64_t points;
  } rules[] = {{"gauss-legendre", 16}, {"clenshaw-curtis", 64}, {"gauss-legendre", 10000}};
  for (int i = 0; i < 3; i++) {
    asc_sampler *sampler = sampler_of(rules[i].rule, rules[i].points, 2);
    asc_estimator *estimator = estimator_of("fixed", sampler, 1);
    const result found = estimated(estimator, (asc_group){0, 0, 2, 1}, powers, NULL);
    /* The library's points are below 1 - 2^-24, as clenshaw-curtis' last: it moves by 6e-8, its weight is small. */
    assert_true(fabs(found.means[1] * 56.0 - 1.0) < (i == 1 ? 1e-7 : 1e-12));
    assert_true(isnan(found.errors[0]) && isnan(found.degrees[0]) && found.counts[0] == rules[i].points);
    asc_estimator_destroy(estimator);
    asc_sampler_destroy(sampler);
  }
}

/* 3 x^2 by its own density: every value is 1, and the estimate has no variance. */
static asc_status by_cube_root(const void *context, size_t count, const double *u, double *points, double *pdf) {
  const double *scale = context;
  for (size_t i = 0; i < count; i++) {
    points[i] = cbrt(u[i]);
    pdf[i] = *scale * 3.0 * points[i] * points[i];
  }
  return ASC_OK;
}

static asc_status square(void *context, size_t count, const asc_pixel *pixels, const double *points, double *values) {
  (void)context, (void)pixels;
  for (size_t i = 0; i < count; i++) values[i] = 3.0 * points[i] * points[i];
  return ASC_OK;
}

static void importance_sampling(void **state) {
  (void)state;
  asc_sampler *sampler = sampler_of("sobol", 64, 1); /* its first point is 0, where the density is 0 too */
  asc_estimator *estimator = estimator_of("fixed", sampler, 1);
  double scale = 1.0;
  asc_importance by = {1, 1, by_cube_root, &scale, square, NULL};
  const result found = estimated(estimator, (asc_group){0, 0, 1, 1}, asc_importance_values, &by);
  assert_true(fabs(found.means[0] - 63.0 / 64) < 1e-14);
  const double bad[] = {-1.0, NAN, INFINITY};
  for (int i = 0; i < 3; i++) {
    scale = bad[i];
    double mean;
    asc_estimates out = {.struct_size = sizeof out, .means = &mean};
    assert_int_equal(asc_estimate(estimator, &(asc_group){0, 0, 1, 1}, asc_importance_values, &by, &out, NULL),
                     ASC_NUMERIC);
  }
  asc_estimator_destroy(estimator);
  asc_sampler_destroy(sampler);

  /* A density in cells that follows f: the variance falls, the mean stays. */
  double weights[32];
  for (int i = 0; i < 32; i++) weights[i] = 3.0 * pow((i + 0.5) / 32, 2);
  const asc_density_desc desc = {sizeof desc, weights, 32, 0};
  asc_density *density = NULL;
  assert_int_equal(asc_density_create(&desc, &density, NULL), ASC_OK);
  sampler = sampler_of("random", 10000, 1);
  estimator = estimator_of("fixed", sampler, 1);
  by = (asc_importance){1, 1, asc_density_warping, density, square, NULL};
  const result better = estimated(estimator, (asc_group){0, 0, 1, 1}, asc_importance_values, &by);
  const result plain = estimated(estimator, (asc_group){0, 0, 1, 1}, square, NULL);
  assert_true(fabs(better.means[0] - 1.0) < 5.0 * better.errors[0] && better.errors[0] < plain.errors[0] / 10.0);
  asc_density_destroy(density);
  asc_estimator_destroy(estimator);
  asc_sampler_destroy(sampler);
}

/* The lecture's Pr(a <= X <= b) = P(b) - P(a): the share of samples in [a, b], the integral of the density, and the
 * difference of the distribution function, which is the inverse of the sampling. */
static void probabilities_are_differences_of_the_distribution(void **state) {
  (void)state;
  enum { N = 1 << 16 };
  const double weights[] = {3.0, 0.0, 1.0, 7.0, 0.5}, ends[][2] = {{0.05, 0.9}, {0.1, 0.15}, {0.45, 0.62}};
  const asc_density_desc desc = {sizeof desc, weights, 5, 0};
  asc_density *density = NULL;
  assert_int_equal(asc_density_create(&desc, &density, NULL), ASC_OK);
  for (int k = 0; k < 3; k++) {
    const double a = ends[k][0], b = ends[k][1];
    double at[2], inside = 0.0, integral = 0.0, u[2];
    assert_int_equal(asc_density_inverse(density, ends[k], 2, at), ASC_OK);
    for (int i = 0; i < N; i++) {
      const double middle = (i + 0.5) / N, x = a + (b - a) * middle;
      double pdf, point;
      assert_int_equal(asc_density_pdf(density, &x, 1, &pdf), ASC_OK);
      assert_int_equal(asc_density_sample(density, &middle, 1, &point), ASC_OK);
      integral += pdf * (b - a) / N;
      inside += point >= a && point <= b ? 1.0 / N : 0.0;
    }
    u[0] = at[1] - at[0];
    /* At most two of the N cells are cut by an end; of the integral, six by a jump of 3 or less. */
    assert_true(fabs(inside - u[0]) <= 2.0 / N && fabs(integral - u[0]) < 6.0 * 3.1 / N);
  }
  asc_density_destroy(density);
  /* The normal law's, between its own quantiles, by the trapezium rule: error (b - a)^3 f''/(12 N^2) < 1e-9. */
  double low, high, sum = 0.0;
  assert_int_equal(asc_normal_quantile(0.2, &low), ASC_OK);
  assert_int_equal(asc_normal_quantile(0.7, &high), ASC_OK);
  for (int i = 0; i <= N; i++) {
    const double x = low + (high - low) * i / N;
    sum += exp(-0.5 * x * x) * (i == 0 || i == N ? 0.5 : 1.0);
  }
  assert_true(fabs(sum * (high - low) / N / sqrt(8.0 * atan(1.0)) - 0.5) < 1e-9);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(strata_hold_their_samples),
      cmocka_unit_test(quadrature_rules_are_exact),
      cmocka_unit_test(importance_sampling),
      cmocka_unit_test(probabilities_are_differences_of_the_distribution),
  };
  return cmocka_run_group_tests_name("estimate_integrals", tests, NULL, NULL);
}

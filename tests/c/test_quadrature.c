/* The rules of quadrature: gauss-legendre, clenshaw-curtis. tests/python/test_quadrature.py holds nodes and weights
 * against mpmath and NumPy. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#include "sampler_tools.h"

#define MOST 500
#define MOVED 0x1p-24 /* by how much clenshaw-curtis's last node lies below 1 */

static void rule_of(const char *spec, uint64_t samples, uint32_t dimensions, double *points, double *weights) {
  asc_sampler *sampler = make(spec, samples, dimensions, 0);
  assert_int_equal(asc_sampler_traits(sampler), ASC_TRAIT_WEIGHTED);
  fill(sampler, 0, 0, 0, (size_t)samples, 0, dimensions, points);
  assert_int_equal(asc_sampler_weights(sampler, 0, (size_t)samples, weights), ASC_OK);
  asc_sampler_destroy(sampler);
}

/* The rule's integral of x^p over [0, 1], less 1/(p + 1). */
static double error_of_power(const double *points, const double *weights, uint32_t count, uint32_t p) {
  long double sum = 0.0L;
  for (uint32_t i = 0; i < count; i++) sum += (long double)weights[i] * powl((long double)points[i], p);
  return (double)(sum - 1.0L / (p + 1.0L));
}

/* A node off by half an ulp, 2^-54 at most, moves x^p by p times that; weights sum to 1 within an ulp. */
static double roundings(uint32_t p) { return (p + 4) * 0x1p-54; }

static const uint32_t counts[] = {1, 2, 3, 4, 5, 7, 8, 16, 31, 64, 101, 400, 401, 500};
#define COUNTS (sizeof counts / sizeof *counts)

static void gauss_is_exact_up_to_degree_2k_less_1(void **state) {
  (void)state;
  for (size_t c = 0; c < COUNTS; c++) {
    const uint32_t k = counts[c];
    double points[MOST], weights[MOST];
    rule_of("gauss-legendre", k, 1, points, weights);
    for (uint32_t p = 0; p < 2 * k; p++)
      if (!(fabs(error_of_power(points, weights, k, p)) <= roundings(p))) fail_msg("%u points, degree %u", k, p);
  }
}

/* The remainder for x^(2k) is -(k!)^4/((2k + 1) (2k)!^2) (Abramowitz and Stegun 1964, 25.4.30). */
static void gauss_misses_degree_2k_by_the_known_remainder(void **state) {
  (void)state;
  for (uint32_t k = 1; k <= 8; k++) {
    double points[MOST], weights[MOST];
    rule_of("gauss-legendre", k, 1, points, weights);
    long double choose = 1.0L; /* 2k over k */
    for (uint32_t i = 1; i <= k; i++) choose *= (long double)(k + i) / i;
    const double remainder = (double)(1.0L / ((2 * k + 1) * choose * choose));
    assert_true(fabs(error_of_power(points, weights, k, 2 * k) + remainder) <= roundings(2 * k));
  }
}

static void clenshaw_curtis_is_exact_up_to_its_degree(void **state) {
  (void)state;
  for (size_t c = 0; c < COUNTS; c++) {
    const uint32_t k = counts[c], degree = k % 2 ? k : k - 1;
    double points[MOST], weights[MOST];
    rule_of("clenshaw-curtis", k, 1, points, weights);
    for (uint32_t p = 0; p <= degree; p++)
      if (!(fabs(error_of_power(points, weights, k, p)) <= roundings(p) + (k > 1 ? weights[k - 1] * p * MOVED : 0.0)))
        fail_msg("%u points, degree %u", k, p);
  }
  double points[3], weights[3];
  rule_of("clenshaw-curtis", 3, 1, points, weights); /* Simpson's rule, its remainder for x^4 1/120 */
  assert_true(fabs(error_of_power(points, weights, 3, 4) - 1.0 / 120) <= roundings(4) + weights[2] * 4 * MOVED);
}

/* Gauss with two and three points, the midpoint, trapezoid and Simpson rules, Clenshaw and Curtis's with five. */
static void small_rules_are_the_known_ones(void **state) {
  (void)state;
  const struct {
    const char *spec;
    uint32_t count;
    double points[5], weights[5];
  } known[] = {
      {"gauss-legendre", 1, {0.5}, {1}},
      {"gauss-legendre", 2, {0.5 - 0.5 / sqrt(3), 0.5 + 0.5 / sqrt(3)}, {0.5, 0.5}},
      {"gauss-legendre", 3, {0.5 - sqrt(0.15), 0.5, 0.5 + sqrt(0.15)}, {5.0 / 18, 8.0 / 18, 5.0 / 18}},
      {"clenshaw-curtis", 1, {0.5}, {1}},
      {"clenshaw-curtis", 2, {0, 1 - MOVED}, {0.5, 0.5}},
      {"clenshaw-curtis", 3, {0, 0.5, 1 - MOVED}, {1.0 / 6, 4.0 / 6, 1.0 / 6}},
      {"clenshaw-curtis",
       5,
       {0, 0.5 - sqrt(0.125), 0.5, 0.5 + sqrt(0.125), 1 - MOVED},
       {1.0 / 30, 8.0 / 30, 12.0 / 30, 8.0 / 30, 1.0 / 30}},
  };
  for (size_t r = 0; r < sizeof known / sizeof *known; r++) {
    double points[5], weights[5];
    rule_of(known[r].spec, known[r].count, 1, points, weights);
    for (uint32_t i = 0; i < known[r].count; i++) {
      assert_true(fabs(points[i] - known[r].points[i]) <= DBL_EPSILON); /* the expected ones are rounded too */
      assert_true(fabs(weights[i] - known[r].weights[i]) <= DBL_EPSILON);
    }
  }
}

/* x^p y^q with both degrees within the rule's; the first dimension runs fastest. */
static void tensor_rules_are_exact_in_two_dimensions(void **state) {
  (void)state;
  const char *const specs[] = {"gauss-legendre", "clenshaw-curtis"};
  const uint32_t k = 5, degrees[] = {2 * k - 1, k};
  for (int s = 0; s < 2; s++) {
    double points[2 * 25], weights[25], line[5], line_weights[5];
    rule_of(specs[s], k * k, 2, points, weights);
    rule_of(specs[s], k, 1, line, line_weights);
    for (uint32_t i = 0; i < k * k; i++) {
      assert_true(points[2 * i] == line[i % k] && points[2 * i + 1] == line[i / k]);
      assert_true(weights[i] == line_weights[i % k] * line_weights[i / k]);
    }
    for (uint32_t p = 0; p <= degrees[s]; p++)
      for (uint32_t q = 0; q <= degrees[s]; q++) {
        long double sum = 0.0L;
        for (uint32_t i = 0; i < k * k; i++)
          sum +=
              (long double)weights[i] * powl((long double)points[2 * i], p) * powl((long double)points[2 * i + 1], q);
        const double moved = s ? line_weights[k - 1] * (p + q) * MOVED : 0.0;
        assert_true(fabs((double)(sum - 1.0L / ((p + 1) * (q + 1)))) <= roundings(p) + roundings(q) + moved);
      }
  }
}

/* Weights positive, their sum 1, nodes and weights symmetric, nodes ascending, at sizes on both sides of where the
 * methods change and at the largest. */
static void large_rules_are_sound(void **state) {
  (void)state;
  const char *const specs[] = {"gauss-legendre", "clenshaw-curtis"};
  const size_t sizes[] = {399, 400, 401, 402, 10007, (size_t)1 << 20};
  for (int s = 0; s < 2; s++)
    for (size_t c = 0; c < sizeof sizes / sizeof *sizes; c++) {
      const size_t k = sizes[c];
      double *points = malloc(2 * k * sizeof *points), *weights = points + k;
      assert_non_null(points);
      rule_of(specs[s], k, 1, points, weights);
      long double sum = 0.0L;
      if (k % 2) assert_true(points[k / 2] == 0.5);
      for (size_t i = 0; i < k; i++) {
        sum += (long double)weights[i];
        assert_true(weights[i] > 0.0 && weights[i] == weights[k - 1 - i]);
        /* Nodes next to 1 are moved to 1 - 2^-24; 1 - x is rounded at 2^-53. */
        if (points[i] > 0x1p-25 && points[k - 1 - i] > 0x1p-25)
          assert_true(fabs(points[i] + points[k - 1 - i] - 1.0) <= DBL_EPSILON);
        if (i && points[i] < 1.0 - 0x1p-24) assert_true(points[i] > points[i - 1]);
      }
      /* k weights of about 1/k, each rounded by 2^-53 of itself at most, two ulp where not correctly rounded. */
      assert_true(fabsl(sum - 1.0L) <= 2 * 0x1p-53L);
      free(points);
    }
}

static void counts_that_are_no_power_are_refused(void **state) {
  (void)state;
  const char *const specs[] = {"gauss-legendre", "clenshaw-curtis"};
  for (int s = 0; s < 2; s++) {
    assert_int_equal(created(specs[s], 2, 2), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 13, 2), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 16, 3), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 2, 1024), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], (1u << 20) + 1, 1), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], (uint64_t)1 << 53, 1), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 1u << 20, 2), ASC_OK);
    double point[1024], weight;
    asc_sampler *one = make(specs[s], 1, 1024, UINT64_MAX);
    fill(one, INT32_MIN, INT32_MAX, 0, 1, 0, 1024, point);
    for (int d = 0; d < 1024; d++) assert_true(point[d] == 0.5);
    assert_int_equal(asc_sampler_weights(one, 0, 1, &weight), ASC_OK);
    assert_true(weight == 1.0);
    asc_sampler_destroy(one);
    /* Two points in each of 53 dimensions, the last of them. */
    asc_sampler *many = make(specs[s], (uint64_t)1 << 53, 53, 0);
    fill(many, 0, 0, ((uint64_t)1 << 53) - 1, 1, 0, 53, point);
    for (int d = 0; d < 53; d++) assert_true(point[d] > 0.75);
    assert_int_equal(asc_sampler_weights(many, ((uint64_t)1 << 53) - 1, 1, &weight), ASC_OK);
    assert_true(weight == 0x1p-53);
    const asc_range past = {0, 0, (uint64_t)1 << 53, 1, 0, 1};
    assert_int_equal(asc_sampler_fill(many, &past, point), ASC_UNSUPPORTED);
    asc_sampler_destroy(many);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(gauss_is_exact_up_to_degree_2k_less_1),
      cmocka_unit_test(gauss_misses_degree_2k_by_the_known_remainder),
      cmocka_unit_test(clenshaw_curtis_is_exact_up_to_its_degree),
      cmocka_unit_test(small_rules_are_the_known_ones),
      cmocka_unit_test(tensor_rules_are_exact_in_two_dimensions),
      cmocka_unit_test(large_rules_are_sound),
      cmocka_unit_test(counts_that_are_no_power_are_refused),
  };
  return cmocka_run_group_tests_name("quadrature", tests, NULL, NULL);
}

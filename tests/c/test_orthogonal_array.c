/* Orthogonal arrays, and the finite fields that they are made with. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "galois.h"

#include "refused.h"
#include "sampler_tools.h"

#define MOST_POINTS 729
#define MOST_DIMENSIONS 28

static size_t cell_of(double x, size_t cells) { return (size_t)(x * (double)cells); }

/* Each cell of the given dimensions together, `side` strata each, holds as many points. */
static void check_cells(const double *points, size_t samples, size_t dimensions, const size_t *chosen, size_t count,
                        size_t side) {
  static unsigned short seen[MOST_POINTS * MOST_DIMENSIONS];
  size_t cells = 1;
  for (size_t k = 0; k < count; k++) cells *= side;
  memset(seen, 0, cells * sizeof *seen);
  for (size_t i = 0; i < samples; i++) {
    size_t cell = 0;
    for (size_t k = 0; k < count; k++) cell = cell * side + cell_of(points[i * dimensions + chosen[k]], side);
    seen[cell]++;
  }
  for (size_t cell = 0; cell < cells; cell++) assert_int_equal(seen[cell], samples / cells);
}

/* Every one, two and (for strength 3) three of the dimensions. */
static void check_strength(const double *points, size_t samples, size_t dimensions, size_t side, int strength) {
  for (size_t a = 0; a < dimensions; a++) {
    check_cells(points, samples, dimensions, (const size_t[]){a}, 1, side);
    for (size_t b = 0; b < a; b++) {
      check_cells(points, samples, dimensions, (const size_t[]){a, b}, 2, side);
      for (size_t c = 0; c < b && strength == 3; c++)
        check_cells(points, samples, dimensions, (const size_t[]){a, b, c}, 3, side);
    }
  }
}

/* Whether each dimension has one point in each of N strata. */
static int is_latin(const double *points, size_t samples, size_t dimensions) {
  for (size_t d = 0; d < dimensions; d++) {
    unsigned char seen[MOST_POINTS] = {0};
    for (size_t i = 0; i < samples; i++)
      if (seen[cell_of(points[i * dimensions + d], samples)]++) return 0;
  }
  return 1;
}

static const char *const jitters[] = {"jittered", "multi-jittered", "correlated"};

static void check_all_jitters(size_t side, int strength) {
  static double points[MOST_POINTS * MOST_DIMENSIONS];
  const size_t samples = strength == 2 ? side * side : side * side * side;
  const uint32_t dimensions = (uint32_t)side + 1;
  for (size_t k = 0; k < 3; k++) {
    char spec[64];
    (void)snprintf(spec, sizeof spec, "orthogonal-array:jitter=%s,strength=%d", jitters[k], strength);
    points_of(spec, samples, dimensions, side, points);
    check_strength(points, samples, dimensions, side, strength);
    assert_int_equal(is_latin(points, samples, dimensions), k > 0);
  }
}

static void any_two_dimensions_have_one_point_in_each_cell(void **state) {
  (void)state;
  const size_t sides[] = {2, 3, 4, 5, 7, 8, 9, 11, 13, 16, 25, 27};
  for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) check_all_jitters(sides[k], 2);
}

static void any_three_dimensions_have_one_point_in_each_cell(void **state) {
  (void)state;
  const size_t sides[] = {2, 3, 4, 5, 7, 8, 9};
  for (size_t k = 0; k < sizeof sides / sizeof *sides; k++) check_all_jitters(sides[k], 3);
}

static void one_point_has_any_dimensions(void **state) {
  (void)state;
  double point[9];
  for (int strength = 2; strength <= 3; strength++)
    points_of(strength == 2 ? "orthogonal-array" : "orthogonal-array:strength=3", 1, 9, 3, point);
}

/* Symbols are permuted in each dimension on its own, so one sample lies in all 27 cells of three dimensions equally
 * often although its array has 9 of them: chi-squared of 26 degrees of freedom exceeds 75.5 with probability 1e-6. */
static void each_sample_reaches_all_cells_equally(void **state) {
  (void)state;
  enum { DRAWS = 8100 };
  unsigned seen[27] = {0};
  double chi = 0.0;
  asc_sampler *sampler = make("orthogonal-array", 9, 3, 4);
  for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
    double point[3];
    fill(sampler, pixel, 9, 0, 1, 0, 3, point);
    seen[cell_of(point[0], 3) * 9 + cell_of(point[1], 3) * 3 + cell_of(point[2], 3)]++;
  }
  asc_sampler_destroy(sampler);
  for (size_t cell = 0; cell < 27; cell++) chi += (seen[cell] - 300.0) * (seen[cell] - 300.0) / 300.0;
  assert_true(chi < 75.5);
}

/* Each s samples from a multiple of s on have each symbol of the first s dimensions once. */
static void runs_of_samples_are_stratified(void **state) {
  (void)state;
  double points[64 * 8];
  points_of("orthogonal-array", 64, 8, 5, points);
  for (size_t run = 0; run < 8; run++)
    for (size_t d = 0; d < 8; d++) check_cells(points + run * 64, 8, 8, &d, 1, 8);
}

/* In each pair (0,1), (2,3), ... the points of a row of s x s cells share their sub-column, as in Kensler's pattern;
 * multi-jittered they do not. */
static void correlated_pairs_share_their_substrata(void **state) {
  (void)state;
  const char *const specs[] = {"orthogonal-array:jitter=correlated", "orthogonal-array"};
  const size_t sides[] = {5, 8, 9};
  for (size_t k = 0; k < 2; k++)
    for (size_t s = 0; s < 3; s++) {
      const size_t side = sides[s], n = side * side, dimensions = side + 1;
      double points[81 * 10];
      points_of(specs[k], n, (uint32_t)dimensions, 2, points);
      for (size_t d = 0; d + 1 < dimensions - dimensions % 2; d++) {
        size_t shared[9], differ = 0;
        memset(shared, 0xff, sizeof shared);
        for (size_t i = 0; i < n; i++) {
          const size_t row = cell_of(points[i * dimensions + (d ^ 1u)], side);
          const size_t sub = cell_of(points[i * dimensions + d], n) % side;
          if (shared[row] == SIZE_MAX) shared[row] = sub;
          differ += shared[row] != sub;
        }
        assert_int_equal(differ > 0, k == 1);
      }
    }
}

/* 2^20 points in 1,024 dimensions, the largest array, and one of an odd prime power: any sample without the others. */
static void large_arrays_are_arrays(void **state) {
  (void)state;
  enum { SIDE = 1024, N = SIDE * SIDE };
  double *points = malloc((size_t)N * 2 * sizeof *points);
  unsigned char *seen = calloc(N, 1);
  asc_sampler *sampler = make("orthogonal-array", N, 1024, UINT64_MAX);
  fill(sampler, 0, 0, 0, N, 1022, 2, points);
  for (size_t i = 0; i < N; i++)
    assert_int_equal(seen[cell_of(points[2 * i], SIDE) * SIDE + cell_of(points[2 * i + 1], SIDE)]++, 0);
  for (size_t d = 0; d < 2; d++) {
    memset(seen, 0, N);
    for (size_t i = 0; i < N; i++) assert_int_equal(seen[cell_of(points[2 * i + d], N)]++, 0);
  }
  asc_sampler_destroy(sampler);
  free(points);
  free(seen);
  const uint64_t counts[] = {(uint64_t)1 << 32, (uint64_t)59049 * 59049, (uint64_t)65521 * 65521};
  for (size_t k = 0; k < 3; k++) {
    double ends[2 * 3];
    sampler = make("orthogonal-array:jitter=correlated", counts[k], 3, 0);
    fill(sampler, INT32_MAX, INT32_MIN, counts[k] - 2, 2, 0, 3, ends);
    for (size_t i = 0; i < 6; i++) assert_true(ends[i] >= 0.0 && ends[i] < 1.0);
    asc_sampler_destroy(sampler);
  }
}

/* A field: the sum and product of each pair, checked as tables. Distributivity ties the two together. */
static void fields_are_fields(void **state) {
  (void)state;
  const uint32_t sizes[] = {2, 3, 4, 5, 7, 8, 9, 16, 25, 27, 32, 49, 64, 81, 121};
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
    asc_galois field;
    const uint32_t s = sizes[k];
    assert_int_equal(asc_galois_make(&field, s), ASC_OK);
    for (uint32_t a = 0; a < s; a++) {
      unsigned char sums[128] = {0}, products[128] = {0};
      assert_int_equal(asc_galois_add(&field, a, 0), a);
      assert_int_equal(asc_galois_multiply(&field, a, 1), a);
      for (uint32_t b = 0; b < s; b++) {
        const uint32_t sum = asc_galois_add(&field, a, b), product = asc_galois_multiply(&field, a, b);
        assert_true(sum < s && product < s);
        assert_int_equal(sums[sum]++, 0);
        assert_true(products[product]++ == 0 || a == 0);
        assert_int_equal(sum, asc_galois_add(&field, b, a));
        assert_int_equal(product, asc_galois_multiply(&field, b, a));
        for (uint32_t c = 0; c < s; c += 1 + s / 16)
          assert_int_equal(
              asc_galois_multiply(&field, c, sum),
              asc_galois_add(&field, asc_galois_multiply(&field, c, a), asc_galois_multiply(&field, c, b)));
      }
    }
    asc_galois_free(&field);
  }
}

/* 2^16, 3^10 and 5^6: a generator is found, so its powers are all elements but 0, and products have inverses. */
static void large_fields_are_made(void **state) {
  (void)state;
  const uint32_t sizes[] = {65536, 59049, 15625, 65521};
  for (size_t k = 0; k < 4; k++) {
    asc_galois field;
    assert_int_equal(asc_galois_make(&field, sizes[k]), ASC_OK);
    unsigned char *seen = calloc(sizes[k], 1);
    for (uint32_t a = 0; a < sizes[k]; a++) {
      const uint32_t product = asc_galois_multiply(&field, a, sizes[k] - 1);
      assert_int_equal(seen[product]++, 0);
    }
    free(seen);
    asc_galois_free(&field);
  }
}

static void what_has_no_array_is_refused(void **state) {
  (void)state;
  const char *const three = "orthogonal-array:strength=3";
  assert_refused("orthogonal-array", 30, 2, ASC_UNSUPPORTED, "choose 25 or 49");
  assert_refused("orthogonal-array", 36, 2, ASC_UNSUPPORTED, "choose 25 or 49"); /* 6 is no prime power */
  assert_refused("orthogonal-array", 25, 7, ASC_UNSUPPORTED, "25 in 7 dimensions is not so: choose 49");
  assert_refused("orthogonal-array", 70, 7, ASC_UNSUPPORTED, "choose 64 or 81");
  assert_refused("orthogonal-array", 2, 2, ASC_UNSUPPORTED, "choose 4");
  assert_refused("orthogonal-array", 4, 1024, ASC_UNSUPPORTED, "choose 1048576");
  assert_refused("orthogonal-array", ((uint64_t)1 << 32) + 1, 2, ASC_UNSUPPORTED, "choose 4294967296");
  assert_refused(three, 64, 6, ASC_UNSUPPORTED, "choose 125");
  assert_refused(three, 100, 2, ASC_UNSUPPORTED, "s^3 points");
  assert_refused(three, 100, 2, ASC_UNSUPPORTED, "choose 64 or 125");
  assert_refused(three, (uint64_t)1 << 33, 2, ASC_UNSUPPORTED, "choose 4");
  assert_refused("orthogonal-array:strength=4", 16, 2, ASC_INVALID_VALUE, "strength");
  assert_refused("orthogonal-array:jitter=some", 16, 2, ASC_INVALID_VALUE, "jittered|multi-jittered|correlated");
  assert_int_equal(created("orthogonal-array", 25, 6), ASC_OK);
  assert_int_equal(created(three, 64, 5), ASC_OK);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(fields_are_fields),
      cmocka_unit_test(large_fields_are_made),
      cmocka_unit_test(any_two_dimensions_have_one_point_in_each_cell),
      cmocka_unit_test(any_three_dimensions_have_one_point_in_each_cell),
      cmocka_unit_test(one_point_has_any_dimensions),
      cmocka_unit_test(each_sample_reaches_all_cells_equally),
      cmocka_unit_test(runs_of_samples_are_stratified),
      cmocka_unit_test(correlated_pairs_share_their_substrata),
      cmocka_unit_test(large_arrays_are_arrays),
      cmocka_unit_test(what_has_no_array_is_refused),
  };
  return cmocka_run_group_tests_name("orthogonal array", tests, NULL, NULL);
}

/* N rooks: one point in each row of each dimension, by permutations that are uniform. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sampler_tools.h"

/* Both sides of 64, where the permutations change; primes, powers of two, and one past one, where they are walked most.
 */
static void each_row_of_each_dimension_holds_one_point(void **state) {
  (void)state;
  static const uint64_t sizes[] = {1, 2, 3, 16, 63, 64, 65, 100, 128, 129, 997, 4097, 32768};
  static double points[32768 * 5], centres[32768 * 5], corners[32768 * 5];
  static unsigned char seen[5][32768];
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
    const uint64_t n = sizes[k];
    points_of("n-rooks", n, 5, 3, points);
    points_of("n-rooks:centred=1", n, 5, 3, centres);
    points_of("n-rooks:corner=1", n, 5, 3, corners);
    memset(seen, 0, sizeof seen);
    for (size_t i = 0; i < n; i++)
      for (size_t d = 0; d < 5; d++) {
        const size_t row = (size_t)(points[5 * i + d] * (double)n);
        assert_true(row < n);
        assert_int_equal(seen[d][row]++, 0);
        assert_true(corners[5 * i + d] == (double)row / (double)n);
        assert_true(centres[5 * i + d] == ((double)row + 0.5) / (double)n);
      }
  }
}

static void centre_and_corner_exclude_each_other(void **state) {
  (void)state;
  assert_int_equal(created("n-rooks:centred=1,corner=1", 4, 2), ASC_INVALID_VALUE);
  assert_int_equal(created("n-rooks:centred=2", 4, 2), ASC_INVALID_VALUE);
  assert_int_equal(created("n-rooks:centred=0,corner=1", 4, 2), ASC_OK);
  assert_int_equal(created("n-rooks", ((uint64_t)1 << 48) + 1, 2), ASC_UNSUPPORTED);
}

/* A place in a cell never rounds into the next: at the largest counts, above and below what 32 bits hold. */
static void points_keep_to_their_rows_for_large_n(void **state) {
  (void)state;
  const uint64_t sizes[] = {(1u << 20) - 3, (1u << 21) + 1, UINT32_MAX, ((uint64_t)1 << 32) + 1,
                            ((uint64_t)1 << 48) - 1};
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
    asc_sampler *jittered = make("n-rooks", sizes[k], 3, 1), *corner = make("n-rooks:corner=1", sizes[k], 3, 1);
    for (uint64_t i = 0; i < 300; i++) {
      double points[3 * 7], corners[3 * 7], one[3];
      fill(jittered, 5, 5, sizes[k] - 7 * (i + 1), 7, 0, 3, points);
      fill(corner, 5, 5, sizes[k] - 7 * (i + 1), 7, 0, 3, corners);
      fill(jittered, 5, 5, sizes[k] - 7 * (i + 1) + 3, 1, 0, 3, one);
      assert_memory_equal(one, points + 9, sizeof one);
      for (int v = 0; v < 21; v++) /* corners are rounded; values below 1 - 2^-25 are not moved */
        if (points[v] < 1.0 - 0x1p-24)
          assert_true(floor(points[v] * (double)sizes[k]) == floor(corners[v] * (double)sizes[k] + 0.25));
    }
    asc_sampler_destroy(jittered);
    asc_sampler_destroy(corner);
  }
}

/* --- uniformity -----------------------------------------------------------------------------------------------------
 */

/* Chi-squared as a standard normal quantile (Wilson and Hilferty): beyond 5 with a probability of 6e-7; fixed seeds. */
static double surprise(double chi, double freedom) {
  const double spread = 2.0 / (9.0 * freedom);
  return (cbrt(chi / freedom) - (1.0 - spread)) / sqrt(spread);
}

/* All 24 permutations of 4 in each of three dimensions, and all 24 x 24 of two dimensions together. */
static void all_permutations_of_four_are_equally_likely(void **state) {
  (void)state;
  enum { DRAWS = 60000 };
  static unsigned single[3][256], both[256][256];
  memset(single, 0, sizeof single);
  memset(both, 0, sizeof both);
  asc_sampler *sampler = make("n-rooks", 4, 3, 17);
  for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
    double points[4 * 3];
    unsigned code[3] = {0};
    fill(sampler, pixel, -pixel, 0, 4, 0, 3, points);
    for (int i = 0; i < 4; i++)
      for (int d = 0; d < 3; d++) code[d] = code[d] << 2 | (unsigned)(points[3 * i + d] * 4);
    for (int d = 0; d < 3; d++) single[d][code[d]]++;
    both[code[0]][code[1]]++;
  }
  asc_sampler_destroy(sampler);
  for (int d = 0; d < 3; d++) {
    double chi = 0.0;
    int reached = 0;
    for (int code = 0; code < 256; code++) {
      reached += single[d][code] > 0;
      if (single[d][code]) chi += pow(single[d][code] - DRAWS / 24.0, 2) / (DRAWS / 24.0);
    }
    assert_int_equal(reached, 24);
    assert_true(fabs(surprise(chi, 23)) < 5);
  }
  double chi = 0.0;
  for (int a = 0; a < 256; a++)
    for (int b = 0; b < 256; b++)
      if (single[0][a] && single[1][b]) chi += pow(both[a][b] - DRAWS / 576.0, 2) / (DRAWS / 576.0);
  assert_true(fabs(surprise(chi, 575)) < 5);
}

/* Where two points of one dimension go: every ordered pair of different cells equally often, for pairs of points that a
 * weak permutation treats alike: neighbours, half of N apart, the first and the last. */
static void check_pairs(uint64_t n, int32_t draws) {
  unsigned *counts = calloc(n * n, sizeof *counts);
  assert_non_null(counts);
  const uint64_t partners[] = {1, n / 2, n - 1};
  asc_sampler *sampler = make("n-rooks", n, 1, 29);
  for (size_t k = 0; k < 3; k++) {
    memset(counts, 0, n * n * sizeof *counts);
    for (int32_t pixel = 0; pixel < draws; pixel++) {
      double first, second;
      fill(sampler, pixel, (int32_t)k, 0, 1, 0, 1, &first);
      fill(sampler, pixel, (int32_t)k, partners[k], 1, 0, 1, &second);
      counts[(size_t)(first * (double)n) * n + (size_t)(second * (double)n)]++;
    }
    const double pairs = (double)(n * (n - 1)), expected = draws / pairs;
    double chi = 0.0;
    for (size_t a = 0; a < n; a++)
      for (size_t b = 0; b < n; b++)
        if (a == b)
          assert_int_equal(counts[a * n + b], 0);
        else
          chi += (counts[a * n + b] - expected) * (counts[a * n + b] - expected) / expected;
    if (fabs(surprise(chi, pairs - 1)) > 5) fail_msg("N = %u, points 0 and %u", (unsigned)n, (unsigned)partners[k]);
  }
  asc_sampler_destroy(sampler);
  free(counts);
}

static void pairs_of_points_go_to_all_pairs_of_cells(void **state) {
  (void)state;
  check_pairs(16, 40000);
  check_pairs(64, 40000);
  check_pairs(65, 100000); /* walked most often */
  check_pairs(100, 100000);
  check_pairs(128, 160000); /* never walked */
}

/* At N = 2^20 and one above, in 32 x 32 groups of cells: the pairs of points of one dimension, and of two dimensions of
 * one point. */
static void large_permutations_are_uniform_in_groups(void **state) {
  (void)state;
  enum { DRAWS = 50000, GROUPS = 32 };
  const uint64_t sizes[] = {1 << 20, (1 << 20) + 1};
  for (size_t k = 0; k < 2; k++) {
    static unsigned far[GROUPS * GROUPS], across[GROUPS * GROUPS];
    memset(far, 0, sizeof far);
    memset(across, 0, sizeof across);
    asc_sampler *sampler = make("n-rooks", sizes[k], 2, 31);
    for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
      double point[2], other[2];
      fill(sampler, pixel, 8, 5, 1, 0, 2, point);
      fill(sampler, pixel, 8, 5 + (1 << 19), 1, 0, 2, other);
      far[(int)(point[0] * GROUPS) * GROUPS + (int)(other[0] * GROUPS)]++;
      across[(int)(point[0] * GROUPS) * GROUPS + (int)(point[1] * GROUPS)]++;
    }
    double chi_far = 0.0, chi_across = 0.0;
    const double expected = (double)DRAWS / (GROUPS * GROUPS);
    for (int i = 0; i < GROUPS * GROUPS; i++) {
      chi_far += (far[i] - expected) * (far[i] - expected) / expected;
      chi_across += (across[i] - expected) * (across[i] - expected) / expected;
    }
    assert_true(fabs(surprise(chi_far, GROUPS * GROUPS - 1)) < 5);
    assert_true(fabs(surprise(chi_across, GROUPS * GROUPS - 1)) < 5);
    asc_sampler_destroy(sampler);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(each_row_of_each_dimension_holds_one_point),
      cmocka_unit_test(centre_and_corner_exclude_each_other),
      cmocka_unit_test(points_keep_to_their_rows_for_large_n),
      cmocka_unit_test(all_permutations_of_four_are_equally_likely),
      cmocka_unit_test(pairs_of_points_go_to_all_pairs_of_cells),
      cmocka_unit_test(large_permutations_are_uniform_in_groups),
  };
  return cmocka_run_group_tests_name("n-rooks", tests, NULL, NULL);
}

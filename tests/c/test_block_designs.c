/* Block designs: Latin squares, queens, multi-jittered patterns. Statistical tests have a significance of 1e-6 and
 * fixed seeds. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "refused.h"
#include "sampler_tools.h"

static size_t cell_of(double x, size_t cells) { return (size_t)(x * (double)cells); }

/* Each of `cells` strata of a dimension holds as many points. */
static void check_strata(const double *points, size_t samples, size_t dimensions, size_t dimension, size_t cells) {
  unsigned *seen = calloc(cells, sizeof *seen);
  for (size_t i = 0; i < samples; i++) seen[cell_of(points[i * dimensions + dimension], cells)]++;
  for (size_t cell = 0; cell < cells; cell++) assert_int_equal(seen[cell], samples / cells);
  free(seen);
}

/* Upper quantile 1 - 1e-6 of chi-squared with k degrees of freedom (Wilson and Hilferty 1931; within 1 % from k = 3).
 */
static double chi_squared_limit(double k) {
  const double spread = 2.0 / (9.0 * k);
  const double root = 1.0 - spread + 4.7534243 * sqrt(spread); /* the normal quantile */
  return k * root * root * root;
}

static int ascending(const void *a, const void *b) {
  const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
  return (x > y) - (x < y);
}

/* Sorts the codes of what was drawn; how many different ones there are. `chi` gets chi-squared against equal shares. */
static size_t count_kinds(uint64_t *codes, size_t draws, double *chi) {
  size_t kinds = 0;
  double squares = 0.0;
  qsort(codes, draws, sizeof *codes, ascending);
  for (size_t i = 0, run = 0; i < draws; i++) {
    run++;
    if (i + 1 < draws && codes[i + 1] == codes[i]) continue;
    squares += (double)run * (double)run;
    kinds++;
    run = 0;
  }
  *chi = squares * (double)kinds / (double)draws - (double)draws;
  return kinds;
}

static void check_equally_likely(uint64_t *codes, size_t draws, size_t kinds) {
  double chi;
  assert_int_equal(count_kinds(codes, draws, &chi), kinds);
  if (chi > chi_squared_limit((double)kinds - 1.0)) fail_msg("%zu kinds are not equally likely: %g", kinds, chi);
}

/* --- latin-square */

static void one_symbol_is_once_in_each_row_and_column(void **state) {
  (void)state;
  const size_t orders[] = {1, 2, 3, 17, 64, 65, 1000};
  for (size_t k = 0; k < sizeof orders / sizeof *orders; k++) {
    static double points[1000 * 5];
    for (uint32_t dimensions = 1; dimensions <= 5; dimensions += dimensions == 2 ? 2 : 1) {
      points_of("latin-square", orders[k], dimensions, k, points);
      for (size_t d = 0; d < dimensions; d++) check_strata(points, orders[k], dimensions, d, orders[k]);
    }
  }
}

static void each_two_of_row_column_and_symbol_are_together_once(void **state) {
  (void)state;
  const size_t orders[] = {1, 2, 3, 4, 5, 6, 16, 17, 64};
  static double points[64 * 64 * 3];
  for (size_t k = 0; k < sizeof orders / sizeof *orders; k++) {
    const size_t n = orders[k];
    points_of("latin-square", n * n, 3, k, points);
    for (size_t a = 0; a < 3; a++) {
      static int seen[64 * 64];
      memset(seen, 0, sizeof seen);
      for (size_t i = 0; i < n * n; i++) {
        const size_t cell = cell_of(points[3 * i + a], n) * n + cell_of(points[3 * i + (a + 1) % 3], n);
        assert_int_equal(seen[cell]++, 0);
      }
    }
  }
}

/* The square of one pixel: symbol [row * n + column]. */
static void square_of(const asc_sampler *sampler, int32_t pixel, size_t n, unsigned *symbol) {
  double points[25 * 3];
  fill(sampler, pixel, 3, 0, n * n, 0, 3, points);
  for (size_t i = 0; i < n * n; i++)
    symbol[cell_of(points[3 * i + 1], n) * n + cell_of(points[3 * i], n)] = (unsigned)cell_of(points[3 * i + 2], n);
}

/* There are 12 Latin squares of order 3 and 576 of order 4 (OEIS A002860). The cells of their symbol 0 are all n!
 * permutations equally often, which is what the pattern in two dimensions rests on. */
static void all_latin_squares_are_equally_likely(void **state) {
  (void)state;
  enum { DRAWS = 57600 };
  static uint64_t squares[DRAWS], symbols[DRAWS], planes[DRAWS];
  const size_t count[] = {12, 576}, factorial[] = {6, 24};
  for (size_t n = 3; n <= 4; n++) {
    asc_sampler *cube = make("latin-square", n * n, 3, 6), *plane = make("latin-square", n, 2, 6);
    for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
      unsigned symbol[25], column_at[4];
      double points[4 * 2];
      square_of(cube, pixel, n, symbol);
      squares[pixel] = symbols[pixel] = planes[pixel] = 0;
      for (size_t i = 0; i < n * n; i++) squares[pixel] = squares[pixel] * n + symbol[i];
      for (size_t i = 0; i < n * n; i++)
        if (symbol[i] == 0) symbols[pixel] = symbols[pixel] * n + i % n;
      fill(plane, pixel, 3, 0, n, 0, 2, points);
      for (size_t i = 0; i < n; i++) column_at[cell_of(points[2 * i + 1], n)] = (unsigned)cell_of(points[2 * i], n);
      for (size_t row = 0; row < n; row++) planes[pixel] = planes[pixel] * n + column_at[row];
    }
    asc_sampler_destroy(cube);
    asc_sampler_destroy(plane);
    check_equally_likely(squares, DRAWS, count[n - 3]);
    check_equally_likely(symbols, DRAWS, factorial[n - 3]);
    check_equally_likely(planes, DRAWS, factorial[n - 3]);
  }
}

/* Renaming rows, columns and symbols does not lead from one to the other of the two classes of order 5, so this is the
 * walk's own doing: 6 of the 56 reduced squares are renamed tables of the cyclic group (Fisher and Yates 1934, "The 6 x
 * 6 Latin squares"), the only ones without a 2 x 2 subsquare. */
static void both_classes_of_order_five_have_their_share(void **state) {
  (void)state;
  enum { DRAWS = 20000 };
  int without = 0;
  asc_sampler *sampler = make("latin-square", 25, 3, 1);
  for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
    unsigned symbol[25], subsquares = 0;
    square_of(sampler, pixel, 5, symbol);
    for (size_t a = 0; a < 5; a++)
      for (size_t b = 0; b < a; b++)
        for (size_t x = 0; x < 5; x++)
          for (size_t y = 0; y < x; y++)
            subsquares += symbol[5 * a + x] == symbol[5 * b + y] && symbol[5 * a + y] == symbol[5 * b + x];
    without += subsquares == 0;
  }
  asc_sampler_destroy(sampler);
  const double share = 6.0 / 56.0, deviation = sqrt(DRAWS * share * (1.0 - share));
  assert_true(fabs(without - DRAWS * share) < 4.9 * deviation); /* two-sided 1e-6 */
}

/* --- n-queens */

static void check_queens(const double *points, size_t n, size_t dimensions, size_t first) {
  unsigned char *rising = calloc(2 * n, 1), *falling = calloc(2 * n, 1);
  for (size_t d = first; d < first + 2; d++) check_strata(points, n, dimensions, d, n);
  for (size_t i = 0; i < n; i++) {
    const size_t x = cell_of(points[i * dimensions + first], n), y = cell_of(points[i * dimensions + first + 1], n);
    assert_int_equal(rising[x + n - y]++, 0);
    assert_int_equal(falling[x + y]++, 0);
  }
  free(rising);
  free(falling);
}

static void queens_do_not_attack(void **state) {
  (void)state;
  const char *const specs[] = {"n-queens", "n-queens:solution=construction", "n-queens:centred=1"};
  const size_t large[] = {100, 101, 602, 1000, 4096, 10007, 100000};
  double *points = malloc(100000 * 4 * sizeof *points);
  for (size_t k = 0; k < 3; k++)
    for (size_t i = 0; i < 64 + sizeof large / sizeof *large; i++) {
      const size_t n = i < 64 ? i + 1 : large[i - 64];
      if (n == 2 || n == 3) continue;
      const uint32_t dimensions = n < 100000 ? 4 : 2;
      points_of(specs[k], n, dimensions, i, points);
      for (uint32_t first = 0; first < dimensions; first += 2) check_queens(points, n, dimensions, first);
    }
  free(points);
}

/* How many solutions different pixels have, of `n` queens. */
static size_t solutions_of(const char *spec, size_t n) {
  enum { DRAWS = 4000 };
  static uint64_t codes[DRAWS];
  double chi;
  asc_sampler *sampler = make(spec, n, 2, 8);
  for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
    double points[8 * 2];
    size_t column_at[8];
    fill(sampler, 0, pixel, 0, n, 0, 2, points);
    for (size_t i = 0; i < n; i++) column_at[cell_of(points[2 * i + 1], n)] = cell_of(points[2 * i], n);
    codes[pixel] = 0;
    for (size_t row = 0; row < n; row++) codes[pixel] = codes[pixel] * n + column_at[row];
  }
  asc_sampler_destroy(sampler);
  return count_kinds(codes, DRAWS, &chi);
}

/* All solutions there are (OEIS A000170). The rarest of a uniform choice would stay away from 4,000 pixels with
 * probability 1e-19; the search's own choice is within a factor of a few of uniform. The constructed
 * ones are one solution turned and reflected; of an even board it is its own half turn, so there are 4, of 4 queens 2.
 */
static void every_solution_is_reached(void **state) {
  (void)state;
  const size_t solutions[] = {2, 10, 4, 40, 92};
  for (size_t n = 4; n <= 8; n++) assert_int_equal(solutions_of("n-queens", n), solutions[n - 4]);
  assert_int_equal(solutions_of("n-queens:solution=construction", 4), 2);
  assert_int_equal(solutions_of("n-queens:solution=construction", 8), 4);
  assert_int_equal(solutions_of("n-queens:solution=construction", 7), 8);
}

/* The bias that n_queens.c states for N = 64: 0.73 of a uniform pattern's points in the corners, 1/8 x 1/8 each. Of
 * 1,000 boards 4,000 would lie there; the measured standard deviation is 45. */
static void boards_have_fewer_queens_in_their_corners(void **state) {
  (void)state;
  int corners = 0;
  asc_sampler *sampler = make("n-queens", 64, 2, 2);
  for (int32_t pixel = 0; pixel < 1000; pixel++) {
    double points[64 * 2];
    fill(sampler, pixel, pixel, 0, 64, 0, 2, points);
    for (size_t i = 0; i < 64; i++)
      corners += fabs(points[2 * i] - 0.5) > 0.375 && fabs(points[2 * i + 1] - 0.5) > 0.375;
  }
  asc_sampler_destroy(sampler);
  assert_true(abs(corners - 2920) < 5 * 45);
}

static void centred_points_are_at_centres(void **state) {
  (void)state;
  const char *const specs[] = {"latin-square:centred=1", "n-queens:centred=1"};
  for (size_t k = 0; k < 2; k++)
    for (uint32_t dimensions = 2; dimensions <= 3; dimensions++) {
      double points[16 * 3];
      const double cells = k == 0 && dimensions == 3 ? 4.0 : 16.0;
      points_of(specs[k], 16, dimensions, 1, points);
      for (size_t i = 0; i < (size_t)16 * dimensions; i++)
        assert_true(points[i] * cells - floor(points[i] * cells) == 0.5);
    }
}

/* --- multi-jittered */

static const char *const multi_jittered[] = {"multi-jittered", "correlated-multi-jittered"};

typedef struct shape {
  size_t columns, rows;
} shape;

/* The largest divisor up to the square root, and the other one. */
static const shape shapes[] = {{1, 1},   {1, 2},  {1, 3},   {2, 2},   {2, 3},    {1, 7},    {3, 4},
                               {4, 4},   {1, 17}, {6, 10},  {8, 8},   {1, 97},   {10, 10},  {64, 64},
                               {21, 33}, {5, 73}, {65, 67}, {1, 997}, {70, 100}, {100, 100}};

static void cells_columns_and_rows_hold_one_point_each(void **state) {
  (void)state;
  static double points[10000 * 4];
  for (size_t k = 0; k < 2; k++)
    for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
      const size_t columns = shapes[s].columns, rows = shapes[s].rows, n = columns * rows;
      points_of(multi_jittered[k], n, 4, s, points);
      for (size_t pair = 0; pair < 4; pair += 2) {
        unsigned char seen[10000] = {0};
        for (size_t i = 0; i < n; i++) {
          const double *point = points + 4 * i + pair;
          assert_int_equal(seen[cell_of(point[0], columns) * rows + cell_of(point[1], rows)]++, 0);
        }
        check_strata(points, n, 4, pair, n);
        check_strata(points, n, 4, pair + 1, n);
      }
    }
}

static void a_million_points_keep_their_cells(void **state) {
  (void)state;
  enum { SIDE = 1024, N = SIDE * SIDE };
  double *points = malloc((size_t)N * 2 * sizeof *points);
  unsigned char *seen = malloc(N);
  for (size_t k = 0; k < 2; k++) {
    memset(seen, 0, N);
    points_of(multi_jittered[k], N, 2, UINT64_MAX, points);
    for (size_t i = 0; i < N; i++)
      assert_int_equal(seen[cell_of(points[2 * i], SIDE) * SIDE + cell_of(points[2 * i + 1], SIDE)]++, 0);
    check_strata(points, N, 2, 0, N);
    check_strata(points, N, 2, 1, N);
  }
  free(points);
  free(seen);
}

/* Whether the points of each row of cells have the same sub-column, those of each column the same sub-row. */
static int is_correlated(const double *points, size_t columns, size_t rows) {
  const size_t n = columns * rows;
  size_t sub_column[100], sub_row[100];
  memset(sub_column, 0xff, sizeof sub_column);
  memset(sub_row, 0xff, sizeof sub_row);
  for (size_t i = 0; i < n; i++) {
    const size_t x = cell_of(points[2 * i], n), y = cell_of(points[2 * i + 1], n);
    const size_t row = y / columns, column = x / rows;
    if (sub_column[row] == SIZE_MAX) sub_column[row] = x % rows;
    if (sub_row[column] == SIZE_MAX) sub_row[column] = y % columns;
    if (sub_column[row] != x % rows || sub_row[column] != y % columns) return 0;
  }
  return 1;
}

static void only_the_correlated_pattern_shuffles_alike(void **state) {
  (void)state;
  static double points[7000 * 2];
  for (size_t s = 0; s < sizeof shapes / sizeof *shapes; s++) {
    const size_t n = shapes[s].columns * shapes[s].rows;
    if (shapes[s].columns < 4 || n > 7000) continue;
    points_of("correlated-multi-jittered", n, 2, 4, points);
    assert_true(is_correlated(points, shapes[s].columns, shapes[s].rows));
    points_of("multi-jittered", n, 2, 4, points);
    assert_false(is_correlated(points, shapes[s].columns, shapes[s].rows));
  }
}

/* Four points: two columns and two rows, each shuffled in one of two ways by its own, make 16 patterns; shuffled alike,
 * 4. */
static void all_shuffles_of_four_points_are_equally_likely(void **state) {
  (void)state;
  enum { DRAWS = 16000 };
  static uint64_t codes[DRAWS];
  for (size_t k = 0; k < 2; k++) {
    asc_sampler *sampler = make(multi_jittered[k], 4, 2, 11);
    for (int32_t pixel = 0; pixel < DRAWS; pixel++) {
      double points[4 * 2];
      fill(sampler, pixel, -pixel, 0, 4, 0, 2, points);
      codes[pixel] = 0;
      for (size_t i = 0; i < 4; i++)
        codes[pixel] |= (uint64_t)cell_of(points[2 * i], 4) << 2 * cell_of(points[2 * i + 1], 4);
    }
    asc_sampler_destroy(sampler);
    check_equally_likely(codes, DRAWS, k == 0 ? 16 : 4);
  }
}

static void what_has_no_design_is_refused(void **state) {
  (void)state;
  assert_refused("latin-square", 8, 3, ASC_UNSUPPORTED, "8 is not such a number: choose 1, 4, 9");
  assert_refused("latin-square", 257 * 257, 3, ASC_UNSUPPORTED, "65536");
  assert_refused("latin-square", ((uint64_t)1 << 32) + 1, 2, ASC_UNSUPPORTED, "2^32");
  assert_refused("latin-square:centred=2", 4, 2, ASC_INVALID_VALUE, "centred");
  assert_refused("n-queens", 2, 2, ASC_UNSUPPORTED, "no solution for 2: choose 1, or 4 and more");
  assert_refused("n-queens", 3, 5, ASC_UNSUPPORTED, "no solution for 3");
  assert_refused("n-queens", (1 << 20) + 1, 2, ASC_UNSUPPORTED, "2^20");
  assert_refused("n-queens:solution=none", 4, 2, ASC_INVALID_VALUE, "search|construction");
  for (size_t k = 0; k < 2; k++) assert_refused(multi_jittered[k], ((uint64_t)1 << 32) + 1, 2, ASC_UNSUPPORTED, "2^32");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(one_symbol_is_once_in_each_row_and_column),
      cmocka_unit_test(each_two_of_row_column_and_symbol_are_together_once),
      cmocka_unit_test(all_latin_squares_are_equally_likely),
      cmocka_unit_test(both_classes_of_order_five_have_their_share),
      cmocka_unit_test(queens_do_not_attack),
      cmocka_unit_test(every_solution_is_reached),
      cmocka_unit_test(boards_have_fewer_queens_in_their_corners),
      cmocka_unit_test(centred_points_are_at_centres),
      cmocka_unit_test(cells_columns_and_rows_hold_one_point_each),
      cmocka_unit_test(a_million_points_keep_their_cells),
      cmocka_unit_test(only_the_correlated_pattern_shuffles_alike),
      cmocka_unit_test(all_shuffles_of_four_points_are_equally_likely),
      cmocka_unit_test(what_has_no_design_is_refused),
  };
  return cmocka_run_group_tests_name("block designs", tests, NULL, NULL);
}

/* The patterns of multisampling hardware: standard-msaa, sgi-8x8. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "stream.h"

#include "sampler_tools.h"

#define MOST 16

/* Offsets from the pixel's centre in sixteenths, y down, as Direct3D writes them (functional specification 11.3,
 * 19.2.4); the library's table has Vulkan's form. */
static const int direct3d_offsets[][2] = {
    {0, 0},                                                                                       /* 1 */
    {4, 4},   {-4, -4},                                                                           /* 2 */
    {-2, -6}, {6, -2},  {-6, 2}, {2, 6},                                                          /* 4 */
    {1, -3},  {-1, 3},  {5, 1},  {-3, -5}, {-5, 5},  {-7, -1}, {3, 7}, {7, -7},                   /* 8 */
    {1, 1},   {-1, -3}, {-3, 2}, {4, -1},  {-5, -2}, {2, 5},   {5, 3}, {3, -5}, {-2, 6}, {0, -7}, /* 16 */
    {-4, -6}, {-6, 4},  {-8, 0}, {7, -4},  {6, 7},   {-7, -8},
};

static void standard_locations_are_direct3ds(void **state) {
  (void)state;
  const int(*expected)[2] = direct3d_offsets;
  for (uint32_t n = 1; n <= MOST; n *= 2) {
    double points[2 * MOST];
    points_of("standard-msaa", n, 2, 0, points);
    for (uint32_t i = 0; i < n; i++, expected++)
      for (int axis = 0; axis < 2; axis++)
        assert_true(points[2 * i + (uint32_t)axis] == (8 + (*expected)[axis]) / 16.0);
  }
}

/* Each of n columns and n rows has one point; that of 1 too. */
static void standard_locations_are_rooks(void **state) {
  (void)state;
  for (uint32_t n = 1; n <= MOST; n *= 2) {
    double points[2 * MOST];
    points_of("standard-msaa", n, 2, 0, points);
    for (uint32_t axis = 0; axis < 2; axis++) {
      unsigned seen = 0;
      for (uint32_t i = 0; i < n; i++) seen |= 1u << (unsigned)(points[2 * i + axis] * n);
      assert_int_equal(seen, (1u << n) - 1);
    }
  }
}

/* --- the edge discrepancy: the root of the mean square, over random lines, of share of points less area --- */

/* The integral over [0, a] x [0, b] of the distance to the origin. */
static double corner(double a, double b) {
  return a * b * hypot(a, b) / 3 + (a * a * a * asinh(b / a) + b * b * b * asinh(a / b)) / 6;
}

typedef struct cell_table {
  double mean_distance[64]; /* from the cell's centre to the square's points */
  double distance[64][64];
} cell_table;

static void measure_cells(cell_table *table) {
  for (int i = 0; i < 64; i++) {
    const double x = (i % 8 + 0.5) / 8, y = (i / 8 + 0.5) / 8;
    table->mean_distance[i] = corner(x, y) + corner(1 - x, y) + corner(x, 1 - y) + corner(1 - x, 1 - y);
    for (int k = 0; k < 64; k++) table->distance[i][k] = hypot((i % 8 - k % 8) / 8.0, (i / 8 - k / 8) / 8.0);
  }
}

/* Its square by Crofton's formula, as make_sgi_positions.py derives it. */
static double mean_square(const cell_table *table, const int *cells, int n) {
  double own = 0, between = 0;
  for (int i = 0; i < n; i++) {
    own += table->mean_distance[cells[i]];
    for (int k = 0; k < i; k++) between += 2 * table->distance[cells[i]][cells[k]];
  }
  return (2 * own / n - between / (n * n) - (2 + sqrt(2) + 5 * asinh(1)) / 15) / 4;
}

static void sgi_cells(int n, int *cells) {
  double points[2 * 8];
  points_of("sgi-8x8", (uint64_t)n, 2, 0, points);
  for (int i = 0; i < n; i++) {
    const double x = points[2 * i] * 8 - 0.5, y = points[2 * i + 1] * 8 - 0.5;
    assert_true(x == floor(x) && y == floor(y)); /* centres of cells */
    cells[i] = (int)(8 * y + x);
    for (int k = 0; k < i; k++) assert_int_not_equal(cells[i], cells[k]);
  }
}

static int next_set(int *cells, int n) {
  int moved = n - 1;
  while (moved >= 0 && cells[moved] == 64 - n + moved) moved--;
  if (moved < 0) return 0;
  cells[moved]++;
  for (int i = moved + 1; i < n; i++) cells[i] = cells[i - 1] + 1;
  return 1;
}

static void no_set_of_1_2_or_4_is_better(void **state) {
  (void)state;
  cell_table table;
  measure_cells(&table);
  for (int n = 1; n <= 4; n *= 2) {
    int best[8], cells[8] = {0, 1, 2, 3};
    sgi_cells(n, best);
    const double least = mean_square(&table, best, n);
    do assert_true(mean_square(&table, cells, n) > least - 1e-12); /* equal but for the roundings of mirror images */
    while (next_set(cells, n));
  }
}

/* All 4.4e9 sets of 8 are the search's; here those that differ in one or two cells. */
static void no_exchange_betters_the_set_of_8(void **state) {
  (void)state;
  cell_table table;
  measure_cells(&table);
  int best[8];
  sgi_cells(8, best);
  const double least = mean_square(&table, best, 8);
  for (int i = 0; i < 8; i++)
    for (int k = 0; k < i; k++)
      for (int there = 0; there < 64; there++)
        for (int elsewhere = 0; elsewhere < 64; elsewhere++) {
          int cells[8], repeated = there == elsewhere;
          memcpy(cells, best, sizeof cells);
          cells[i] = there;
          cells[k] = elsewhere;
          for (int other = 0; other < 8; other++)
            if (other != i && other != k) repeated |= best[other] == there || best[other] == elsewhere;
          if (!repeated) assert_true(mean_square(&table, cells, 8) > least - 1e-12);
        }
}

/* The part of the unit square where a x + b y < c: the square's polygon cut by the line. */
static double area_below(double a, double b, double c) {
  static const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  double kept[8][2];
  int count = 0;
  for (int i = 0; i < 4; i++) {
    const double *from = corners[i], *to = corners[(i + 1) % 4];
    const double before = a * from[0] + b * from[1] - c, after = a * to[0] + b * to[1] - c;
    if (before < 0) memcpy(kept[count++], from, sizeof *kept);
    if ((before < 0) != (after < 0)) {
      const double at = before / (before - after);
      for (int axis = 0; axis < 2; axis++) kept[count][axis] = from[axis] + at * (to[axis] - from[axis]);
      count++;
    }
  }
  double twice = 0;
  for (int i = 0; i < count; i++) {
    const double *from = kept[i], *to = kept[(i + 1) % count];
    twice += from[0] * to[1] - to[0] * from[1];
  }
  return twice / 2;
}

/* The closed form against 200,000 drawn lines: direction and offset uniform, those that miss the square left out. Five
 * standard errors; four tests, so 2e-6 in all. */
static void the_measure_is_that_of_random_edges(void **state) {
  (void)state;
  cell_table table;
  measure_cells(&table);
  asc_stream stream;
  asc_stream_begin(&stream, asc_stream_key(4, 0, 0), 0);
  for (int n = 1; n <= 8; n *= 2) {
    int cells[8], lines = 0;
    double sum = 0, squares = 0;
    sgi_cells(n, cells);
    while (lines < 200000) {
      const double angle = 3.14159265358979324 * asc_stream_unit(&stream);
      const double a = cos(angle), b = sin(angle);
      const double c = (a + b) / 2 + (asc_stream_unit(&stream) - 0.5) * sqrt(2);
      const double area = area_below(a, b, c);
      if (area <= 0 || area >= 1) continue;
      int below = 0;
      for (int i = 0; i < n; i++) below += a * (cells[i] % 8 + 0.5) / 8 + b * (cells[i] / 8 + 0.5) / 8 < c;
      const double square = ((double)below / n - area) * ((double)below / n - area);
      sum += square;
      squares += square * square;
      lines++;
    }
    const double mean = sum / lines, error = sqrt((squares / lines - mean * mean) / lines);
    if (fabs(mean - mean_square(&table, cells, n)) > 5 * error) fail_msg("%d points: %g +- %g", n, mean, error);
  }
}

static void other_counts_and_dimensions_are_refused(void **state) {
  (void)state;
  const char *const specs[] = {"sgi-8x8", "standard-msaa"};
  const uint64_t counts[] = {3, 5, 7, 32, 1u << 20, (uint64_t)1 << 53};
  for (int s = 0; s < 2; s++) {
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
      assert_int_equal(created(specs[s], counts[i], 2), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 4, 1), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 4, 3), ASC_UNSUPPORTED);
    assert_int_equal(created(specs[s], 4, 1024), ASC_UNSUPPORTED);
    asc_sampler *sampler = make(specs[s], 8, 2, UINT64_MAX);
    const asc_range past = {0, 0, 8, 1, 0, 2};
    double point[2];
    assert_int_equal(asc_sampler_fill(sampler, &past, point), ASC_UNSUPPORTED);
    asc_sampler_destroy(sampler);
  }
  assert_int_equal(created("sgi-8x8", 16, 2), ASC_UNSUPPORTED);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(standard_locations_are_direct3ds),    cmocka_unit_test(standard_locations_are_rooks),
      cmocka_unit_test(no_set_of_1_2_or_4_is_better),        cmocka_unit_test(no_exchange_betters_the_set_of_8),
      cmocka_unit_test(the_measure_is_that_of_random_edges), cmocka_unit_test(other_counts_and_dimensions_are_refused),
  };
  return cmocka_run_group_tests_name("hardware", tests, NULL, NULL);
}

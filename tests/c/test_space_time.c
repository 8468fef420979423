/* The patterns of space and time: cook, pan-diagonal, mitchell-spacetime. */
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

#define LARGEST 1024

/* The slots of time of all cells of a pixel, by rows; it is checked that each point lies in its cell, and that each
 * slot has one point. To be freed. */
static uint32_t *slots_of(const char *spec, uint32_t side, uint64_t seed, int32_t x, int32_t y) {
  const size_t n = (size_t)side * side;
  double *points = malloc(n * 3 * sizeof *points);
  uint32_t *slots = malloc(n * sizeof *slots);
  uint8_t *seen = calloc(n, 1);
  assert_true(points && slots && seen);
  asc_sampler *sampler = make(spec, n, 3, seed);
  fill(sampler, x, y, 0, n, 0, 3, points);
  asc_sampler_destroy(sampler);
  for (size_t i = 0; i < n; i++) {
    assert_int_equal((size_t)(points[3 * i] * side), i % side);
    assert_int_equal((size_t)(points[3 * i + 1] * side), i / side);
    slots[i] = (uint32_t)(points[3 * i + 2] * (double)n);
    assert_int_equal(seen[slots[i]]++, 0);
  }
  free(points);
  free(seen);
  return slots;
}

/* The lecture's tables (Hanrahan 2000, CS348B, "Space-time patterns"). */
static void tables_of_the_lecture_are_kept(void **state) {
  (void)state;
  const struct {
    const char *spec;
    int slots[16];
  } tables[] = {
      {"cook:centred=1", {6, 10, 2, 13, 3, 14, 12, 8, 15, 0, 7, 11, 5, 9, 4, 1}},
      {"pan-diagonal:centred=1", {15, 8, 5, 2, 4, 3, 14, 9, 10, 13, 0, 7, 1, 6, 11, 12}},
  };
  for (int t = 0; t < 2; t++) {
    double points[16 * 3];
    points_of(tables[t].spec, 16, 3, 77, points);
    for (int i = 0; i < 16; i++) {
      assert_true(points[3 * i] == (i % 4 + 0.5) / 4);
      assert_true(points[3 * i + 1] == ((double)(i / 4) + 0.5) / 4);
      assert_true(points[3 * i + 2] == (tables[t].slots[i] + 0.5) / 16);
    }
  }
}

/* Rows, columns, and diagonals both ways, broken ones too. */
static void check_sums(const uint32_t *slots, uint32_t side) {
  const uint64_t n = (uint64_t)side * side, constant = side * (n - 1) / 2;
  for (uint32_t line = 0; line < side; line++) {
    uint64_t sums[4] = {0};
    for (uint32_t i = 0; i < side; i++) {
      sums[0] += slots[(size_t)line * side + i];
      sums[1] += slots[(size_t)i * side + line];
      sums[2] += slots[(size_t)i * side + (line + i) % side];
      sums[3] += slots[(size_t)i * side + (line + side - i) % side];
    }
    for (int s = 0; s < 4; s++)
      if (sums[s] != constant)
        fail_msg("order %u, line %u, direction %d: %llu", side, line, s, (unsigned long long)sums[s]);
  }
}

static int has_square(uint32_t order) { return order == 1 || (order > 3 && order % 4 != 2); }

/* Every order up to 64, and larger ones with several factors 3, 5, 7 and 2, in the table and in pixels, moved. */
static void pan_diagonal_sums_are_magic(void **state) {
  (void)state;
  const uint32_t larger[] = {81, 105, 128, 225, 243, 315, 625, 1023, LARGEST};
  for (uint32_t order = 1; order <= 64 + sizeof larger / sizeof *larger; order++) {
    const uint32_t side = order <= 64 ? order : larger[order - 65];
    if (!has_square(side)) {
      assert_int_equal(created("pan-diagonal", (uint64_t)side * side, 3), ASC_UNSUPPORTED);
      continue;
    }
    uint32_t *slots = slots_of("pan-diagonal:centred=1", side, 0, 0, 0);
    check_sums(slots, side);
    free(slots);
    for (int32_t x = 0; x < 3; x++) {
      slots = slots_of("pan-diagonal", side, UINT64_MAX, x, INT32_MIN);
      check_sums(slots, side);
      free(slots);
    }
  }
}

/* Pixels have Cook's table moved around the border, mirrored or run backward: times of cells that are a step apart keep
 * their set of distances. */
static void cooks_distances_are_kept_in_every_pixel(void **state) {
  (void)state;
  unsigned expected[16] = {0};
  for (int32_t pixel = -1; pixel < 200; pixel++) {
    uint32_t *slots = slots_of(pixel < 0 ? "cook:centred=1" : "cook", 4, 3, pixel, 7 * pixel);
    unsigned found[16] = {0};
    for (int i = 0; i < 16; i++) {
      const int right = i / 4 * 4 + (i + 1) % 4, below = (i + 4) % 16;
      found[abs((int)slots[i] - (int)slots[right])]++;
      found[abs((int)slots[i] - (int)slots[below])]++;
    }
    free(slots);
    if (pixel < 0) memcpy(expected, found, sizeof found);
    assert_memory_equal(found, expected, sizeof found);
  }
}

#define TABLES 256 /* 16 shifts, 8 symmetries of the square, 2 directions of time: none of Cook's is another */

/* Pixels have all 256, equally often: chi-squared over 16,384 pixels, 255 degrees of freedom, at 1e-6. */
static void pixels_have_all_motions_of_cooks_table(void **state) {
  (void)state;
  uint64_t tables[TABLES] = {0};
  unsigned counts[TABLES] = {0};
  size_t found = 0;
  asc_sampler *sampler = make("cook", 16, 3, 21);
  for (int32_t pixel = 0; pixel < 64 * TABLES; pixel++) {
    double points[16 * 3];
    fill(sampler, pixel % 128, pixel / 128, 0, 16, 0, 3, points);
    uint64_t table = 0;
    for (int i = 0; i < 16; i++) table = table << 4 | (uint64_t)(points[3 * i + 2] * 16);
    size_t at = 0;
    while (at < found && tables[at] != table) at++;
    assert_true(at < TABLES);
    if (at == found) tables[found++] = table;
    counts[at]++;
  }
  asc_sampler_destroy(sampler);
  double sum = 0.0;
  for (size_t i = 0; i < TABLES; i++) sum += (counts[i] - 64.0) * (counts[i] - 64.0) / 64.0;
  assert_int_equal(found, TABLES);
  assert_true(sum < 377.1); /* SciPy's quantile */
}

/* Over 4,096 pixels every cell has every slot equally often: chi-squared, 240 degrees of freedom (16 cells by 15; each
 * pixel's 16 slots differ, so the cells depend on each other, and the sum's variance is 16/15 of the independent
 * one's). Normal limit at 5.5 standard deviations, skewed by 0.2: below 1e-6. */
static void every_cell_has_every_slot_equally_often(void **state) {
  (void)state;
  const char *const specs[] = {"cook", "pan-diagonal", "mitchell-spacetime"};
  for (int s = 0; s < 3; s++) {
    unsigned counts[16][16] = {{0}};
    for (int32_t pixel = 0; pixel < 4096; pixel++) {
      uint32_t *slots = slots_of(specs[s], 4, 5, pixel % 64, -(pixel / 64));
      for (int i = 0; i < 16; i++) counts[i][slots[i]]++;
      free(slots);
    }
    double sum = 0.0;
    for (int i = 0; i < 16; i++)
      for (int slot = 0; slot < 16; slot++) sum += (counts[i][slot] - 256.0) * (counts[i][slot] - 256.0) / 256.0;
    if (!(fabs(sum - 240.0) < 5.5 * sqrt(2 * 240.0 * 16 / 15))) fail_msg("%s: chi-squared %g", specs[s], sum);
  }
}

/* Integrands of space and time together: the mean over 4,096 pixels of each estimate lies within 5.5 standard errors of
 * the integral (4e-8). Without the motion of the table from pixel to pixel it would not. */
static void estimates_over_space_and_time_are_unbiased(void **state) {
  (void)state;
  const char *const specs[] = {"cook", "pan-diagonal", "mitchell-spacetime"};
  for (int s = 0; s < 3; s++) {
    asc_sampler *sampler = make(specs[s], 16, 3, 11);
    double sums[2] = {0}, squares[2] = {0};
    for (int32_t pixel = 0; pixel < 4096; pixel++) {
      double points[16 * 3], means[2] = {0};
      fill(sampler, pixel, 1 << 30, 0, 16, 0, 3, points);
      for (int i = 0; i < 16; i++) {
        const double x = points[3 * i], y = points[3 * i + 1], t = points[3 * i + 2];
        means[0] += (x * x * t - 1.0 / 6.0) / 16;
        means[1] += ((x + y < 2 * t ? 1.0 : 0.0) - 0.5) / 16; /* an edge that moves over the square */
      }
      for (int f = 0; f < 2; f++) {
        sums[f] += means[f];
        squares[f] += means[f] * means[f];
      }
    }
    for (int f = 0; f < 2; f++) {
      const double mean = sums[f] / 4096, error = sqrt((squares[f] / 4096 - mean * mean) / 4096);
      if (!(fabs(mean) < 5.5 * error)) fail_msg("%s, integrand %d: off by %g +- %g", specs[s], f, mean, error);
    }
    asc_sampler_destroy(sampler);
  }
}

/* Distances in time around the border, as shares of it. */
typedef struct spread {
  double beside;     /* mean over pairs that share a side */
  double touching;   /* and over those that share a corner too */
  double least;      /* the least over pairs that share a side */
  double unevenness; /* of 3 x 3 cells' times: 9 times the sum of squared gaps between them, 1 if even, in the mean */
} spread;

static double apart(const uint32_t *slots, uint32_t side, uint32_t cell, uint32_t right, uint32_t down) {
  const uint32_t n = side * side, there = (cell / side + down) % side * side + (cell % side + right) % side;
  const uint32_t difference = slots[cell] > slots[there] ? slots[cell] - slots[there] : slots[there] - slots[cell];
  return (double)(difference < n - difference ? difference : n - difference) / n;
}

static int by_slot(const void *a, const void *b) {
  const uint32_t one = *(const uint32_t *)a, other = *(const uint32_t *)b;
  return (one > other) - (one < other);
}

static double unevenness_at(const uint32_t *slots, uint32_t side, uint32_t cell) {
  uint32_t times[9];
  for (uint32_t i = 0; i < 9; i++) times[i] = slots[(cell / side + i / 3) % side * side + (cell % side + i % 3) % side];
  qsort(times, 9, sizeof *times, by_slot);
  double sum = 0.0;
  for (int i = 0; i < 9; i++) {
    const double gap = (double)(i < 8 ? times[i + 1] - times[i] : times[0] + side * side - times[8]) / (side * side);
    sum += 9 * gap * gap;
  }
  return sum;
}

static spread measure(const uint32_t *slots, uint32_t side) {
  const uint32_t n = side * side;
  spread found = {0, 0, 1, 0};
  for (uint32_t cell = 0; cell < n; cell++) {
    const double right = apart(slots, side, cell, 1, 0), down = apart(slots, side, cell, 0, 1);
    found.beside += (right + down) / (2 * n);
    found.touching += (right + down + apart(slots, side, cell, 1, 1) + apart(slots, side, cell, side - 1, 1)) / (4 * n);
    found.least = fmin(found.least, fmin(right, down));
    found.unevenness += unevenness_at(slots, side, cell) / n;
  }
  return found;
}

/* For k = 4, 8, 16, 32. In random assignments two cells are (1/4) N/(N - 1) apart in the mean, 0.267, 0.254, 0.251,
 * 0.250; the closest neighbours some 1/N; unevenness is 1.35, 1.69, 1.77, 1.79 (gaps of 9 of N places on a circle).
 * Measured here, over the seeds: neighbours by the side 0.330, 0.314, 0.307, 0.303 apart, with corners 0.298, 0.285,
 * 0.282, 0.281; the closest of all 0.125, 0.078, 0.059, 0.058; unevenness 1.29, 1.24, 1.26, 1.28. The limits lie about
 * halfway; means over seeds vary by less than a tenth of that. */
static void neighbours_in_space_are_far_apart_in_time(void **state) {
  (void)state;
  const uint32_t sides[] = {4, 8, 16, 32};
  const double random_beside[] = {0.267, 0.254, 0.251, 0.250}, random_uneven[] = {1.35, 1.69, 1.77, 1.79};
  const double least[] = {0.09, 0.05, 0.04, 0.035}, more_even[] = {0.02, 0.25, 0.25, 0.25};
  for (int k = 0; k < 4; k++) {
    spread mean = {0, 0, 1, 0};
    const uint32_t seeds = sides[k] < 32 ? 32 : 4;
    for (uint32_t seed = 0; seed < seeds; seed++) {
      uint32_t *slots = slots_of("mitchell-spacetime", sides[k], seed, 0, 0);
      const spread one = measure(slots, sides[k]);
      free(slots);
      mean.beside += one.beside / seeds;
      mean.touching += one.touching / seeds;
      mean.least = fmin(mean.least, one.least);
      mean.unevenness += one.unevenness / seeds;
    }
    assert_true(mean.beside > random_beside[k] + 0.03);
    assert_true(mean.touching > random_beside[k] + 0.016);
    assert_true(mean.least > least[k]);
    assert_true(mean.unevenness < random_uneven[k] - more_even[k]);
  }
}

/* The table is the seed's: pixels of one have the same distances, other seeds others. */
static void the_optimised_table_is_the_seeds(void **state) {
  (void)state;
  spread found[3];
  const uint64_t seeds[] = {1, 1, 2};
  for (int i = 0; i < 3; i++) {
    uint32_t *slots = slots_of("mitchell-spacetime", 8, seeds[i], 50 * i, -i);
    found[i] = measure(slots, 8);
    free(slots);
  }
  assert_true(fabs(found[0].unevenness - found[1].unevenness) < 1e-12); /* sums of 64 in another order */
  assert_true(fabs(found[0].unevenness - found[2].unevenness) > 1e-6);
}

/* Few cells, whose neighbours around the border are each other or the cell itself. */
static void small_patterns_are_made(void **state) {
  (void)state;
  for (uint32_t side = 1; side <= 5; side++) {
    free(slots_of("mitchell-spacetime", side, 0, INT32_MAX, INT32_MAX));
    free(slots_of("mitchell-spacetime:centred=1", side, UINT64_MAX, 0, 0));
  }
  free(slots_of("pan-diagonal", 1, 0, 0, 0));
}

static void what_there_is_not_is_refused(void **state) {
  (void)state;
  const char *const specs[] = {"cook", "pan-diagonal", "mitchell-spacetime"};
  for (int s = 0; s < 3; s++) {
    const uint32_t dimensions[] = {1, 2, 4, 1024};
    for (int d = 0; d < 4; d++) assert_int_equal(created(specs[s], 16, dimensions[d]), ASC_UNSUPPORTED);
    const uint64_t counts[] = {2, 3, 5, 7, 17, 104729, (uint64_t)1 << 53};
    for (int c = 0; c < 7; c++) assert_int_equal(created(specs[s], counts[c], 3), ASC_UNSUPPORTED);
    asc_sampler *sampler = make(specs[s], 16, 3, 0);
    const asc_range past = {0, 0, 15, 2, 0, 3};
    double points[6];
    assert_int_equal(asc_sampler_fill(sampler, &past, points), ASC_UNSUPPORTED);
    asc_sampler_destroy(sampler);
  }
  assert_int_equal(created("cook", 25, 3), ASC_UNSUPPORTED);
  assert_int_equal(created("mitchell-spacetime", 65536, 2), ASC_UNSUPPORTED);
  assert_int_equal(created("mitchell-spacetime", 257 * 257, 3), ASC_UNSUPPORTED);
  assert_int_equal(created("mitchell-spacetime", 1 << 20, 3), ASC_UNSUPPORTED);
  assert_int_equal(created("pan-diagonal", ((uint64_t)1 << 24 | 1) * ((uint64_t)1 << 24 | 1), 3), ASC_UNSUPPORTED);
}

static void refusals_name_the_nearest_orders(void **state) {
  (void)state;
  const struct {
    uint64_t samples;
    const char *nearest;
  } refused[] = {{4, "1 and 16"}, {9, "1 and 16"}, {36, "25 and 49"}, {50, "49 and 64"}, {100, "81 and 121"}};
  for (int i = 0; i < 5; i++) {
    const asc_sampler_desc desc = {sizeof desc, "pan-diagonal", refused[i].samples, 3, 0};
    asc_sampler *sampler = NULL;
    asc_error error = {{0}};
    assert_int_equal(asc_sampler_create(&desc, &sampler, &error), ASC_UNSUPPORTED);
    if (!strstr(error.text, refused[i].nearest)) fail_msg("%s", error.text);
  }
}

/* Order 2^24, 2^48 points: each in its cell, and inside a slot of its own although that takes 48 of the 53 bits. */
static void the_largest_order_keeps_to_its_cells(void **state) {
  (void)state;
  const uint64_t side = (uint64_t)1 << 24, n = side * side;
  asc_sampler *sampler = make("pan-diagonal", n, 3, 0);
  const uint64_t firsts[] = {0, n / 3, n - 64};
  for (int i = 0; i < 3; i++) {
    double points[64 * 3];
    fill(sampler, -1, -1, firsts[i], 64, 0, 3, points);
    for (uint64_t k = 0; k < 64; k++) {
      assert_int_equal((uint64_t)(points[3 * k] * 0x1p24), (firsts[i] + k) % side);
      assert_int_equal((uint64_t)(points[3 * k + 1] * 0x1p24), (firsts[i] + k) / side);
      const double slot = points[3 * k + 2] * 0x1p48; /* exact; on a border if it had been rounded */
      assert_true(slot > floor(slot));
      for (uint64_t other = 0; other < k; other++) assert_true(floor(slot) != floor(points[3 * other + 2] * 0x1p48));
    }
  }
  asc_sampler_destroy(sampler);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(tables_of_the_lecture_are_kept),
      cmocka_unit_test(pan_diagonal_sums_are_magic),
      cmocka_unit_test(cooks_distances_are_kept_in_every_pixel),
      cmocka_unit_test(pixels_have_all_motions_of_cooks_table),
      cmocka_unit_test(every_cell_has_every_slot_equally_often),
      cmocka_unit_test(estimates_over_space_and_time_are_unbiased),
      cmocka_unit_test(neighbours_in_space_are_far_apart_in_time),
      cmocka_unit_test(the_optimised_table_is_the_seeds),
      cmocka_unit_test(small_patterns_are_made),
      cmocka_unit_test(what_there_is_not_is_refused),
      cmocka_unit_test(refusals_name_the_nearest_orders),
      cmocka_unit_test(the_largest_order_keeps_to_its_cells),
  };
  return cmocka_run_group_tests_name("space_time", tests, NULL, NULL);
}

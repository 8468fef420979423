/* What holds of every registered sampler: sampler_cases.h lists them. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "sampler_cases.h"
#include "sampler_tools.h"
#include "threads_alone.h"

static asc_sampler *make_case(const sampler_case *one, uint64_t seed) {
  return make(one->spec, one->samples, one->dimensions, seed);
}

static void fill_case(const sampler_case *one, const asc_sampler *sampler, int32_t x, int32_t y, double *points) {
  fill(sampler, x, y, 0, one->samples, 0, one->dimensions, points);
}

static void every_registered_sampler_is_tested(void **state) {
  (void)state;
  for (size_t i = 0; i < asc_sampler_count(); i++) {
    asc_sampler_info info;
    assert_int_equal(asc_sampler_describe(i, &info), ASC_OK);
    int found = 0;
    for (size_t k = 0; k < CASES; k++) found |= strcmp(cases[k].spec, info.name) == 0;
    if (!found) fail_msg("no test of %s", info.name);
    assert_non_null(info.title);
    assert_non_null(info.source);
  }
}

/* At the ends of seeds and pixels too. */
static void points_lie_below_one_as_float_too(void **state) {
  (void)state;
  const uint64_t seeds[] = {0, 5, UINT64_MAX};
  const int32_t places[][2] = {{0, 0}, {3, -4}, {INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN}};
  for (size_t k = 0; k < CASES; k++)
    for (size_t s = 0; s < 3; s++) {
      asc_sampler *sampler = make_case(&cases[k], seeds[s]);
      for (size_t p = 0; p < 4; p++) {
        double points[MOST_VALUES];
        fill_case(&cases[k], sampler, places[p][0], places[p][1], points);
        for (size_t i = 0; i < (size_t)cases[k].samples * cases[k].dimensions; i++) {
          assert_true(points[i] >= 0.0 && points[i] < 1.0);
          assert_true((float)points[i] < 1.0f);
        }
      }
      asc_sampler_destroy(sampler);
    }
}

static size_t without_common_divisor(size_t count) {
  size_t step = 29;
  while (count % step == 0) step += 2;
  return step;
}

static void pieces_out_of_order_equal_all_at_once(void **state) {
  (void)state;
  for (size_t k = 0; k < CASES; k++) {
    const size_t samples = cases[k].samples;
    const uint32_t dimensions = cases[k].dimensions;
    double all[MOST_VALUES];
    asc_sampler *sampler = make_case(&cases[k], 9);
    fill_case(&cases[k], sampler, 11, 7, all);
    const size_t stride = without_common_divisor(samples); /* a prime: every index once */
    for (size_t step = 0; step < samples; step++) {
      const size_t first = (step * stride) % samples;
      const size_t count = samples - first < 19 ? samples - first : 19;
      double piece[19 * 2];
      for (uint32_t dimension = 0; dimension < dimensions; dimension++) {
        fill(sampler, 11, 7, first, count, dimension, 1, piece);
        for (size_t i = 0; i < count; i++) assert_true(piece[i] == all[(first + i) * dimensions + dimension]);
      }
      if (dimensions < 3) continue;
      fill(sampler, 11, 7, first, 1, 1, 2, piece);
      assert_memory_equal(piece, all + first * dimensions + 1, 2 * sizeof *piece);
    }
    asc_sampler_destroy(sampler);
  }
}

/* Of whole pixels, of a part of their samples that begins and ends within a run of sixteen, and of one column. */
static void pixels_in_a_row_equal_one_by_one(void **state) {
  (void)state;
  enum { ROW = 19 }; /* more than are made together */
  static double row[ROW * MOST_VALUES], one[MOST_VALUES];
  for (size_t k = 0; k < CASES; k++) {
    const size_t samples = cases[k].samples;
    const uint32_t dimensions = cases[k].dimensions;
    asc_sampler *sampler = make_case(&cases[k], 5);
    const asc_range ranges[] = {{-3, 7, 0, samples, 0, dimensions},
                                {-3, 7, samples / 5, samples - samples / 3, 0, dimensions},
                                {-3, 7, samples / 5, samples - samples / 3, dimensions - 1, 1}};
    for (size_t r = 0; r < sizeof ranges / sizeof *ranges; r++) {
      asc_range range = ranges[r];
      const size_t values = range.sample_count * range.dimension_count;
      assert_int_equal(asc_sampler_fill_pixels(sampler, &range, ROW, row), ASC_OK);
      for (size_t pixel = 0; pixel < ROW; pixel++, range.pixel_x++) {
        assert_int_equal(asc_sampler_fill(sampler, &range, one), ASC_OK);
        assert_memory_equal(row + pixel * values, one, values * sizeof *one);
      }
    }
    asc_range range = ranges[0];
    assert_int_equal(asc_sampler_fill_pixels(sampler, &range, 0, row), ASC_OK);
    range.pixel_x = INT32_MAX;
    assert_int_equal(asc_sampler_fill_pixels(sampler, &range, 1, row), ASC_OK);
    assert_int_equal(asc_sampler_fill_pixels(sampler, &range, 2, row), ASC_INVALID_ARGUMENT);
    range.first_dimension = 1;
    assert_int_equal(asc_sampler_fill_pixels(sampler, &range, 1, row), ASC_INVALID_ARGUMENT);
    asc_sampler_destroy(sampler);
  }
}

#define THREADS 4
#define PIXELS 16

typedef struct thread_work {
  const sampler_case *one;
  const asc_sampler *sampler;
  double points[PIXELS][MOST_VALUES];
} thread_work;

static void *fill_pixels(void *argument) {
  thread_work *work = argument;
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    const asc_range range = {pixel, 0, 0, work->one->samples, 0, work->one->dimensions};
    (void)asc_sampler_fill(work->sampler, &range, work->points[pixel]);
  }
  return NULL;
}

static void threads_give_the_same_bits(void **state) {
  (void)state;
  for (size_t k = 0; k < CASES; k++) {
    asc_sampler *sampler = make_case(&cases[k], 1);
    static thread_work work[THREADS];
    pthread_t threads[THREADS];
    memset(work, 0, sizeof work);
    for (int t = 0; t < THREADS; t++) {
      work[t].one = &cases[k];
      work[t].sampler = sampler;
      assert_int_equal(pthread_create(&threads[t], NULL, fill_pixels, &work[t]), 0);
    }
    for (int t = 0; t < THREADS; t++) assert_int_equal(pthread_join(threads[t], NULL), 0);
    for (int t = 1; t < THREADS; t++) assert_memory_equal(work[0].points, work[t].points, sizeof work[0].points);
    asc_sampler_destroy(sampler);
  }
}

/* Randomised patterns differ from seed to seed and pixel to pixel, at 256 and 2^16 apart too; others never do. */
static void seeds_and_pixels_matter_where_they_should(void **state) {
  (void)state;
  const int32_t places[][2] = {{1, 0}, {0, 1}, {256, 0}, {0, 65536}, {-1, 0}};
  for (size_t k = 0; k < CASES; k++) {
    const size_t bytes = (size_t)cases[k].samples * cases[k].dimensions * sizeof(double);
    double base[MOST_VALUES], other[MOST_VALUES];
    asc_sampler *sampler = make_case(&cases[k], 1);
    const int randomised = (asc_sampler_traits(sampler) & ASC_TRAIT_RANDOMISED) != 0;
    fill_case(&cases[k], sampler, 0, 0, base);
    for (size_t p = 0; p < sizeof places / sizeof *places; p++) {
      fill_case(&cases[k], sampler, places[p][0], places[p][1], other);
      assert_int_equal(memcmp(base, other, bytes) != 0, randomised);
    }
    asc_sampler *seeded = make_case(&cases[k], (uint64_t)1 << 32 | 1);
    fill_case(&cases[k], seeded, 0, 0, other);
    assert_int_equal(memcmp(base, other, bytes) != 0, randomised);
    asc_sampler_destroy(seeded);
    asc_sampler_destroy(sampler);
  }
}

/* Weights add up to 1; without the trait they are 1/N. */
static void weights_sum_to_one(void **state) {
  (void)state;
  for (size_t k = 0; k < CASES; k++) {
    const size_t samples = cases[k].samples;
    double weights[MOST_VALUES], piece, sum = 0.0;
    asc_sampler *sampler = make_case(&cases[k], 1);
    const int weighted = (asc_sampler_traits(sampler) & ASC_TRAIT_WEIGHTED) != 0;
    assert_int_equal(asc_sampler_weights(sampler, 0, samples, weights), ASC_OK);
    for (size_t i = 0; i < samples; i++) {
      assert_true(weighted || weights[i] == 1.0 / (double)samples);
      assert_int_equal(asc_sampler_weights(sampler, i, 1, &piece), ASC_OK);
      assert_true(piece == weights[i]);
      sum += weights[i];
    }
    assert_true(fabs(sum - 1.0) < 1e-13);
    asc_sampler_destroy(sampler);
  }
}

/* --- uniformity
 * ------------------------------------------------------------------------------------------------------- One point of
 * each of many realisations, its index by turns: the points are independent whatever the pattern, so the counts are
 * multinomial. Each test has a significance of 1e-6, corrected for about 1,000 tests; seeds are fixed. */

#define REALISATIONS 4096
#define BINS 16
#define PAIR_BINS 8

/* Upper quantile 1 - 1e-6 of chi-squared with k degrees of freedom (Wilson and Hilferty 1931; within 1 % for these k).
 */
static double chi_squared_limit(double k) {
  const double z = 4.7534243; /* normal quantile of 1 - 1e-6 */
  const double spread = 2.0 / (9.0 * k);
  const double root = 1.0 - spread + z * sqrt(spread);
  return k * root * root * root;
}

static double chi_squared(const unsigned *counts, size_t bins, double expected) {
  double sum = 0.0;
  for (size_t i = 0; i < bins; i++) sum += ((double)counts[i] - expected) * ((double)counts[i] - expected) / expected;
  return sum;
}

/* Values of one point of each realisation, as bins: `drawn[r * dimensions + d]` in [0, 1). */
static void check_uniform(const sampler_case *one, const double *drawn) {
  const uint32_t dimensions = one->dimensions;
  for (uint32_t d = 0; d < dimensions; d++) {
    unsigned counts[BINS] = {0};
    for (size_t r = 0; r < REALISATIONS; r++) counts[(size_t)(drawn[r * dimensions + d] * BINS)]++;
    const double statistic = chi_squared(counts, BINS, (double)REALISATIONS / BINS);
    if (statistic > chi_squared_limit(BINS - 1))
      fail_msg("%s: dimension %u is not uniform: chi-squared %g", one->spec, d, statistic);
    for (uint32_t e = 0; e < d; e++) {
      if (e / 2 == d / 2 && one->biased_in_pairs) continue;
      unsigned both[PAIR_BINS * PAIR_BINS] = {0};
      for (size_t r = 0; r < REALISATIONS; r++) {
        const double *point = drawn + r * dimensions;
        both[(size_t)(point[d] * PAIR_BINS) * PAIR_BINS + (size_t)(point[e] * PAIR_BINS)]++;
      }
      const double joint = chi_squared(both, PAIR_BINS * PAIR_BINS, (double)REALISATIONS / (PAIR_BINS * PAIR_BINS));
      if (joint > chi_squared_limit(PAIR_BINS * PAIR_BINS - 1))
        fail_msg("%s: dimensions %u, %u are not uniform together: chi-squared %g", one->spec, e, d, joint);
    }
  }
}

/* Three integrands with known integrals: one smooth, one with a kink, one with a jump across the diagonal. */
#define INTEGRANDS 3

static void integrands(const double *point, uint32_t dimensions, double values[INTEGRANDS]) {
  const double x = point[0], y = dimensions > 1 ? point[1] : 0.25;
  values[0] = x * x * (dimensions > 1 ? 3.0 * y * y : 1.0) - 1.0 / 3.0;
  values[1] = fabs(x - 0.4) * (dimensions > 1 ? 2.0 * y : 1.0) - 0.26;
  values[2] = (x + y < 0.7 ? 1.0 : 0.0) - (dimensions > 1 ? 0.245 : 0.45);
}

/* The mean over realisations of each integrand's estimate lies within 5.5 standard errors of the integral: 4e-8. */
static void check_unbiased(const sampler_case *one, double means[REALISATIONS][INTEGRANDS]) {
  for (int f = 0; f < INTEGRANDS; f++) {
    double sum = 0.0, squares = 0.0;
    for (size_t r = 0; r < REALISATIONS; r++) sum += means[r][f];
    const double mean = sum / REALISATIONS;
    for (size_t r = 0; r < REALISATIONS; r++) squares += (means[r][f] - mean) * (means[r][f] - mean);
    const double error = sqrt(squares / (REALISATIONS - 1.0) / REALISATIONS);
    if (fabs(mean) > 5.5 * error) fail_msg("%s: integrand %d is off by %g +- %g", one->spec, f, mean, error);
  }
}

static void randomised_samplers_are_uniform_and_unbiased(void **state) {
  (void)state;
  static double drawn[REALISATIONS * 8], means[REALISATIONS][INTEGRANDS];
  for (size_t k = 0; k < CASES; k++) {
    const sampler_case *one = &cases[k];
    asc_sampler *sampler = make_case(one, 0);
    const int randomised = (asc_sampler_traits(sampler) & ASC_TRAIT_RANDOMISED) != 0;
    asc_sampler_destroy(sampler);
    if (!randomised || one->biased) continue;
    for (size_t r = 0; r < REALISATIONS; r++) {
      double points[MOST_VALUES];
      sampler = make_case(one, 7 + r / 64);
      fill_case(one, sampler, (int32_t)(r % 8), (int32_t)(r / 8 % 8), points);
      asc_sampler_destroy(sampler);
      memcpy(drawn + r * one->dimensions, points + r % one->samples * one->dimensions,
             one->dimensions * sizeof *points);
      for (int f = 0; f < INTEGRANDS; f++) means[r][f] = 0.0;
      for (size_t i = 0; i < one->samples; i++) {
        double values[INTEGRANDS];
        integrands(points + i * one->dimensions, one->dimensions, values);
        for (int f = 0; f < INTEGRANDS; f++) means[r][f] += values[f] / one->samples;
      }
    }
    check_uniform(one, drawn);
    if (!one->biased_in_pairs) check_unbiased(one, means);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_registered_sampler_is_tested),
      cmocka_unit_test(points_lie_below_one_as_float_too),
      cmocka_unit_test(pieces_out_of_order_equal_all_at_once),
      cmocka_unit_test(pixels_in_a_row_equal_one_by_one),
      cmocka_unit_test(threads_give_the_same_bits),
      cmocka_unit_test(seeds_and_pixels_matter_where_they_should),
      cmocka_unit_test(weights_sum_to_one),
      cmocka_unit_test(randomised_samplers_are_uniform_and_unbiased),
  };
  take_threads_alone();
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* Halton's sequence and Hammersley's points: radical inverses, plain against digits added up in long double, scrambled
 * by what the two scramblings promise. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "sampler_tools.h"

static const uint32_t primes[] = {2, 3, 5, 7, 11, 13, 17, 19};

/* The radical inverse, digit by digit: at most 53 terms, each rounded to 2^-64. */
static long double digits_reversed(uint32_t base, uint64_t index) {
  long double value = 0.0L, place = 1.0L;
  for (; index; index /= base) {
    place /= base;
    value += (long double)(index % base) * place;
  }
  return value;
}

static const uint64_t ends[] = {
    0, 1, 728, 729, 1023, 1024, (1u << 20) - 1, UINT32_MAX, (uint64_t)1 << 32, ((uint64_t)1 << 53) - 1};

/* Within the 2 ulp that radical_inverse.h states; one by one and as the last of a run of 20. */
static void plain_values_are_the_digits_reversed(void **state) {
  (void)state;
  asc_sampler *sampler = make("halton", 1, 1024, 0);
  for (size_t k = 0; k < sizeof ends / sizeof *ends; k++)
    for (uint32_t d = 0; d < 1024; d += d < 8 ? 1 : 1015) {
      const uint32_t base = d < 8 ? primes[d] : 8161; /* the 1024th prime */
      const double exact = (double)digits_reversed(base, ends[k]);
      const double expected = exact < 1.0 - 0x1p-25 ? exact : 1.0 - 0x1p-24; /* as sampler.h says */
      double value, run[20];
      if (d < 8 || d == 1023) {
        fill(sampler, 0, 0, ends[k], 1, d, 1, &value);
        if (fabs(value - expected) > 2 * 0x1p-52 * expected)
          fail_msg("base %u, index %llu: %.17g, not %.17g", base, (unsigned long long)ends[k], value, expected);
        if (ends[k] < 19) continue;
        fill(sampler, 0, 0, ends[k] - 19, 20, d, 1, run);
        assert_true(run[19] == value);
      }
    }
  asc_sampler_destroy(sampler);
}

static void runs_are_the_points_one_by_one(void **state) {
  (void)state;
  static double all[3000 * 16], one[16];
  const char *const specs[] = {"halton", "halton:scramble=shift", "hammersley", "hammersley:scramble=shift"};
  for (size_t k = 0; k < 4; k++) {
    asc_sampler *sampler = make(specs[k], 100000, 180, 3);
    fill(sampler, 1, 2, 50000, 3000, 164, 16, all); /* primes around 1,000, where digits come one by one */
    for (uint64_t i = 0; i < 3000; i++) {
      fill(sampler, 1, 2, 50000 + i, 1, 164, 16, one);
      assert_memory_equal(one, all + 16 * i, sizeof one);
    }
    asc_sampler_destroy(sampler);
  }
}

static void hammersley_is_i_over_n_and_halton(void **state) {
  (void)state;
  enum { N = 77 };
  double points[N * 5], halton[N * 4];
  points_of("hammersley", N, 5, 0, points);
  points_of("halton", N, 4, 0, halton);
  for (size_t i = 0; i < N; i++) {
    assert_true(points[5 * i] == (double)i / N);
    assert_memory_equal(points + 5 * i + 1, halton + 4 * i, 4 * sizeof *halton);
  }
  assert_int_equal(created("hammersley", 4, 1024), ASC_OK);
  assert_int_equal(created("hammersley", 4, 1025), ASC_UNSUPPORTED);
}

/* --- nets -----------------------------------------------------------------------------------------------------------
 */

/* Each interval of base^-m holds one of base^m points, for every such run of indices; the last run lies past 2^32. */
static void each_interval_holds_one_point(void **state) {
  (void)state;
  const char *const specs[] = {"halton", "halton:scramble=digit", "halton:scramble=owen"};
  for (size_t k = 0; k < 3; k++) {
    asc_sampler *sampler = make(specs[k], 1, 31, 5);
    for (uint32_t d = 0; d < 31; d += d < 7 ? 1 : 23) {
      const uint32_t base = d < 8 ? primes[d] : 127;
      uint64_t count = base;
      while (count * base <= 20000) count *= base;
      for (uint64_t run = 0; run < 4; run++) {
        static double points[20000];
        static unsigned char seen[20000];
        memset(seen, 0, sizeof seen);
        const uint64_t first = (run < 3 ? run : ((uint64_t)1 << 33) / count) * count;
        fill(sampler, 4, 9, first, (size_t)count, d, 1, points);
        /* Unscrambled values lie on the intervals' ends, to within rounding. */
        const double nudge = k == 0 ? 1e-9 : 0.0;
        for (uint64_t i = 0; i < count; i++) {
          const size_t interval = (size_t)(points[i] * (double)count + nudge);
          assert_true(interval < count);
          assert_int_equal(seen[interval]++, 0);
        }
      }
    }
    asc_sampler_destroy(sampler);
  }
}

/* Boxes of 2^-a x 3^-c, each with one of 2^a 3^c points (Halton 1960). */
static void each_box_of_two_bases_holds_one_point(void **state) {
  (void)state;
  const char *const specs[] = {"halton", "halton:scramble=digit", "halton:scramble=owen"};
  for (size_t k = 0; k < 3; k++)
    for (int a = 0; a <= 7; a++)
      for (uint64_t rows = 1; rows <= 81; rows *= 3) {
        static double points[128 * 81 * 2];
        static unsigned char seen[128 * 81];
        const uint64_t columns = (uint64_t)1 << a, count = columns * rows;
        memset(seen, 0, sizeof seen);
        points_of(specs[k], count, 2, 7, points);
        for (uint64_t i = 0; i < count; i++) {
          const size_t x = (size_t)(points[2 * i] * (double)columns);
          const size_t y = (size_t)(points[2 * i + 1] * (double)rows + (k == 0 ? 1e-9 : 0.0));
          assert_int_equal(seen[y * columns + x]++, 0);
        }
      }
}

static void hammersley_stays_a_net(void **state) {
  (void)state;
  enum { M = 8, N = 1 << M };
  const char *const specs[] = {"hammersley", "hammersley:scramble=digit", "hammersley:scramble=owen"};
  for (size_t k = 0; k < 3; k++) {
    double points[N * 2];
    points_of(specs[k], N, 2, 11, points);
    for (int a = 0; a <= M; a++) {
      int seen[N] = {0};
      for (size_t i = 0; i < N; i++) {
        const int column = (int)(points[2 * i] * (1 << a)), row = (int)(points[2 * i + 1] * (1 << (M - a)));
        assert_int_equal(seen[(row << a) + column]++, 0);
      }
    }
  }
}

/* --- what is random of the digits -----------------------------------------------------------------------------------
 */

#define PIXELS 40000

/* Chi-squared of PIXELS draws of `bins` equally likely outcomes, as a standard normal quantile (Wilson and Hilferty).
 * Below 5 with a probability of 3e-7; seeds are fixed. */
static double surprise(const unsigned *counts, size_t bins) {
  const double expected = (double)PIXELS / (double)bins, freedom = (double)bins - 1.0, spread = 2.0 / (9.0 * freedom);
  double chi = 0.0;
  for (size_t i = 0; i < bins; i++) chi += ((double)counts[i] - expected) * ((double)counts[i] - expected) / expected;
  return (cbrt(chi / freedom) - (1.0 - spread)) / sqrt(spread);
}

/* The digit of base^-place, place from 1; reliable for places well above 2^-53. */
static uint32_t digit_at(double value, uint32_t base, int place) {
  for (; place > 1; place--) value = value * base - floor(value * base);
  return (uint32_t)(value * base);
}

/* The permutation of base 3 that takes 0, 1, 2 to `images`, as a number below 6. */
static unsigned code_of_three(const uint32_t images[3]) { return 2 * images[0] + (images[1] > images[2]); }

static void all_permutations_of_a_digit_are_equally_likely(void **state) {
  (void)state;
  static unsigned of_three[6], of_five[3125], possible[120];
  memset(of_three, 0, sizeof of_three);
  memset(of_five, 0, sizeof of_five);
  asc_sampler *sampler = make("halton:scramble=owen", 1, 3, 2);
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    double threes[3], fives[5];
    uint32_t images[3], code = 0;
    fill(sampler, pixel, 3, 0, 3, 1, 1, threes);
    fill(sampler, pixel, 3, 0, 5, 2, 1, fives);
    for (int i = 0; i < 3; i++) images[i] = (uint32_t)(threes[i] * 3);
    for (int i = 0; i < 5; i++) code = code * 5 + (uint32_t)(fives[i] * 5);
    of_three[code_of_three(images)]++;
    of_five[code]++;
  }
  size_t reached = 0;
  for (size_t i = 0; i < 3125; i++)
    if (of_five[i]) {
      assert_true(reached < 120);
      possible[reached++] = of_five[i];
    }
  assert_int_equal(reached, 120);
  assert_true(fabs(surprise(of_three, 6)) < 5);
  assert_true(fabs(surprise(possible, 120)) < 5);
  asc_sampler_destroy(sampler);
}

/* The permutations of two digits, one below the other or beside it, are independent: all 36 pairs equally likely. Digit
 * 2 below digit a is seen in the points a, a + 3, a + 6; digit 3 below (0, 0) in the points 0, 9, 18. */
static void permutations_of_nested_digits_are_independent(void **state) {
  (void)state;
  unsigned beside[36] = {0}, below[36] = {0}, further[36] = {0};
  asc_sampler *sampler = make("halton:scramble=owen", 1, 2, 8);
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    double points[27];
    uint32_t top[3], under_zero[3], under_one[3], third[3];
    fill(sampler, pixel, 1, 0, 27, 1, 1, points);
    for (int i = 0; i < 3; i++) {
      top[i] = digit_at(points[i], 3, 1);
      under_zero[i] = digit_at(points[3 * i], 3, 2);
      under_one[i] = digit_at(points[1 + 3 * i], 3, 2);
      third[i] = digit_at(points[9 * i], 3, 3);
    }
    beside[6 * code_of_three(under_zero) + code_of_three(under_one)]++;
    below[6 * code_of_three(top) + code_of_three(under_zero)]++;
    further[6 * code_of_three(under_zero) + code_of_three(third)]++;
  }
  assert_true(fabs(surprise(beside, 36)) < 5);
  assert_true(fabs(surprise(below, 36)) < 5);
  assert_true(fabs(surprise(further, 36)) < 5);
  asc_sampler_destroy(sampler);
}

/* Digits past the last of an index: uniform, and under owen independent of those of two other points, whose prefixes
 * differ in the first digit or not before the fifth: at the same place and at later ones. In base 2 place 40, which the
 * hash makes in its second step. Digit scrambling adds the same to all. */
static void zeros_past_the_last_digit_are_scrambled(void **state) {
  (void)state;
  for (uint32_t d = 0; d < 3; d++) {
    const uint32_t base = primes[d];
    const int place = d == 0 ? 40 : 12;
    const uint64_t far = (uint64_t)base * base * base * base;
    unsigned alone[5] = {0}, both[25] = {0}, apart[5][25] = {{0}}, shifted[5] = {0};
    asc_sampler *owen = make("halton:scramble=owen", 1, 3, 21), *digit = make("halton:scramble=digit", 1, 3, 21);
    for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
      double points[2];
      fill(owen, 0, pixel, 6, 2, d, 1, points);
      alone[digit_at(points[0], base, place)]++;
      both[digit_at(points[0], base, place) * base + digit_at(points[1], base, place)]++;
      fill(owen, 0, pixel, 6 + far, 1, d, 1, points + 1);
      for (int later = 0; later < 5; later++)
        apart[later][digit_at(points[0], base, place) * base + digit_at(points[1], base, place + later)]++;
      fill(digit, 0, pixel, 6, 2, d, 1, points);
      shifted[digit_at(points[0], base, place)]++;
      assert_int_equal(digit_at(points[0], base, place), digit_at(points[1], base, place));
    }
    assert_true(fabs(surprise(alone, base)) < 5);
    assert_true(fabs(surprise(both, (size_t)base * base)) < 5);
    for (int later = 0; later < 5; later++) assert_true(fabs(surprise(apart[later], (size_t)base * base)) < 5);
    assert_true(fabs(surprise(shifted, base)) < 5);
    asc_sampler_destroy(owen);
    asc_sampler_destroy(digit);
  }
}

/* digit adds, modulo the base, one random digit to each place, the same for all indices. */
static void digit_scrambling_is_a_shift_of_each_digit(void **state) {
  (void)state;
  asc_sampler *sampler = make("halton:scramble=digit", 1, 8, 4);
  for (uint32_t d = 0; d < 8; d++) {
    double points[200];
    fill(sampler, 2, 2, 0, 200, d, 1, points);
    for (uint64_t i = 1; i < 200; i++) {
      uint64_t rest = i;
      for (int place = 1; place <= 8; place++, rest /= primes[d]) {
        const uint32_t shift = digit_at(points[0], primes[d], place), moved = digit_at(points[i], primes[d], place);
        assert_int_equal(moved, (shift + rest % primes[d]) % primes[d]);
      }
    }
  }
  asc_sampler_destroy(sampler);
}

/* Bases above 61 take keyed permutations: of 127, the images of two digits, in 8 x 8 groups. */
static void permutations_of_large_bases_spread_pairs_evenly(void **state) {
  (void)state;
  unsigned single[127] = {0};
  double chi = 0.0;
  static unsigned pairs[127][127];
  memset(pairs, 0, sizeof pairs);
  asc_sampler *sampler = make("halton:scramble=owen", 1, 31, 6);
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    double points[2];
    fill(sampler, pixel, pixel, 63, 2, 30, 1, points);
    single[(size_t)(points[0] * 127)]++;
    pairs[(size_t)(points[0] * 127)][(size_t)(points[1] * 127)]++;
  }
  assert_true(fabs(surprise(single, 127)) < 5);
  for (int a = 0; a < 127; a++)
    for (int b = 0; b < 127; b++) {
      const double expected = a == b ? 0.0 : PIXELS / (127.0 * 126.0);
      if (a == b)
        assert_int_equal(pairs[a][b], 0);
      else
        chi += (pairs[a][b] - expected) * (pairs[a][b] - expected) / expected;
    }
  /* 16,001 degrees of freedom: the mean of chi-squared, and a spread of sqrt(2 x 16001) = 179 that few counts a cell
   * raise a little (by 1 / expected); within 6 of them. */
  assert_true(fabs(chi - 16001.0) < 6 * 190.0);
  asc_sampler_destroy(sampler);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(plain_values_are_the_digits_reversed),
      cmocka_unit_test(runs_are_the_points_one_by_one),
      cmocka_unit_test(hammersley_is_i_over_n_and_halton),
      cmocka_unit_test(each_interval_holds_one_point),
      cmocka_unit_test(each_box_of_two_bases_holds_one_point),
      cmocka_unit_test(hammersley_stays_a_net),
      cmocka_unit_test(all_permutations_of_a_digit_are_equally_likely),
      cmocka_unit_test(permutations_of_nested_digits_are_independent),
      cmocka_unit_test(zeros_past_the_last_digit_are_scrambled),
      cmocka_unit_test(digit_scrambling_is_a_shift_of_each_digit),
      cmocka_unit_test(permutations_of_large_bases_spread_pairs_evenly),
  };
  return cmocka_run_group_tests_name("halton", tests, NULL, NULL);
}

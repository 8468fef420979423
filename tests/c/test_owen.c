/* How uniform the hash of owen.h is, by itself and in sobol:scramble=owen. That it keeps nets nets, test_sampler.c and
 * test_nets.c hold. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "hash.h"
#include "owen.h"

#include "sampler_tools.h"

/* The bit that the hash flips at a level (0: the leading digit), after the digits in `before`. */
static unsigned flip(uint32_t before, unsigned level, uint64_t bits) {
  return ((asc_owen_reversed(before, asc_owen_key_of(bits)) ^ before) >> level) & 1u;
}

/* The flips of `levels` levels from `base` on, of all digits there, under the digits `before`. */
static unsigned pattern_of(uint32_t before, unsigned base, unsigned levels, uint64_t bits) {
  unsigned pattern = 0, count = 0;
  for (unsigned level = 0; level < levels; level++)
    for (uint32_t digits = 0; digits < 1u << level; digits++)
      pattern |= flip(before | digits << base, base + level, bits) << count++;
  return pattern;
}

/* Number `n` spread over those bits of a key that the hash reads for the first `levels` digits: the lowest of each of
 * its four words, but that the factor is even. */
static uint64_t key_numbered(uint32_t n, unsigned levels) {
  const uint64_t low = (1u << levels) - 1u, wide = n;
  return (wide & low) | (wide >> levels & low) << 32 | (wide >> 2 * levels & low) << 24 | (wide >> 3 * levels) << 17;
}

/* Not by chance but by all keys: each of the 128 patterns of three digits from 16 of the 2^11, whatever the other bits.
 * (With sums and products alone, as in the hash of Laine and Karras and its successors, 32 are reached.) */
static void all_flips_of_three_digits_are_equally_likely(void **state) {
  (void)state;
  const uint64_t others[] = {0, 0x9e3779b97f4a7c15u, UINT64_MAX};
  for (size_t k = 0; k < 3; k++) {
    unsigned counts[128] = {0};
    for (uint32_t n = 0; n < 2048; n++) {
      const uint64_t read = key_numbered(2047, 3);
      counts[pattern_of(0, 0, 3, key_numbered(n, 3) | (others[k] & ~read))]++;
    }
    for (int pattern = 0; pattern < 128; pattern++) assert_int_equal(counts[pattern], 16);
  }
}

/* What owen.h says of four digits. */
static void of_the_flips_of_four_digits_a_seventh_is_reached(void **state) {
  (void)state;
  static unsigned char reached[1 << 15];
  memset(reached, 0, sizeof reached);
  int count = 0;
  for (uint32_t n = 0; n < 1u << 15; n++) {
    const unsigned pattern = pattern_of(0, 0, 4, key_numbered(n, 4));
    count += reached[pattern] == 0;
    reached[pattern] = 1;
  }
  assert_int_equal(count, 4608);
}

/* The quantile 1 - 1e-6 of chi-squared with k degrees of freedom (Wilson and Hilferty 1931). */
static double chi_squared_limit(double k) {
  const double spread = 2.0 / (9.0 * k), root = 1.0 - spread + 4.7534243 * sqrt(spread);
  return k * root * root * root;
}

static void assert_equally_often(const unsigned *counts, size_t cells, double draws, const char *what, unsigned where) {
  double sum = 0.0;
  for (size_t i = 0; i < cells; i++) sum += (counts[i] - draws / (double)cells) * (counts[i] - draws / (double)cells);
  const double statistic = sum / (draws / (double)cells);
  if (statistic > chi_squared_limit((double)cells - 1.0)) fail_msg("%s, %u: chi-squared %g", what, where, statistic);
}

#define DRAWS 16384

/* Further down: the 128 patterns of any three digits in a row, under no digits set before, few, and many. Together 90
 * tests at 1e-6 each. */
static void flips_of_three_digits_are_equally_likely_at_all_levels(void **state) {
  (void)state;
  for (unsigned base = 0; base < 30; base++)
    for (unsigned kind = 0; kind < 3; kind++) {
      static unsigned counts[128];
      memset(counts, 0, sizeof counts);
      const uint32_t digits = kind == 0 ? 0 : kind == 1 ? 11 : 0xa3c59ac3u;
      for (uint64_t k = 0; k < DRAWS; k++)
        counts[pattern_of(digits & ((1u << base) - 1u), base, 3,
                          asc_mix64(k + (uint64_t)977 * (base + (uint64_t)30 * kind)))]++;
      assert_equally_often(counts, 128, DRAWS, "three digits from", base);
    }
}

/* A digit that changes changes the flip of each digit below it half of the time: 2 x 496 binomials, each within 6
 * standard deviations (all of them with probability 2e-6). */
static void each_digit_decides_about_all_below(void **state) {
  (void)state;
  for (int random = 0; random < 2; random++) {
    static unsigned changed[32][32];
    memset(changed, 0, sizeof changed);
    for (uint64_t k = 0; k < DRAWS; k++) {
      const asc_owen_key key = asc_owen_key_of(asc_mix64(k));
      const uint32_t x = random ? (uint32_t)asc_mix64(~k) : 0, hashed = asc_owen_reversed(x, key);
      for (unsigned i = 0; i < 32; i++) {
        const uint32_t other = asc_owen_reversed(x ^ 1u << i, key) ^ hashed;
        for (unsigned j = i + 1; j < 32; j++) changed[i][j] += (other >> j) & 1u;
      }
    }
    for (unsigned i = 0; i < 32; i++)
      for (unsigned j = i + 1; j < 32; j++) assert_true(fabs(changed[i][j] - DRAWS / 2.0) < 6.0 * sqrt(DRAWS) / 2.0);
  }
}

#define PIXELS 65536

/* The same of the sampler: the first eight points of the first dimension, and of the second, fill the eight intervals
 * of three digits, so their scrambled digits are a pattern. */
static void sobol_flips_three_digits_equally_often(void **state) {
  (void)state;
  asc_sampler *plain = make("sobol", 8, 2, 0), *sampler = make("sobol:scramble=owen", 8, 2, 31);
  double before[8][2];
  fill(plain, 0, 0, 0, 8, 0, 2, before[0]);
  static unsigned counts[2][128];
  memset(counts, 0, sizeof counts);
  for (int32_t pixel = 0; pixel < PIXELS; pixel++) {
    double points[8][2];
    fill(sampler, pixel % 256 - 128, pixel / 256, 0, 8, 0, 2, points[0]);
    for (unsigned d = 0; d < 2; d++) {
      unsigned pattern = 0, count = 0;
      for (unsigned level = 0; level < 3; level++)
        for (unsigned digits = 0; digits < 1u << level; digits++)
          for (unsigned i = 0; i < 8; i++)
            if ((unsigned)(before[i][d] * 8) == digits << (3 - level)) /* one of those that have the digits */
              pattern |= (((unsigned)(points[i][d] * 8) >> (2 - level)) & 1u) << count++;
      counts[d][pattern]++;
    }
  }
  asc_sampler_destroy(plain);
  asc_sampler_destroy(sampler);
  for (unsigned d = 0; d < 2; d++) assert_equally_often(counts[d], 128, PIXELS, "dimension", d);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_flips_of_three_digits_are_equally_likely),
      cmocka_unit_test(of_the_flips_of_four_digits_a_seventh_is_reached),
      cmocka_unit_test(flips_of_three_digits_are_equally_likely_at_all_levels),
      cmocka_unit_test(each_digit_decides_about_all_below),
      cmocka_unit_test(sobol_flips_three_digits_equally_often),
  };
  return cmocka_run_group_tests_name("owen", tests, NULL, NULL);
}

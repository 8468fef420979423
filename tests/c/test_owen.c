/* How uniform the hash of owen.h is, by itself and in sobol:scramble=owen; and the flips of owen_full.h. That it keeps
 * nets nets, test_sampler.c and test_nets.c hold. */
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
#include "owen_full.h"

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

/* A number that, times `odd`, is 1 modulo 2^64: each of Newton's steps doubles the digits that are right. */
static uint64_t inverse_of(uint64_t odd) {
  uint64_t inverse = odd;
  for (int i = 0; i < 6; i++) inverse *= 2 - odd * inverse;
  return inverse;
}

/* What asc_mix64 takes to y. */
static uint64_t unmixed(uint64_t y) {
  y ^= (y >> 31) ^ (y >> 62);
  y *= inverse_of(0x94d049bb133111ebu);
  y ^= (y >> 27) ^ (y >> 54);
  y *= inverse_of(0xbf58476d1ce4e5b9u);
  return y ^ (y >> 30) ^ (y >> 60);
}

/* The flips of the `levels` leading digits by owen_full.h, of all digits there, the coin of node k as bit k: node 1 is
 * the first digit's, 2 and 3 the second's. */
static uint64_t full_pattern(uint64_t start, unsigned levels) {
  uint64_t pattern = 0;
  for (unsigned level = 0; level < levels; level++)
    for (uint32_t digits = 0; digits < 1u << level; digits++) {
      const uint32_t x = (uint32_t)((uint64_t)digits << (32 - level));
      pattern |= (uint64_t)((asc_owen_full(x, start) ^ x) >> (31 - level) & 1u) << (1u << level | digits);
    }
  return pattern;
}

/* Exactly: of the 2^64 numbers that a dimension's flips may come from, those of six digits take each of the 2^63 ways
 * from two. For 2^15 of them, each way of four digits once, and the others random, the two are found and tried. */
static void all_flips_of_six_digits_are_equally_likely_in_full(void **state) {
  (void)state;
  for (uint64_t four = 0; four < 1u << 15; four++) {
    const uint64_t below = asc_mix64(four) & ~UINT64_C(0xffff), wanted = four << 1 | below;
    for (uint64_t unread = 0; unread < 2; unread++) {
      const uint64_t start = unmixed(wanted | unread) - ASC_GOLDEN; /* node 1 is the first after it */
      assert_true(asc_draw_at(start, 1) == (wanted | unread));
      if (full_pattern(start, 6) != wanted) fail_msg("way %llu is not reached", (unsigned long long)four);
    }
  }
}

/* Further down, where a draw ends and the next begins too: as of the hash above, 90 tests at 1e-6 each. And four digits
 * in a row have all their 2^15 ways, in as many of 2^18 draws as is to be expected: all but 2^15 e^-8 = 11 +- 3.3. */
static void flips_are_equally_likely_at_all_levels_in_full(void **state) {
  (void)state;
  for (unsigned base = 0; base < 30; base++)
    for (unsigned kind = 0; kind < 3; kind++) {
      static unsigned counts[128];
      memset(counts, 0, sizeof counts);
      const uint32_t digits = kind == 0 ? 0 : kind == 1 ? 0xd0000000u : 0xa3c59ac3u;
      const uint32_t before = base == 0 ? 0 : digits & ~(UINT32_MAX >> base);
      for (uint64_t k = 0; k < DRAWS; k++) {
        unsigned pattern = 0, count = 0;
        for (unsigned level = 0; level < 3; level++)
          for (uint32_t under = 0; under < 1u << level; under++) {
            const uint32_t x = before | (uint32_t)((uint64_t)under << (32 - base - level));
            pattern |= ((asc_owen_full(x, asc_mix64(k)) ^ x) >> (31 - base - level) & 1u) << count++;
          }
        counts[pattern]++;
      }
      assert_equally_often(counts, 128, DRAWS, "three digits from", base);
    }
  static unsigned char reached[1 << 15];
  int missing = 1 << 15;
  memset(reached, 0, sizeof reached);
  for (uint64_t k = 0; k < 1u << 18; k++) {
    const size_t pattern = full_pattern(asc_mix64(k), 4) >> 1;
    missing -= reached[pattern] == 0;
    reached[pattern] = 1;
  }
  assert_true(missing < 11 + 6 * 3.3);
}

/* The prefix decides, and nothing else: points that share digits share what they become, and a point alone becomes what
 * it does among others. Not so of the hash: the two are other patterns. */
static void full_scrambling_is_nested(void **state) {
  (void)state;
  for (uint64_t k = 0; k < 4096; k++) {
    const uint32_t x = (uint32_t)asc_mix64(k), y = x ^ ((uint32_t)asc_mix64(~k) >> (k % 32));
    const uint32_t differ = x ^ y, turned = asc_owen_full(x, k) ^ asc_owen_full(y, k);
    assert_int_equal(differ == 0, turned == 0);
    if (differ) assert_int_equal(__builtin_clz(differ), __builtin_clz(turned));
  }
  asc_sampler *full = make("sobol:scramble=owen-full", 64, 5, 31), *hashed = make("sobol:scramble=owen", 64, 5, 31);
  double all[64][5], others[64][5], one[5];
  fill(full, 3, -7, 0, 64, 0, 5, all[0]);
  fill(hashed, 3, -7, 0, 64, 0, 5, others[0]);
  for (uint64_t i = 0; i < 64; i++) {
    fill(full, 3, -7, i, 1, 0, 5, one);
    assert_memory_equal(one, all[i], sizeof one);
    for (size_t d = 0; d < 5; d++) assert_true(all[i][d] != others[i][d]);
  }
  asc_sampler_destroy(full);
  asc_sampler_destroy(hashed);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(all_flips_of_three_digits_are_equally_likely),
      cmocka_unit_test(of_the_flips_of_four_digits_a_seventh_is_reached),
      cmocka_unit_test(flips_of_three_digits_are_equally_likely_at_all_levels),
      cmocka_unit_test(each_digit_decides_about_all_below),
      cmocka_unit_test(sobol_flips_three_digits_equally_often),
      cmocka_unit_test(all_flips_of_six_digits_are_equally_likely_in_full),
      cmocka_unit_test(flips_are_equally_likely_at_all_levels_in_full),
      cmocka_unit_test(full_scrambling_is_nested),
  };
  return cmocka_run_group_tests_name("owen", tests, NULL, NULL);
}

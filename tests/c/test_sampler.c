/* The sampler library: hash, permutations, the first patterns, refusals, specs. test_sampler_contracts.c has what holds
 * of every sampler. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/plugin.h"
#include "hash.h"
#include "permutation.h"

#include "sampler_tools.h"

/* Index 2^32 - 1 of the first dimension is 1 - 2^-32, which rounds to 1 as float. */
static void values_next_to_one_are_moved(void **state) {
  (void)state;
  asc_sampler *sampler = make("sobol", 1, 1, 0);
  double point;
  fill(sampler, 0, 0, UINT32_MAX, 1, 0, 1, &point);
  assert_true(point == 1.0 - 0x1p-24);
  asc_sampler_destroy(sampler);
}

static void weights_are_one_over_n(void **state) {
  (void)state;
  asc_sampler *sampler = make("sobol", 40, 2, 0);
  double weights[40];
  assert_int_equal(asc_sampler_weights(sampler, 0, 40, weights), ASC_OK);
  for (int i = 0; i < 40; i++) assert_true(weights[i] == 1.0 / 40.0);
  asc_sampler_destroy(sampler);
}

/* The known answers of Random123 (Salmon et al. 2011): counter, key, result. */
static void philox_gives_its_known_answers(void **state) {
  (void)state;
  static const uint32_t known[][10] = {
      {0, 0, 0, 0, 0, 0, 0x6627e8d5u, 0xe169c58du, 0xbc57ac4cu, 0x9b00dbd8u},
      {0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0xffffffffu, 0x408f276du, 0x41c83b0eu,
       0xa20bc7c6u, 0x6d5451fdu},
      {0x243f6a88u, 0x85a308d3u, 0x13198a2eu, 0x03707344u, 0xa4093822u, 0x299f31d0u, 0xd16cfe09u, 0x94fdccebu,
       0x5001e420u, 0x24126ea1u},
  };
  for (size_t i = 0; i < 3; i++) {
    asc_block block = asc_philox(known[i], known[i] + 4);
    assert_memory_equal(block.word, known[i] + 6, sizeof block.word);
  }
}

static void hashing_side_by_side_is_hashing_one_by_one(void **state) {
  (void)state;
  const asc_key key = asc_stream_key(77, -3, 1 << 20);
  const uint64_t first = UINT32_MAX - 5; /* the lanes cross a carry into the high word */
  asc_lanes lanes;
  asc_hash_lanes(key, first, 3, ASC_PURPOSE_UNIFORM, &lanes);
  for (uint32_t i = 0; i < ASC_LANES; i++) {
    asc_block block = asc_hash(key, first + i, 3, ASC_PURPOSE_UNIFORM);
    for (int word = 0; word < 4; word++) assert_int_equal(lanes.word[word][i], block.word[word]);
  }
}

static void regular_points_are_the_centres_of_cells(void **state) {
  (void)state;
  double points[12 * 12 * 2];
  asc_sampler *sampler = make("regular", 144, 2, 0);
  fill(sampler, 0, 0, 0, 144, 0, 2, points);
  for (int i = 0; i < 144; i++) {
    assert_true(points[2 * i] == (i % 12 + 0.5) / 12.0);
    assert_true(points[2 * i + 1] == (i / 12 + 0.5) / 12.0); // NOLINT(bugprone-integer-division): the row
  }
  asc_sampler_destroy(sampler);
}

/* One point in each cell, for both pairs of four dimensions, over many pixels. */
static void jittered_has_one_point_in_each_cell(void **state) {
  (void)state;
  asc_sampler *sampler = make("jittered", 100, 4, 3);
  for (int32_t pixel = 0; pixel < 200; pixel++) {
    double points[100 * 4];
    int seen[2][100] = {{0}};
    fill(sampler, pixel, 5, 0, 100, 0, 4, points);
    for (size_t i = 0; i < 100; i++)
      for (size_t pair = 0; pair < 2; pair++)
        seen[pair][(int)(points[4 * i + 2 * pair] * 10) + 10 * (int)(points[4 * i + 2 * pair + 1] * 10)]++;
    for (size_t cell = 0; cell < 100; cell++) {
      assert_int_equal(seen[0][cell], 1);
      assert_int_equal(seen[1][cell], 1);
    }
  }
  asc_sampler_destroy(sampler);
}

/* Every elementary interval of 2^-a x 2^-(m-a) holds one of 2^m points: a (0, m, 2)-net, scrambled or not, for every
 * aligned run of 2^m indices. */
static void sobol_is_a_net_however_scrambled(void **state) {
  (void)state;
  const char *const nets[] = {"sobol", "sobol:scramble=digit", "sobol:scramble=owen", "sobol:scramble=owen-full"};
  enum { M = 10, N = 1 << M };
  for (size_t k = 0; k < 4; k++) {
    asc_sampler *sampler = make(nets[k], 4 * N, 2, 12);
    for (uint64_t run = 0; run < 4; run++) {
      static double points[N * 2];
      fill(sampler, 6, 6, run * N, N, 0, 2, points);
      for (int a = 0; a <= M; a++) {
        static int seen[N];
        memset(seen, 0, sizeof seen);
        for (size_t i = 0; i < N; i++) {
          const int column = (int)(points[2 * i] * (1 << a)), row = (int)(points[2 * i + 1] * (1 << (M - a)));
          assert_int_equal(seen[(row << a) + column]++, 0);
        }
      }
    }
    asc_sampler_destroy(sampler);
  }
}

/* Owen scrambling flips each digit by a fair coin for each prefix. Over 4,096 pixels the first three digits of a point
 * make all 8 values equally often; chi-squared of 7 degrees of freedom exceeds 29.9 with probability 1e-4. So it is
 * for the digits 4 to 6 given the digits above them, which tells it from a digital shift: two points of one cell of 1/8
 * go to different sub-cells, and their difference must vary. */
static void nested_and_uniform(const char *spec) {
  asc_sampler *sampler = make(spec, 64, 2, 4);
  for (uint32_t dimension = 0; dimension < 2; dimension++) {
    int first[8] = {0}, below[8] = {0}, differences = 0;
    for (int32_t pixel = 0; pixel < 4096; pixel++) {
      double points[64];
      fill(sampler, pixel, 0, 0, 64, dimension, 1, points);
      const int a = (int)(points[5] * 64);
      first[a >> 3]++;
      below[a & 7]++;
      differences |= 1 << ((a ^ (int)(points[13] * 64)) & 7);
    }
    double chi_first = 0.0, chi_below = 0.0;
    for (int i = 0; i < 8; i++) {
      chi_first += (first[i] - 512.0) * (first[i] - 512.0) / 512.0;
      chi_below += (below[i] - 512.0) * (below[i] - 512.0) / 512.0;
    }
    assert_true(chi_first < 29.9);
    assert_true(chi_below < 29.9);
    assert_true((differences & (differences - 1)) != 0);
  }
  asc_sampler_destroy(sampler);
}

static void owen_scrambling_is_nested_and_uniform(void **state) {
  (void)state;
  nested_and_uniform("sobol:scramble=owen");
  nested_and_uniform("sobol:scramble=owen-full");
}

static void permutations_are_permutations(void **state) {
  (void)state;
  const uint64_t sizes[] = {1, 2, 3, 4, 63, 64, 65, 100, 1000, 4096, 5000};
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
    asc_permutation permutation;
    asc_permutation_make(&permutation, sizes[k], asc_stream_key(1, 2, 3), (uint32_t)k);
    unsigned char seen[5000] = {0};
    for (uint64_t i = 0; i < sizes[k]; i++) {
      const uint64_t at = asc_permutation_at(&permutation, i);
      assert_true(at < sizes[k]);
      assert_int_equal(seen[at]++, 0);
    }
  }
}

/* All 24 permutations of 4, equally often: chi-squared of 23 degrees of freedom exceeds 58.6 with probability 6e-5. */
static void all_permutations_of_four_are_reached(void **state) {
  (void)state;
  enum { DRAWS = 24000 };
  int counts[256] = {0};
  for (int32_t i = 0; i < DRAWS; i++) {
    asc_permutation permutation;
    asc_permutation_make(&permutation, 4, asc_stream_key(3, i, 0), 1);
    unsigned code = 0;
    for (uint64_t k = 0; k < 4; k++) code = code << 2 | (unsigned)asc_permutation_at(&permutation, k);
    counts[code]++;
  }
  double chi = 0.0;
  int reached = 0;
  for (int code = 0; code < 256; code++) {
    if (!counts[code]) continue;
    reached++;
    chi += (counts[code] - DRAWS / 24.0) * (counts[code] - DRAWS / 24.0) / (DRAWS / 24.0);
  }
  assert_int_equal(reached, 24);
  assert_true(chi < 58.6);
}

/* Above the table: where element 0 and element 1 land, in 10 x 10 blocks of 100; chi-squared of 99 degrees of freedom
 * exceeds 161 with probability 8e-5. */
static void large_permutations_spread_pairs_evenly(void **state) {
  (void)state;
  enum { DRAWS = 20000 };
  static int counts[100];
  memset(counts, 0, sizeof counts);
  for (int32_t i = 0; i < DRAWS; i++) {
    asc_permutation permutation;
    asc_permutation_make(&permutation, 100, asc_stream_key(3, i, 0), 1);
    counts[asc_permutation_at(&permutation, 0) / 10 * 10 + asc_permutation_at(&permutation, 1) / 10]++;
  }
  double chi = 0.0;
  for (int cell = 0; cell < 100; cell++) {
    /* Distinct elements: a block holds 10 x 9 of the 9,900 pairs on the diagonal, 10 x 10 elsewhere. */
    const double expected = DRAWS * (cell / 10 == cell % 10 ? 90.0 : 100.0) / 9900.0;
    chi += (counts[cell] - expected) * (counts[cell] - expected) / expected;
  }
  assert_true(chi < 161.0);
}

typedef struct refusal {
  const char *spec;
  uint64_t samples;
  uint32_t dimensions;
  asc_status status;
  const char *text;
} refusal;

static void what_cannot_be_is_refused(void **state) {
  (void)state;
  static const refusal refusals[] = {
      {"sobel", 4, 2, ASC_UNKNOWN_NAME, "did you mean \"sobol\"?"},
      {"nothing-like-it", 4, 2, ASC_UNKNOWN_NAME, "known: random, "},
      {"sobol:scrambel=owen", 4, 2, ASC_UNKNOWN_KEY, "did you mean \"scramble\"?"},
      {"random:x=1", 4, 2, ASC_UNKNOWN_KEY, "it has none"},
      {"sobol:scramble=own", 4, 2, ASC_INVALID_VALUE, "none|shift|digit|owen"},
      {"sobol:scramble", 4, 2, ASC_INVALID_VALUE, "key=value"},
      {"sobol:", 4, 2, ASC_INVALID_VALUE, "key=value"},
      {"sobol:scramble=owen,scramble=owen", 4, 2, ASC_INVALID_VALUE, "twice"},
      {":scramble=owen", 4, 2, ASC_INVALID_ARGUMENT, "no name"},
      {"jittered", 17, 2, ASC_UNSUPPORTED, "17 is no square"},
      {"regular", 16, 3, ASC_UNSUPPORTED, "16 is not such a power"},
      {"sobol", ((uint64_t)1 << 32) + 1, 2, ASC_UNSUPPORTED, "2^32"},
      {"sobol", 4, 1025, ASC_UNSUPPORTED, "1024 dimensions"},
      {"halton", 4, 1025, ASC_UNSUPPORTED, "1024 dimensions"},
      {"random", ((uint64_t)1 << 53) + 1, 2, ASC_UNSUPPORTED, "2^53"},
  };
  for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
    const asc_sampler_desc desc = {sizeof desc, refusals[i].spec, refusals[i].samples, refusals[i].dimensions, 0};
    asc_sampler *sampler = NULL;
    asc_error error = {{0}};
    assert_int_equal(asc_sampler_create(&desc, &sampler, &error), refusals[i].status);
    assert_null(sampler);
    if (!strstr(error.text, refusals[i].text)) fail_msg("%s: %s", refusals[i].spec, error.text);
    assert_int_equal(asc_sampler_create(&desc, &sampler, NULL), refusals[i].status);
  }
}

static void indices_past_the_end_are_refused(void **state) {
  (void)state;
  double point[2];
  asc_sampler *net = make("sobol", 1, 2, 0), *sequence = make("halton", 1, 2, 0), *grid = make("regular", 4, 2, 0);
  const asc_range last_of_net = {0, 0, UINT32_MAX, 1, 0, 2}, past_net = {0, 0, (uint64_t)1 << 32, 1, 0, 2};
  const asc_range last_of_sequence = {0, 0, ((uint64_t)1 << 53) - 1, 1, 0, 2};
  const asc_range past_sequence = {0, 0, (uint64_t)1 << 53, 1, 0, 2}, overflow = {0, 0, 1, SIZE_MAX, 0, 2};
  const asc_range past_grid = {0, 0, 3, 2, 0, 2}, past_dimensions = {0, 0, 0, 1, 1, 2};
  assert_int_equal(asc_sampler_fill(net, &last_of_net, point), ASC_OK);
  assert_int_equal(asc_sampler_fill(net, &past_net, point), ASC_UNSUPPORTED);
  assert_int_equal(asc_sampler_fill(sequence, &last_of_sequence, point), ASC_OK);
  assert_int_equal(asc_sampler_fill(sequence, &past_sequence, point), ASC_UNSUPPORTED);
  assert_int_equal(asc_sampler_fill(sequence, &overflow, point), ASC_UNSUPPORTED);
  assert_int_equal(asc_sampler_fill(grid, &past_grid, point), ASC_UNSUPPORTED);
  assert_int_equal(asc_sampler_fill(grid, &past_dimensions, point), ASC_INVALID_ARGUMENT);
  asc_sampler_destroy(net);
  asc_sampler_destroy(sequence);
  asc_sampler_destroy(grid);
}

static void specs_have_one_canonical_form(void **state) {
  (void)state;
  const char *const pairs[][2] = {{"sobol:scramble=none", "sobol"}, {"sobol:scramble=owen", "sobol:scramble=owen"}};
  for (size_t i = 0; i < 2; i++) {
    asc_sampler *sampler = make(pairs[i][0], 0, 0, 5);
    asc_sampler_desc resolved;
    assert_int_equal(asc_sampler_resolved(sampler, &resolved), ASC_OK);
    assert_string_equal(resolved.spec, pairs[i][1]);
    assert_int_equal(resolved.samples, 1);
    assert_int_equal(resolved.dimensions, 2);
    asc_sampler_destroy(sampler);
  }
}

/* Of a text that nothing ends no more is read than a spec may have. */
static void a_text_without_an_end_is_refused(void **state) {
  (void)state;
  enum { LENGTH = 512 };
  char *text = malloc(LENGTH);
  assert_non_null(text);
  memset(text, 'x', LENGTH);
  assert_int_equal(created(text, 1, 2), ASC_INVALID_ARGUMENT);
  free(text);
}

static void statuses_have_texts(void **state) {
  (void)state;
  assert_string_equal(asc_status_text(ASC_OK), "success");
  assert_string_equal(asc_status_text((asc_status)999), "unknown status");
}

static void plugins_that_are_none_are_refused(void **state) {
  (void)state;
  asc_error error = {{0}};
  assert_int_equal(asc_plugin_load("/nonexistent.so", &error), ASC_PLUGIN);
  assert_non_null(strstr(error.text, "/nonexistent.so"));
  assert_int_equal(asc_plugin_load(NULL, &error), ASC_INVALID_ARGUMENT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_next_to_one_are_moved),
      cmocka_unit_test(weights_are_one_over_n),
      cmocka_unit_test(philox_gives_its_known_answers),
      cmocka_unit_test(hashing_side_by_side_is_hashing_one_by_one),
      cmocka_unit_test(regular_points_are_the_centres_of_cells),
      cmocka_unit_test(jittered_has_one_point_in_each_cell),
      cmocka_unit_test(sobol_is_a_net_however_scrambled),
      cmocka_unit_test(owen_scrambling_is_nested_and_uniform),
      cmocka_unit_test(permutations_are_permutations),
      cmocka_unit_test(all_permutations_of_four_are_reached),
      cmocka_unit_test(large_permutations_spread_pairs_evenly),
      cmocka_unit_test(what_cannot_be_is_refused),
      cmocka_unit_test(indices_past_the_end_are_refused),
      cmocka_unit_test(specs_have_one_canonical_form),
      cmocka_unit_test(a_text_without_an_end_is_refused),
      cmocka_unit_test(statuses_have_texts),
      cmocka_unit_test(plugins_that_are_none_are_refused),
  };
  return cmocka_run_group_tests_name("sampler", tests, NULL, NULL);
}

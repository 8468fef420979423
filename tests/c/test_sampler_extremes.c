/* Every sampler at the ends of what can be asked for: it answers with values in [0, 1), or says ASC_UNSUPPORTED. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sampler_cases.h"
#include "sampler_tools.h"

#define ROWS 64 /* of one call */
#define MOST_DIMENSIONS 1024

static double points[ROWS * MOST_DIMENSIONS];

/* NULL where the pattern does not have this count or dimension. */
static asc_sampler *make_or_refuse(const char *spec, uint64_t samples, uint32_t dimensions, uint64_t seed) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, seed};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  const asc_status status = asc_sampler_create(&desc, &sampler, &error);
  if (status != ASC_OK && status != ASC_UNSUPPORTED)
    fail_msg("%s, N = %llu, %u dimensions: %s", spec, (unsigned long long)samples, dimensions, error.text);
  if (status == ASC_UNSUPPORTED && !error.text[0]) fail_msg("%s: refused without a reason", spec);
  return sampler;
}

/* Whether there were points; all must lie in [0, 1), as float too. */
static int fill_or_refuse(const char *spec, const asc_sampler *sampler, const asc_range *range) {
  const size_t count = range->sample_count * range->dimension_count;
  points[count] = -3.0; /* the one after: not to be written */
  const asc_status status = asc_sampler_fill(sampler, range, points);
  if (status == ASC_UNSUPPORTED) return 0;
  if (status) fail_msg("%s, sample %llu: %s", spec, (unsigned long long)range->first_sample, asc_status_text(status));
  for (size_t i = 0; i < count; i++)
    if (!(points[i] >= 0.0 && (float)points[i] < 1.0f))
      fail_msg("%s, sample %llu: %g", spec, (unsigned long long)range->first_sample, points[i]);
  assert_true(points[count] == -3.0);
  return 1;
}

static const int32_t places[][2] = {
    {0, 0}, {INT32_MAX, INT32_MAX}, {INT32_MIN, INT32_MIN}, {-1, 5}, {1 << 30, -(1 << 30)}};
static const uint64_t seeds[] = {0, UINT64_MAX};

/* The first points and the last, at the ends of seeds and pixels. */
static void check_count(const sampler_case *one, uint64_t samples, size_t least_places) {
  for (size_t s = 0; s < 2; s++) {
    asc_sampler *sampler = make_or_refuse(one->spec, samples, one->dimensions, seeds[s]);
    if (!sampler) return;
    for (size_t p = 0; p < least_places; p++) {
      const size_t rows = samples < ROWS - 1 ? (size_t)samples : ROWS - 1;
      const asc_range first = {places[p][0], places[p][1], 0, rows, 0, one->dimensions};
      const asc_range last = {places[p][0], places[p][1], samples - rows, rows, 0, one->dimensions};
      if (!fill_or_refuse(one->spec, sampler, &first) || !fill_or_refuse(one->spec, sampler, &last))
        fail_msg("%s: made with N = %llu, but has no such points", one->spec, (unsigned long long)samples);
    }
    asc_sampler_destroy(sampler);
  }
}

static void counts(void **state) {
  (void)state;
  const uint64_t few[] = {1, 2, 3, 4, 5, 7, 9, 13, 97, 127, 128, 1009};
  for (size_t k = 0; k < CASES; k++) {
    for (size_t i = 0; i < sizeof few / sizeof *few; i++) check_count(&cases[k], few[i], 5);
    const uint64_t most = cases[k].most ? cases[k].most : 1 << 20;
    check_count(&cases[k], most, 1);
    check_count(&cases[k], most - 3, 1); /* of 2^20: a prime */
  }
}

/* Sequences answer at every index below their end; others have no point past N. */
static void indices(void **state) {
  (void)state;
  const uint64_t ends[] = {UINT32_MAX, (uint64_t)1 << 32, ((uint64_t)1 << 53) - 1, (uint64_t)1 << 53, UINT64_MAX};
  for (size_t k = 0; k < CASES; k++) {
    asc_sampler *sampler = make_or_refuse(cases[k].spec, cases[k].samples, cases[k].dimensions, 5);
    assert_non_null(sampler);
    const int sequence = (asc_sampler_traits(sampler) & ASC_TRAIT_SEQUENCE) != 0;
    int answered_before = 1;
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++) {
      const asc_range range = {-9, 9, ends[i], 1, 0, cases[k].dimensions};
      const int answered = fill_or_refuse(cases[k].spec, sampler, &range);
      assert_true(sequence || !answered);
      assert_true(answered_before || !answered); /* one end, past which there is nothing */
      assert_true(!answered || ends[i] < (uint64_t)1 << 53);
      answered_before = answered;
    }
    asc_sampler_destroy(sampler);
  }
}

/* 1 and 1,024 dimensions, each dimension from the two sides of a range's end too. */
static void dimensions(void **state) {
  (void)state;
  const uint32_t numbers[] = {1, 2, MOST_DIMENSIONS};
  for (size_t k = 0; k < CASES; k++)
    for (size_t i = 0; i < 3; i++) {
      const uint32_t d = numbers[i];
      asc_sampler *sampler = make_or_refuse(cases[k].spec, cases[k].samples, d, 1);
      if (!sampler) continue;
      const asc_range all = {3, -3, 0, 5, 0, d}, last = {3, -3, 0, 5, d - 1, 1};
      double column[5];
      assert_true(fill_or_refuse(cases[k].spec, sampler, &all));
      for (size_t s = 0; s < 5; s++) column[s] = points[s * d + d - 1];
      assert_true(fill_or_refuse(cases[k].spec, sampler, &last));
      assert_memory_equal(column, points, sizeof column);
      asc_sampler_destroy(sampler);
    }
}

/* Counts that no pattern may take for smaller ones, or answer with a crash. */
static void counts_past_all_ends(void **state) {
  (void)state;
  const uint64_t counts_past[] = {((uint64_t)1 << 53) + 1, UINT64_MAX};
  for (size_t k = 0; k < CASES; k++)
    for (size_t i = 0; i < 2; i++) assert_null(make_or_refuse(cases[k].spec, counts_past[i], cases[k].dimensions, 0));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(counts),
      cmocka_unit_test(indices),
      cmocka_unit_test(dimensions),
      cmocka_unit_test(counts_past_all_ends),
  };
  return cmocka_run_group_tests_name("sampler extremes", tests, NULL, NULL);
}

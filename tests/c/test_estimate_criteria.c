/* What satisfies each criterion, by hand. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "criterion.h"

static asc_tally tally_of(const double *values, size_t n) {
  asc_tally made;
  memset(&made, 0, sizeof made);
  assert_int_equal(asc_tally_add(&made, 1, values, n), ASC_OK);
  return made;
}

static int satisfied(asc_criterion asked, const double *values, size_t n) {
  const asc_tally tally = tally_of(values, n);
  assert_int_equal(asc_criterion_make(&asked, 100), ASC_OK);
  const int found = asc_criterion_satisfied(&asked, 1, &tally);
  asc_criterion_free(&asked);
  return found;
}

static void criteria_by_hand(void **state) {
  (void)state;
  /* Contrast: of 3 and 7 it is 4/10; black on black has none; values below 0 count by their size. */
  const asc_criterion contrast = {.kind = ASC_BY_CONTRAST,
                                  .contrast = {ASC_CONTRAST_RED, ASC_CONTRAST_GREEN, ASC_CONTRAST_BLUE}};
  assert_true(satisfied(contrast, (double[]){3.0, 7.0 - 1e-9}, 2) && !satisfied(contrast, (double[]){3.0, 7.1}, 2));
  assert_true(satisfied(contrast, (double[]){-3.0, -7.0 + 1e-9}, 2) && !satisfied(contrast, (double[]){-3, -7.1}, 2));
  assert_true(satisfied(contrast, (double[]){0.0, 0.0}, 2) && !satisfied(contrast, (double[]){0.0, 1e-300}, 2));
  assert_false(satisfied(contrast, (double[]){-1.0, 1.0}, 2)); /* 1, the most there is */
  assert_true(satisfied(contrast, (double[]){1e308, 1e308}, 2));
  const double rgb[] = {1.0, 1.0, 1.0, 1.85, 1.85, 1.85}; /* 0.298 in each channel */
  asc_tally tallies[3];
  memset(tallies, 0, sizeof tallies);
  assert_int_equal(asc_tally_add(tallies, 3, rgb, 2), ASC_OK);
  assert_true(asc_criterion_satisfied(&contrast, 3, tallies));
  for (int c = 0; c < 3; c++) {
    asc_criterion tight = contrast;
    tight.contrast[c] = 0.297;
    assert_false(asc_criterion_satisfied(&tight, 3, tallies));
  }

  const double values[] = {1.0, 2.0, 3.0, 6.0}; /* mean 3, squares 14, variance 14/3 */
  asc_criterion by = {.kind = ASC_BY_RANGE, .tolerance = 5.0};
  assert_true(satisfied(by, values, 4));
  by.tolerance = 4.999;
  assert_false(satisfied(by, values, 4));
  by = (asc_criterion){.kind = ASC_BY_VARIANCE, .tolerance = 14.0 / 3 + 1e-12};
  assert_true(satisfied(by, values, 4) && !satisfied(by, values, 1));
  by.tolerance = 14.0 / 3 - 1e-12;
  assert_false(satisfied(by, values, 4));
  by.tolerance = 100.0;
  by.least = 5;
  assert_false(satisfied(by, values, 4));

  /* t of 0.975 with 3 degrees is 3.182446 (Student's table: 3.182), times sqrt(14/12). */
  by = (asc_criterion){.kind = ASC_BY_STUDENT_T, .confidence = 0.95, .tolerance = 3.182447 * sqrt(14.0 / 12)};
  assert_true(satisfied(by, values, 4) && !satisfied(by, values, 1));
  by.tolerance = 3.182446 * sqrt(14.0 / 12);
  assert_false(satisfied(by, values, 4));
  /* Chi-squared of 0.05 with 3 degrees is 0.3518463 (tables: 0.352): the root of 14/(4 * 0.3518463). */
  by = (asc_criterion){.kind = ASC_BY_CHI_SQUARED, .confidence = 0.95, .tolerance = sqrt(14.0 / 4 / 0.3518462)};
  assert_true(satisfied(by, values, 4) && !satisfied(by, values, 1));
  by.tolerance = sqrt(14.0 / 4 / 0.3518464);
  assert_false(satisfied(by, values, 4));
}

static void criteria_that_are_refused_and_tallies(void **state) {
  (void)state;
  const asc_criterion bad[] = {{.kind = ASC_BY_RANGE, .tolerance = -1.0},
                               {.kind = ASC_BY_VARIANCE, .tolerance = NAN},
                               {.kind = ASC_BY_CONTRAST, .contrast = {0.4, -0.1, 0.6}},
                               {.kind = ASC_BY_STUDENT_T, .confidence = 1.0},
                               {.kind = ASC_BY_CHI_SQUARED, .confidence = 0.0}};
  for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
    asc_criterion made = bad[i];
    assert_int_equal(asc_criterion_make(&made, 10), ASC_INVALID_VALUE);
    asc_criterion_free(&made);
  }
  const double values[] = {3.0, -1.0, 4.0, 1.0, -5.0, 9.0};
  asc_tally whole = tally_of(values, 6), first = tally_of(values, 2), none;
  memset(&none, 0, sizeof none);
  const asc_tally rest = tally_of(values + 2, 4), kept = whole;
  assert_int_equal(asc_tally_merge(&first, &rest, 1), ASC_OK);
  assert_true(first.least == -5.0 && first.greatest == 9.0 && first.moments.count == 6);
  assert_int_equal(asc_tally_merge(&whole, &none, 1), ASC_OK);
  assert_memory_equal(&whole, &kept, sizeof whole);
  assert_int_equal(asc_tally_merge(&none, &whole, 1), ASC_OK);
  assert_memory_equal(&none, &whole, sizeof whole);
  assert_int_equal(asc_tally_add(&whole, 1, (double[]){100.0, NAN}, 2), ASC_NUMERIC);
  assert_memory_equal(&whole, &kept, sizeof whole);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(criteria_by_hand),
      cmocka_unit_test(criteria_that_are_refused_and_tallies),
  };
  return cmocka_run_group_tests_name("estimate_criteria", tests, NULL, NULL);
}

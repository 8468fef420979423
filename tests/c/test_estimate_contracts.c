/* Contracts of every estimator; where the sequential ones stop. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "estimate_tools.h"

#define SAMPLES 256

/* An integrand of two channels that differs from pixel to pixel: an edge, and a smooth product. */
static asc_status edge_and_product(void *context, size_t count, const asc_pixel *pixels, const double *points,
                                   double *values) {
  uint64_t *asked = context;
  if (asked) *asked += count;
  for (size_t i = 0; i < count; i++) {
    const double x = points[2 * i], y = points[2 * i + 1];
    assert_true(x >= 0.0 && x < 1.0 && y >= 0.0 && y < 1.0);
    values[2 * i] = 0.8 * x + 0.3 * y < 0.1 * (pixels[i].x % 11) ? 1.0 : 0.0;
    values[2 * i + 1] = x * y + pixels[i].y;
  }
  return ASC_OK;
}

static void assert_not_made(const char *spec, const asc_sampler *sampler, uint32_t channels, asc_status status,
                            const char *text) {
  const asc_estimator_desc desc = {sizeof desc, spec, sampler, channels};
  asc_estimator *estimator = NULL;
  asc_error error = {{0}};
  assert_int_equal(asc_estimator_create(&desc, &estimator, &error), status);
  assert_null(estimator);
  if (!strstr(error.text, text)) fail_msg("%s: %s", spec, error.text);
}

/* What a pixel comes to does not depend on its group, and all that the integrand was asked is counted. */
static void pixels_do_not_depend_on_their_group(void **state) {
  (void)state;
  asc_sampler *sampler = sampler_of("random", SAMPLES, 2);
  for (size_t index = 0; index < asc_estimator_count(); index++) {
    asc_estimator_info info;
    assert_int_equal(asc_estimator_describe(index, &info), ASC_OK);
    assert_true(info.title && *info.title && info.source && *info.source);
    asc_estimator *estimator = estimator_of(info.name, sampler, 2);
    uint64_t asked = 0;
    const result whole = estimated(estimator, (asc_group){-3, 4, 9, 5}, edge_and_product, &asked);
    assert_int_equal(whole.spent, asked);
    /* Samples on the borders of pixels are shared by those that reach over them. */
    const int shares = asc_estimator_reach(estimator) > 1;
    uint64_t counts = 0;
    for (int i = 0; i < 45; i++) counts += whole.counts[i];
    assert_true(shares || counts <= whole.spent);
    for (int i = 0; i < 45; i++) {
      const asc_group one = {-3 + i % 9, 4 + i / 9, 1, 1};
      const result alone = estimated(estimator, one, edge_and_product, NULL);
      assert_memory_equal(alone.means, whole.means + 2 * i, 2 * sizeof *alone.means);
      assert_memory_equal(alone.errors, whole.errors + 2 * i, 2 * sizeof *alone.errors);
      assert_memory_equal(alone.degrees, whole.degrees + i, sizeof *alone.degrees);
      assert_int_equal(alone.counts[0], whole.counts[i]);
      assert_true(alone.counts[0] <= SAMPLES);
      if (shares) continue;
      /* The integrand was told the pixel: its second channel is in [y, y + 1), its first is 0 up to column 0, and in
       * column 5 an edge through the middle. */
      assert_true(alone.means[1] >= one.y && alone.means[1] < one.y + 1.0);
      if (one.x <= 0 || one.x == 5) assert_true((alone.means[0] > 0.0) == (one.x == 5));
    }
    asc_estimator_destroy(estimator);
  }
  asc_sampler_destroy(sampler);
}

static asc_status fails(void *context, size_t count, const asc_pixel *pixels, const double *points, double *values) {
  (void)context, (void)count, (void)pixels, (void)points, (void)values;
  return ASC_UNAVAILABLE;
}

/* NaN at one sample in a hundred. */
static asc_status sometimes_nan(void *context, size_t count, const asc_pixel *pixels, const double *points,
                                double *values) {
  (void)context, (void)pixels;
  for (size_t i = 0; i < count; i++) values[2 * i] = values[2 * i + 1] = points[2 * i] < 0.01 ? NAN : points[2 * i];
  return ASC_OK;
}

/* NaN in the second channel of pixels to the left of `context` and above it. */
static asc_status nan_beside(void *context, size_t count, const asc_pixel *pixels, const double *points,
                             double *values) {
  const asc_pixel *from = context;
  for (size_t i = 0; i < count; i++) {
    values[2 * i] = points[2 * i];
    values[2 * i + 1] = pixels[i].x < from->x && pixels[i].y < from->y ? NAN : points[2 * i];
  }
  return ASC_OK;
}

/* Also where it looked at the pixels around, and they failed: those are named beside. */
static void the_pixel_that_was_asked_for_is_named(void **state) {
  (void)state;
  asc_sampler *sampler = sampler_of("random", 4096, 2);
  for (size_t index = 0; index < asc_estimator_count(); index++) {
    asc_estimator_info info;
    assert_int_equal(asc_estimator_describe(index, &info), ASC_OK);
    asc_estimator *estimator = estimator_of(info.name, sampler, 2);
    double means[2];
    asc_estimates out = {.struct_size = sizeof out, .means = means};
    const asc_group group = {7, 5, 1, 1};
    asc_error error = {{0}};
    asc_pixel none_beside = {7, 5}, none_at_all = {1000, 1000};
    assert_int_equal(asc_estimate(estimator, &group, nan_beside, &none_at_all, &out, &error), ASC_NUMERIC);
    assert_non_null(strstr(error.text, "in pixel (7, 5): "));
    assert_non_null(strstr(error.text, "nan in channel 1 of the sample at (0."));
    const asc_status status = asc_estimate(estimator, &group, nan_beside, &none_beside, &out, &error);
    assert_int_equal(status, asc_estimator_reach(estimator) ? ASC_NUMERIC : ASC_OK);
    assert_non_null(strstr(error.text, "in pixel (7, 5): "));
    if (status) assert_non_null(strstr(error.text, ", of its neighbour (6, 4), which it looks at too"));
    asc_estimator_destroy(estimator);
  }
  asc_sampler_destroy(sampler);
}

static void errors_are_given_on(void **state) {
  (void)state;
  asc_sampler *sampler = sampler_of("random", 4096, 2);
  for (size_t index = 0; index < asc_estimator_count(); index++) {
    asc_estimator_info info;
    assert_int_equal(asc_estimator_describe(index, &info), ASC_OK);
    asc_estimator *estimator = estimator_of(info.name, sampler, 2);
    double means[8];
    asc_estimates out = {.struct_size = sizeof out, .means = means};
    asc_group group = {0, 0, 2, 2};
    asc_error error = {{0}};
    assert_int_equal(asc_estimate(estimator, &group, fails, NULL, &out, &error), ASC_UNAVAILABLE);
    assert_true(error.text[0]);
    assert_int_equal(asc_estimate(estimator, &group, sometimes_nan, NULL, &out, &error), ASC_NUMERIC);
    assert_non_null(strstr(error.text, "nan in channel 0 of the sample at (0.00"));
    assert_int_equal(asc_estimate(estimator, &group, edge_and_product, NULL, &out, NULL), ASC_OK); /* no other output */
    out.means = NULL;
    assert_int_equal(asc_estimate(estimator, &group, fails, NULL, &out, &error), ASC_INVALID_ARGUMENT);
    out.means = means;
    group.rows = 0;
    assert_int_equal(asc_estimate(estimator, &group, fails, NULL, &out, &error), ASC_INVALID_ARGUMENT);
    group = (asc_group){INT32_MAX, 0, 2, 1};
    assert_int_equal(asc_estimate(estimator, &group, fails, NULL, &out, &error), ASC_INVALID_ARGUMENT);
    asc_estimator_destroy(estimator);
  }
  asc_sampler_destroy(sampler);
}

static void what_creation_refuses(void **state) {
  (void)state;
  asc_sampler *random = sampler_of("random", 64, 2), *jittered = sampler_of("jittered", 64, 2);
  asc_sampler *rule = sampler_of("gauss-legendre", 64, 2);
  assert_not_made("studnt-t", random, 1, ASC_UNKNOWN_NAME, "student-t");
  assert_not_made("student-t:tolerence=1", random, 1, ASC_UNKNOWN_KEY, "tolerance");
  assert_not_made("student-t:confidence=1", random, 1, ASC_INVALID_VALUE, "confidence");
  assert_not_made("student-t:minimum=65", random, 1, ASC_INVALID_VALUE, "64 samples");
  assert_not_made("chi-squared:minimum=33,unbiased=1", random, 1, ASC_INVALID_VALUE, "32 samples");
  assert_not_made("student-t", jittered, 1, ASC_UNSUPPORTED, "no sequence");
  assert_not_made("stratified", jittered, 1, ASC_UNSUPPORTED, "no sequence");
  assert_not_made("chi-squared", rule, 1, ASC_UNSUPPORTED, "gauss-legendre");
  assert_not_made("fixed:n=16", jittered, 1, ASC_UNSUPPORTED, "sequence");
  assert_not_made("fixed:n=65", random, 1, ASC_INVALID_VALUE, "64");
  assert_not_made("stratified:k=3", random, 1, ASC_INVALID_VALUE, "9 cells");
  assert_not_made("fixed", random, 0, ASC_INVALID_ARGUMENT, "channels");
  assert_not_made("fixed", random, 17, ASC_INVALID_ARGUMENT, "channels");
  assert_not_made("fixed", NULL, 1, ASC_INVALID_ARGUMENT, "sampler");
  char canonical[64];
  assert_int_equal(asc_estimator_canonical("student-t:unbiased=1,confidence=0.95,batch=4", canonical, 64, NULL),
                   ASC_OK);
  assert_string_equal(canonical, "student-t:batch=4,unbiased=1");
  assert_int_equal(asc_estimator_canonical("student-t", canonical, 4, NULL), ASC_INVALID_ARGUMENT);
  asc_sampler_destroy(random);
  asc_sampler_destroy(jittered);
  asc_sampler_destroy(rule);
}

/* The value of one pixel's samples, drawn here once more. */
static double value_of(const asc_sampler *sampler, uint64_t index, int32_t x) {
  double point[2], values[2];
  const asc_range range = {x, 0, index, 1, 0, 2};
  assert_int_equal(asc_sampler_fill(sampler, &range, point), ASC_OK);
  assert_int_equal(edge_and_product(NULL, 1, &(asc_pixel){x, 0}, point, values), ASC_OK);
  return values[1];
}

static asc_status product_alone(void *context, size_t count, const asc_pixel *pixels, const double *points,
                                double *values) {
  (void)context, (void)pixels;
  for (size_t i = 0; i < count; i++) values[i] = points[2 * i] * points[2 * i + 1];
  return ASC_OK;
}

/* By the definition, sample by sample, also beyond the quantiles that are kept. */
static void sequences_stop_where_the_definition_says(void **state) {
  (void)state;
  asc_sampler *sampler = sampler_of("random", 4000, 2), *fresh = NULL;
  const asc_sampler_desc other = {sizeof other, "random", 4000, 2, 5 ^ 0x9e3779b97f4a7c15u}; /* as estimator.h has it */
  assert_int_equal(asc_sampler_create(&other, &fresh, NULL), ASC_OK);
  const struct {
    const char *spec;
    double tolerance;
    uint64_t minimum, batch;
    int chi_squared, unbiased;
  } cases[] = {{"student-t:tolerance=0.03", 0.03, 8, 1, 0, 0},
               {"student-t:tolerance=0.012,batch=7,minimum=5", 0.012, 5, 7, 0, 0},
               {"chi-squared:tolerance=0.02,minimum=2", 0.02, 2, 1, 1, 0},
               {"student-t:tolerance=0.02,unbiased=1", 0.02, 8, 1, 0, 1},
               {"chi-squared:tolerance=1e-9,unbiased=1,batch=300", 1e-9, 8, 300, 1, 1}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    asc_estimator *estimator = estimator_of(cases[k].spec, sampler, 1);
    const result found = estimated(estimator, (asc_group){0, 0, 20, 1}, product_alone, NULL);
    const uint64_t most = cases[k].unbiased ? 2000 : 4000;
    for (int32_t x = 0; x < 20; x++) {
      asc_moments moments = {0};
      uint64_t wanted = cases[k].minimum;
      for (;;) {
        while (moments.count < wanted) {
          const double value = value_of(sampler, moments.count, x);
          assert_int_equal(asc_moments_add(&moments, &value, 1), ASC_OK);
        }
        double low, high, quantile;
        assert_int_equal(asc_moments_interval(&moments, 0.95, &low, &high), ASC_OK);
        assert_int_equal(asc_chi_squared_quantile(0.05, (double)wanted - 1.0, &quantile), ASC_OK);
        const double bound =
            cases[k].chi_squared ? sqrt(moments.squares / quantile / (double)wanted) : 0.5 * (high - low);
        if (bound <= cases[k].tolerance || wanted == most) break;
        wanted = wanted + cases[k].batch < most ? wanted + cases[k].batch : most;
      }
      if (cases[k].unbiased) {
        moments = (asc_moments){0};
        for (uint64_t i = 0; i < wanted; i++) {
          const double value = value_of(fresh, i, x);
          assert_int_equal(asc_moments_add(&moments, &value, 1), ASC_OK);
        }
      }
      asc_moments_summary summary;
      assert_int_equal(asc_moments_summarise(&moments, &summary), ASC_OK);
      assert_int_equal(found.counts[x], cases[k].unbiased ? 2 * wanted : wanted);
      assert_true(found.means[x] == summary.mean && found.errors[x] == summary.standard_error);
      assert_true(found.degrees[x] == (double)wanted - 1.0);
    }
    asc_estimator_destroy(estimator);
  }
  asc_sampler_destroy(fresh);
  asc_sampler_destroy(sampler);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pixels_do_not_depend_on_their_group),      cmocka_unit_test(errors_are_given_on),
      cmocka_unit_test(the_pixel_that_was_asked_for_is_named),    cmocka_unit_test(what_creation_refuses),
      cmocka_unit_test(sequences_stop_where_the_definition_says),
  };
  return cmocka_run_group_tests_name("estimate_contracts", tests, NULL, NULL);
}

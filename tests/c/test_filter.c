/* The reconstruction filters: what holds for every registered one, and the published values of each. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/filter.h"
#include "profile.h"

#define EPSILON 2.220446049250313e-16

static const char *const specs[] = {"box",
                                    "box:radius=1.3",
                                    "tent",
                                    "tent:radius=2.75",
                                    "gaussian",
                                    "gaussian:radius=8",
                                    "mitchell",
                                    "mitchell:b=1.5,c=-0.25",
                                    "catmull-rom",
                                    "mitchell:radius=3.1",
                                    "lanczos",
                                    "lanczos:lobes=1",
                                    "lanczos:lobes=8",
                                    "blackman-harris",
                                    "blackman-harris:radius=0.5",
                                    "multi-stage",
                                    "multi-stage:radius=4.5"};
#define SPECS (sizeof specs / sizeof *specs)

static asc_filter *make(const char *spec) {
  const asc_filter_desc desc = {sizeof desc, spec};
  asc_filter *filter = NULL;
  asc_error error = {{0}};
  if (asc_filter_create(&desc, &filter, &error)) fail_msg("%s: %s", spec, error.text);
  return filter;
}

static double at(const asc_filter *filter, double x) {
  double value = NAN;
  assert_int_equal(asc_filter_evaluate(filter, &x, 1, &value), ASC_OK);
  return value;
}

static double between(const asc_filter *filter, double a, double b) {
  double integral = NAN;
  assert_int_equal(asc_filter_integral(filter, a, b, &integral), ASC_OK);
  return integral;
}

static void every_registered_filter_is_tested(void **state) {
  (void)state;
  for (size_t i = 0; i < asc_filter_count(); i++) {
    asc_filter_info info;
    assert_int_equal(asc_filter_describe(i, &info), ASC_OK);
    int found = 0;
    for (size_t k = 0; k < SPECS; k++) found |= strcmp(specs[k], info.name) == 0;
    if (!found) fail_msg("no test of %s", info.name);
    assert_true(info.title && info.source && info.parameter_count >= 1);
  }
  asc_filter_info info;
  assert_int_equal(asc_filter_describe(asc_filter_count(), &info), ASC_INVALID_ARGUMENT);
}

static void profiles_are_even_and_zero_past_their_radius(void **state) {
  (void)state;
  for (size_t k = 0; k < SPECS; k++) {
    asc_filter *filter = make(specs[k]);
    const double radius = asc_filter_radius(filter);
    for (int i = 0; i < 997; i++) {
      const double x = radius * i / 997;
      assert_true(at(filter, x) == at(filter, -x));
    }
    assert_true(at(filter, radius) == 0.0 && at(filter, nextafter(-radius, -9.0)) == 0.0);
    assert_true(at(filter, 1e300) == 0.0 && at(filter, -INFINITY) == 0.0 && at(filter, NAN) == 0.0);
    asc_filter_destroy(filter);
  }
  asc_filter *box = make("box"); /* half open, as pixels are */
  assert_true(at(box, -0.5) == 1.0 && at(box, nextafter(0.5, 0.0)) == 1.0 && at(box, 0.5) == 0.0);
  asc_filter_destroy(box);
}

/* Against the trapezium rule with 2^14 steps of h <= 1e-3: of smooth profiles it is within f'' h^2 / 12 of the width,
 * 1e-5 with f'' up to 100 and widths up to 1, less for the wider, which are flatter. */
static void integrals_are_those_of_the_profile(void **state) {
  (void)state;
  enum { STEPS = 1 << 14 };
  for (size_t k = 0; k < SPECS; k++) {
    asc_filter *filter = make(specs[k]);
    const double radius = asc_filter_radius(filter);
    /* Forms that cancel: four roundings of sums whose terms are below 8. */
    assert_true(fabs(between(filter, -INFINITY, INFINITY) - 1.0) < 32 * EPSILON);
    assert_true(between(filter, -radius, radius) == between(filter, -9.0, 1e9));
    assert_true(between(filter, 0.3, -0.1) == -between(filter, -0.1, 0.3));
    const double a = -0.83 * radius, b = 0.71 * radius;
    double sum = 0.0;
    for (int i = 0; i <= STEPS; i++)
      sum += at(filter, a + (b - a) * i / STEPS) * (i == 0 || i == STEPS ? 0.5 : 1.0) * (b - a) / STEPS;
    assert_true(fabs(sum - between(filter, a, b)) < 1e-5);
    asc_filter_destroy(filter);
  }
}

static void these_add_up_to_one_everywhere(void **state) {
  (void)state;
  const char *const those[] = {"box",
                               "box:radius=1",
                               "tent",
                               "tent:radius=2",
                               "catmull-rom",
                               "mitchell",
                               "mitchell:b=1,c=0",
                               "mitchell:b=-0.7,c=1.9"};
  for (size_t k = 0; k < sizeof those / sizeof *those; k++) {
    asc_filter *filter = make(those[k]);
    for (int i = 0; i <= 1000; i++) {
      double sum = 0.0, x = i / 1000.0;
      for (int shift = -3; shift <= 3; shift++) sum += at(filter, x + shift);
      assert_true(fabs(sum - 1.0) < 64 * EPSILON); /* terms up to 10 in four cubics of six operations */
    }
    asc_filter_destroy(filter);
  }
}

/* The values of the papers' formulas, worked out by hand. */
static void published_values(void **state) {
  (void)state;
  const struct {
    const char *spec;
    double x, value;
  } known[] = {
      {"tent", 0.25, 0.75},
      {"tent:radius=2", 1, 0.25},
      {"box:radius=2", 1.9, 0.25},
      {"mitchell", 0, 8.0 / 9},
      {"mitchell", 1, 1.0 / 18},
      {"mitchell", 1.5, -5.0 / 144},
      {"mitchell:radius=4", 2, 1.0 / 36},
      {"mitchell:b=1,c=0", 0, 2.0 / 3}, /* the cubic B-spline */
      {"mitchell:b=1,c=0", 1, 1.0 / 6},
      {"mitchell:b=0,c=0", 0.5, 0.5}, /* Hermite */
      {"catmull-rom", 0, 1},
      {"catmull-rom", 1, 0},
      {"catmull-rom", 0.5, 9.0 / 16},
      {"catmull-rom", 1.5, -1.0 / 16},
  };
  for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
    asc_filter *filter = make(known[k].spec);
    assert_true(fabs(at(filter, known[k].x) - known[k].value) < 16 * EPSILON); /* a cubic of six operations */
    asc_filter_destroy(filter);
  }
}

static void sin_pi_is_exact_where_it_should_be(void **state) {
  (void)state;
  for (int i = -1000; i <= 1000; i++) {
    assert_true(asc_sin_pi(i) == 0.0);
    assert_true(fabs(asc_sin_pi(i + 0.5) - (i % 2 ? -1.0 : 1.0)) <= EPSILON);
    const double x = i / 997.0;
    assert_true(fabs(asc_sin_pi(x) - sin(3.141592653589793238 * x)) < 4 * EPSILON); /* pi x is rounded */
  }
}

static void responses(void **state) {
  (void)state;
  const double pi = 3.141592653589793238;
  for (size_t k = 0; k < SPECS; k++) {
    asc_filter *filter = make(specs[k]);
    const double frequencies[] = {0.0, 0.37, -0.37};
    double response[3];
    assert_int_equal(asc_filter_response(filter, frequencies, 3, response), ASC_OK);
    assert_true(fabs(response[0] - 1.0) < 1e-14 && response[1] == response[2]);
    const double bad[] = {1000.5};
    assert_int_equal(asc_filter_response(filter, bad, 1, response), ASC_INVALID_ARGUMENT);
    asc_filter_destroy(filter);
  }
  asc_filter *box = make("box"), *tent = make("tent");
  for (int i = 1; i <= 200; i++) {
    const double f = 1.3 * i, sinc = sin(pi * f) / (pi * f);
    double of_box, of_tent;
    assert_int_equal(asc_filter_response(box, &f, 1, &of_box), ASC_OK);
    assert_int_equal(asc_filter_response(tent, &f, 1, &of_tent), ASC_OK);
    /* The header's bound. */
    assert_true(fabs(of_box - sinc) < 1e-12 && fabs(of_tent - sinc * sinc) < 1e-12);
  }
  asc_filter_destroy(box);
  asc_filter_destroy(tent);
}

static void many_positions_equal_one_at_a_time(void **state) {
  (void)state;
  enum { N = 1000 }; /* more than one piece of 256, and no multiple of it */
  for (size_t k = 0; k < SPECS; k++) {
    asc_filter *filter = make(specs[k]);
    double x[N], values[N];
    for (int i = 0; i < N; i++) x[i] = 0.019 * (i - 500);
    assert_int_equal(asc_filter_evaluate(filter, x, N, values), ASC_OK);
    for (int i = 0; i < N; i++) assert_true(values[i] == at(filter, x[i]));
    asc_filter_destroy(filter);
  }
}

static void specs_have_one_canonical_form(void **state) {
  (void)state;
  const char *const forms[][2] = {{"box:radius=0.50", "box"},
                                  {"mitchell:c=0.25,b=0.5", "mitchell:b=0.5,c=0.25"},
                                  {"mitchell:b=0.3333", "mitchell:b=0.3333"},
                                  {"mitchell:b=0.3333333333333333,radius=2", "mitchell"},
                                  {"lanczos:lobes=3", "lanczos"},
                                  {"catmull-rom:radius=3", "catmull-rom:radius=3"}};
  for (size_t k = 0; k < sizeof forms / sizeof *forms; k++) {
    asc_filter *filter = make(forms[k][0]);
    asc_filter_desc resolved;
    assert_int_equal(asc_filter_resolved(filter, &resolved), ASC_OK);
    assert_string_equal(resolved.spec, forms[k][1]);
    asc_filter_destroy(filter);
  }
}

static void refusals(void **state) {
  (void)state;
  const struct {
    const char *spec;
    asc_status status;
    const char *text;
  } wrong[] = {
      {"mitchel", ASC_UNKNOWN_NAME, "unknown filter \"mitchel\"; did you mean \"mitchell\"?"},
      {"", ASC_INVALID_ARGUMENT, "the filter's spec \"\" has no name"},
      {"gaussian:sigmo=1", ASC_UNKNOWN_KEY, "filter \"gaussian\": unknown key \"sigmo\"; did you mean \"sigma\"?"},
      {"lanczos:radius=2", ASC_UNKNOWN_KEY, "known: lobes"},
      {"lanczos:lobes=2.5", ASC_INVALID_VALUE, "filter \"lanczos\": lobes=\"2.5\" is not a whole number"},
      {"tent:radius=0.4", ASC_INVALID_VALUE, "lies outside [0.5, 8]"},
      {"tent:radius=nan", ASC_INVALID_VALUE, "not a number"},
      {"box:radius", ASC_INVALID_VALUE, "key=value"},
  };
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    const asc_filter_desc desc = {sizeof desc, wrong[k].spec};
    asc_filter *filter = NULL;
    asc_error error = {{0}};
    assert_int_equal(asc_filter_create(&desc, &filter, &error), wrong[k].status);
    if (!strstr(error.text, wrong[k].text)) fail_msg("%s: %s", wrong[k].spec, error.text);
    assert_int_equal(asc_filter_create(&desc, &filter, NULL), wrong[k].status);
    assert_null(filter);
  }
  asc_filter *box = make("box");
  const double x = 0.0;
  double value;
  const asc_filter_desc short_desc = {1, "box"};
  asc_filter *none = NULL;
  assert_int_equal(asc_filter_create(&short_desc, &none, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_filter_evaluate(NULL, &x, 1, &value), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_filter_evaluate(box, NULL, 1, &value), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_filter_evaluate(box, NULL, 0, NULL), ASC_OK);
  assert_int_equal(asc_filter_integral(box, NAN, 1, &value), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_filter_resolved(NULL, NULL), ASC_INVALID_ARGUMENT);
  asc_filter_destroy(box);
  asc_filter_destroy(NULL);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_registered_filter_is_tested),
      cmocka_unit_test(profiles_are_even_and_zero_past_their_radius),
      cmocka_unit_test(integrals_are_those_of_the_profile),
      cmocka_unit_test(these_add_up_to_one_everywhere),
      cmocka_unit_test(published_values),
      cmocka_unit_test(sin_pi_is_exact_where_it_should_be),
      cmocka_unit_test(responses),
      cmocka_unit_test(many_positions_equal_one_at_a_time),
      cmocka_unit_test(specs_have_one_canonical_form),
      cmocka_unit_test(refusals),
  };
  return cmocka_run_group_tests_name("filter", tests, NULL, NULL);
}

/* Weights of unevenly spread samples: exact fractions, what holds for every method, and extremes. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "aliascope/uneven.h"
#include "predicates.h"

#define EPSILON 2.220446049250313e-16
#define MOST 4096

static double points[2 * MOST], weights[MOST];

static asc_filter *make(const char *spec) {
  const asc_filter_desc desc = {sizeof desc, spec};
  asc_filter *filter = NULL;
  if (spec) assert_int_equal(asc_filter_create(&desc, &filter, NULL), ASC_OK);
  return filter;
}

static asc_status weigh(const char *spec, const char *filter_spec, const double *at, size_t count, double *made,
                        asc_error *error) {
  asc_filter *filter = make(filter_spec);
  const asc_uneven_desc desc = {sizeof desc, spec, filter, at, count};
  const asc_status status = asc_uneven_weights(&desc, made, error);
  asc_filter_destroy(filter);
  return status;
}

/* Random numbers in [0, 1) that a count gives. */
static double drawn(uint32_t index) {
  uint32_t bits = index * 2654435769u + 1u;
  bits = (bits ^ (bits >> 16)) * 0x7feb352du;
  bits = (bits ^ (bits >> 15)) * 0x846ca68bu;
  return (double)(bits ^ (bits >> 16)) * 0x1p-32;
}

typedef enum way { UNIFORM, CORNER, LINE, SLANTED, CIRCLE, WHEEL, GRID, ONE_PLACE, TWO_PLACES, BORDER, WAYS } way;

/* About the pixel's centre. */
static void spread(way how, size_t count) {
  for (uint32_t i = 0; i < count; i++) {
    double *at = points + (size_t)2 * i;
    const double a = drawn(2 * i) - 0.5, b = drawn(2 * i + 1) - 0.5, turn = 6.283185307179586 * i / (double)count;
    at[0] = a, at[1] = b;
    if (how == CORNER) at[0] = 0.5 - 1e-6 * (a + 0.5), at[1] = 0.5 - 1e-6 * (b + 0.5);
    if (how == LINE) at[1] = 0.125;
    if (how == SLANTED) at[1] = 0.375 * a;
    if (how == CIRCLE || how == WHEEL) at[0] = 0.4 * cos(turn), at[1] = 0.4 * sin(turn);
    if (how == WHEEL && i == 0) at[0] = at[1] = 0.0;
    if (how == GRID) at[0] = (i % 64) / 63.0 - 0.5, at[1] = (double)(i / 64) / 63.0 - 0.5;
    if (how == ONE_PLACE) at[0] = 0.1, at[1] = -0.2;
    if (how == TWO_PLACES) at[0] = i % 2 ? 0.25 : -0.25, at[1] = 0.0;
    if (how == BORDER) at[i % 2] = i % 4 < 2 ? 0.5 : -0.5;
  }
}

static long double sum_of(const double *values, size_t count) {
  long double sum = 0.0L;
  for (size_t i = 0; i < count; i++) sum += values[i];
  return sum;
}

static const struct {
  const char *spec, *filter;
} methods[] = {{"average", NULL},
               {"average", "mitchell"},
               {"area", NULL},
               {"area", "box:radius=0.75"},
               {"area", "tent"},
               {"area", "gaussian"},
               {"area", "lanczos"},
               {"multi-stage", NULL},
               {"multi-stage", "multi-stage:radius=4.5"},
               {"inverse-density", NULL},
               {"inverse-density:neighbours=32", "blackman-harris"}};
#define METHODS (sizeof methods / sizeof *methods)

static void every_method_is_tested(void **state) {
  (void)state;
  for (size_t i = 0; i < asc_weighting_count(); i++) {
    asc_weighting_info info;
    assert_int_equal(asc_weighting_describe(i, &info), ASC_OK);
    int found = 0;
    for (size_t k = 0; k < METHODS; k++) found |= strcmp(methods[k].spec, info.name) == 0;
    assert_true(found && info.title && info.source);
  }
  asc_weighting_info info;
  assert_int_equal(asc_weighting_describe(asc_weighting_count(), &info), ASC_INVALID_ARGUMENT);
}

static void assert_areas(const double *at, size_t count, const double *expected) {
  assert_int_equal(weigh("area", NULL, at, count, weights, NULL), ASC_OK);
  for (size_t i = 0; i < count; i++) /* sides of a few roundings each */
    if (fabs(weights[i] - expected[i]) > 4 * EPSILON) fail_msg("cell %zu: %.17g", i, weights[i]);
}

static void cells_are_the_known_fractions(void **state) {
  (void)state;
  assert_areas((double[]){-0.25, 0, 0, 0, 0.25, 0}, 3, (double[]){3.0 / 8, 1.0 / 4, 3.0 / 8});
  assert_areas((double[]){0.5, 0.5, 0.5, 0.5, -0.5, -0.5}, 3, (double[]){0.25, 0.25, 0.5});
  assert_areas((double[]){0, -0.5, 0, 0.5, 0, 0.5, 0, 0.5}, 4, (double[]){1.0 / 2, 1.0 / 6, 1.0 / 6, 1.0 / 6});
  /* The middle, and the middles of the sides: a square of half the area, and the four corners. */
  assert_areas((double[]){0, 0, 0.5, 0.5, -0.5, 0.5, -0.5, -0.5, 0.5, -0.5}, 5,
               (double[]){0.5, 0.125, 0.125, 0.125, 0.125});
  for (uint32_t side = 1; side <= 24; side++) { /* four sites on a circle, everywhere */
    for (uint32_t i = 0; i < side * side; i++) {
      points[2 * i] = (i % side + 0.5) / side - 0.5;
      points[2 * i + 1] = ((double)(i / side) + 0.5) / side - 0.5;
    }
    assert_int_equal(weigh("area", NULL, points, side * side, weights, NULL), ASC_OK);
    /* The places are read to 2^-52, and a cell's sides of 1/side lie between four of them. */
    for (uint32_t i = 0; i < side * side; i++) assert_true(fabs(weights[i] - 1.0 / (side * side)) < 4 * EPSILON / side);
  }
}

/* The border is closed, and the filter has there what it has just inside. */
static void one_sample_has_it_all(void **state) {
  (void)state;
  for (size_t k = 0; k < METHODS; k++) {
    assert_int_equal(weigh(methods[k].spec, methods[k].filter, (double[]){0.1, -0.3}, 1, weights, NULL), ASC_OK);
    assert_true(weights[0] == 1.0);
  }
  assert_int_equal(weigh("average", "box", (double[]){0.5, -0.5}, 1, weights, NULL), ASC_OK);
  assert_true(weights[0] == 1.0);
}

/* Weights are rounded once each after the sum is known, so theirs is 1 within half an epsilon times the sum of their
 * sizes, which is below 4 here. The sum is what users rely on to 1e-13. */
static void weights_add_up_to_one_wherever_the_samples_are(void **state) {
  (void)state;
  static const size_t counts[] = {2, 3, 4, 5, 7, 64, MOST};
  for (size_t k = 0; k < METHODS; k++)
    for (int how = 0; how < WAYS; how++)
      for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        spread((way)how, counts[c]);
        asc_error error = {{0}};
        if (weigh(methods[k].spec, methods[k].filter, points, counts[c], weights, &error))
          fail_msg("%s, way %d, %zu: %s", methods[k].spec, how, counts[c], error.text);
        const double sum = (double)sum_of(weights, counts[c]);
        if (!(fabs(sum - 1.0) < 4 * EPSILON)) fail_msg("%s, way %d: %.17g", methods[k].spec, how, sum);
        const int lobes = methods[k].filter && strchr("ml", methods[k].filter[0]) != NULL;
        for (size_t i = 0; i < counts[c] && !lobes; i++) assert_true(weights[i] >= 0.0);
        if (how == ONE_PLACE)
          for (size_t i = 0; i < counts[c]; i++) assert_true(weights[i] == weights[0]);
      }
}

/* Not by dividing: the areas themselves. Corners are good to some epsilon of the side of the square, so a cell is to
 * some epsilon times its girth, at most 4. */
static void cells_fill_the_bounds(void **state) {
  (void)state;
  const double bounds[4] = {-0.5, -0.5, 0.5, 0.5};
  for (int how = 0; how < WAYS; how++) {
    spread((way)how, MOST);
    assert_int_equal(asc_voronoi_areas(points, MOST, bounds, weights, NULL), ASC_OK);
    assert_true(fabs((double)sum_of(weights, MOST) - 1.0) < 1e-13);
  }
  spread(UNIFORM, MOST);
  for (size_t i = 0; i < MOST; i++) points[2 * i] = 1e6 + 3e-5 * points[2 * i];
  const double narrow[4] = {1e6 - 2e-5, -0.5, 1e6 + 1e-5, 7.0};
  assert_int_equal(asc_voronoi_areas(points, MOST, narrow, weights, NULL), ASC_INVALID_ARGUMENT);
  const double wide[4] = {1e6 - 2e-5, -0.5, 1e6 + 2e-5, 7.0};
  assert_int_equal(asc_voronoi_areas(points, MOST, wide, weights, NULL), ASC_OK);
  const double area = (wide[2] - wide[0]) * 7.5;
  assert_true(fabs((double)sum_of(weights, MOST) - area) < 1e-12 * area);
}

/* Each sample keeps its weight, to the last bit, when they are turned around and when every other comes first. */
static void the_order_of_the_samples_does_not_matter(void **state) {
  (void)state;
  static double others[2 * MOST], moved[MOST];
  for (size_t k = 0; k < METHODS; k++)
    for (int how = 0; how < WAYS; how++) {
      const size_t count = 500;
      spread((way)how, count);
      assert_int_equal(weigh(methods[k].spec, methods[k].filter, points, count, weights, NULL), ASC_OK);
      for (size_t stride = 7; stride < count; stride += 492) { /* 7 and 499, which 500 has no factor of */
        for (size_t i = 0; i < count; i++)
          memcpy(others + 2 * i, points + 2 * (i * stride % count), 2 * sizeof *points);
        assert_int_equal(weigh(methods[k].spec, methods[k].filter, others, count, moved, NULL), ASC_OK);
        for (size_t i = 0; i < count; i++) assert_true(moved[i] == weights[i * stride % count]);
      }
    }
}

/* Areas with a sum so near the middle between two doubles that the order of its terms decides between them (found by
 * fuzz_filter): four samples, then one and its copies. */
static void a_sum_between_two_doubles_has_one_side(void **state) {
  (void)state;
  const size_t count = 22, alone = 6;
  const double at[2 * 7] = {0.0,
                            -0x1.fffff5p-2,
                            0x1.8383838383838p-2,
                            0x1.9595959595958p-3,
                            -0.5,
                            -0.5,
                            0x1.ffffffffffffep-2,
                            -0x1.cbcbcbcbcbcbdp-2,
                            -0x1.ffffffffffff6p-2,
                            -0.5,
                            -0x1.ffffffffffff6p-2,
                            0x1.ffffffffffffep-2,
                            -0.5,
                            0x1.ffffffffffffep-2};
  double others[2 * 22], moved[22];
  for (size_t i = 0; i < count; i++) memcpy(points + 2 * i, at + 2 * (i < alone ? i : alone), 2 * sizeof *points);
  assert_int_equal(weigh("area", NULL, points, count, weights, NULL), ASC_OK);
  for (size_t by = 1; by < count; by++) {
    for (size_t i = 0; i < count; i++) memcpy(others + 2 * ((i + by) % count), points + 2 * i, 2 * sizeof *points);
    assert_int_equal(weigh("area", NULL, others, count, moved, NULL), ASC_OK);
    for (size_t i = 0; i < count; i++) assert_true(moved[(i + by) % count] == weights[i]);
  }
}

static void assert_refused(const char *spec, const char *filter, const double *at, size_t count, asc_status status,
                           const char *text) {
  asc_error error = {{0}};
  assert_int_equal(weigh(spec, filter, at, count, weights, &error), status);
  if (!strstr(error.text, text)) fail_msg("%s", error.text);
}

static void what_cannot_be_weighted_is_refused(void **state) {
  (void)state;
  const double at[4] = {0.1, 0.2, 0.3, 0.4};
  assert_refused("area", NULL, at, 0, ASC_INVALID_ARGUMENT, "no samples");
  assert_refused("area", NULL, NULL, 3, ASC_INVALID_ARGUMENT, "no samples");
  assert_refused("area", NULL, at, ASC_UNEVEN_MOST + (size_t)1, ASC_INVALID_ARGUMENT, "at most 16777216");
  assert_refused("area", NULL, (double[]){0, 0, 0, NAN}, 2, ASC_INVALID_ARGUMENT, "sample 1 at (0, nan) is nowhere");
  assert_refused("average", NULL, (double[]){-INFINITY, 0}, 1, ASC_INVALID_ARGUMENT, "nowhere");
  assert_refused("area", NULL, (double[]){0, 0.51}, 1, ASC_INVALID_ARGUMENT, "reaches 0.5 pixels");
  assert_refused("area", "tent", (double[]){0, 0, -1.01, 0}, 2, ASC_INVALID_ARGUMENT, "sample 1");
  assert_refused("multi-stage", "tent", at, 2, ASC_UNSUPPORTED, "it takes multi-stage, not tent");
  assert_refused("area:radius=1", NULL, at, 2, ASC_UNKNOWN_KEY, "radius");
  assert_refused("inverse-density:neighbours=0", NULL, at, 2, ASC_INVALID_VALUE, "neighbours");
  assert_refused("voronoi", NULL, at, 2, ASC_UNKNOWN_NAME, "unknown weighting");
  assert_refused("average", "lanczos", (double[]){1.5, 0.1}, 1, ASC_NUMERIC, "no average");
  assert_refused("multi-stage", NULL, (double[]){1.125, 1.125}, 1, ASC_NUMERIC, "adds up to 0");
  const asc_uneven_desc empty = {0};
  assert_int_equal(asc_uneven_weights(&empty, weights, NULL), ASC_INVALID_ARGUMENT);
  for (int i = 0; i < 4; i++) {
    const double bounds[4][4] = {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 0, NAN, 1}, {0, 0, INFINITY, 1}};
    assert_int_equal(asc_voronoi_areas((double[]){0, 0}, 1, bounds[i], weights, NULL), ASC_INVALID_ARGUMENT);
  }
}

/* One step inside or outside a circle of radius 2^51, which doubles cannot tell. */
/* The line between two that are close turns with their places: it is that of the samples, not of places on a grid. The
 * areas in fractions of the same doubles; the tolerance is of twelve digits. */
static void close_samples_keep_their_line(void **state) {
  (void)state;
  const double at[] = {0.0, 0.0, 2.3e-8, 1.7e-8, 0.25, -0.375};
  const double areas[] = {0.3863803248814636298658, 0.376314993747328168951, 0.2373046813712082011832};
  assert_int_equal(weigh("area", NULL, at, 3, weights, NULL), ASC_OK);
  for (size_t i = 0; i < 3; i++)
    if (!(fabs(weights[i] - areas[i]) <= 1e-12 * areas[i])) fail_msg("%.17g is not %.17g", weights[i], areas[i]);
  const double swapped[] = {2.3e-8, 1.7e-8, 0.25, -0.375, 0.0, 0.0};
  double others[3];
  assert_int_equal(weigh("area", NULL, swapped, 3, others, NULL), ASC_OK);
  assert_true(others[0] == weights[1] && others[1] == weights[2] && others[2] == weights[0]);
  /* Those in one step of the grid share, whatever their order. */
  const double together[] = {1e-20, 0.0, 0.0, 3e-20, 0.25, -0.375}, turned[] = {0.25, -0.375, 0.0, 3e-20, 1e-20, 0.0};
  assert_int_equal(weigh("area", NULL, together, 3, weights, NULL), ASC_OK);
  assert_int_equal(weigh("area", NULL, turned, 3, others, NULL), ASC_OK);
  assert_true(weights[0] == weights[1] && others[0] == weights[2] && others[1] == weights[0]);
}

/* A rounding above it there is no double. */
static void a_cell_of_the_largest_area_is_finite(void **state) {
  (void)state;
  const double bounds[] = {0x1.f5f5f5p-121, -1.0, DBL_MAX, 0.0};
  double area = 0.0;
  assert_int_equal(asc_voronoi_areas(bounds, 1, bounds, &area, NULL), ASC_OK);
  assert_true(area == DBL_MAX);
}

static void predicates_are_exact(void **state) {
  (void)state;
  const int64_t most = ASC_PLACE_MOST;
  const asc_place east = {most, 0}, north = {0, most}, west = {-most, 0}, south = {0, -most};
  assert_int_equal(asc_in_circle(east, north, west, south), 0);
  assert_int_equal(asc_in_circle(east, north, west, (asc_place){0, 1 - most}), 1);
  assert_int_equal(asc_in_circle(east, north, west, (asc_place){1, -most}), -1);
  assert_int_equal(asc_in_circle((asc_place){most - 1, 0}, north, west, south), -1);
  const asc_place corner = {most, most}, across = {-most, -most};
  assert_int_equal(asc_orientation(across, (asc_place){0, 0}, corner), 0);
  assert_int_equal(asc_orientation(across, (asc_place){0, -1}, corner), 1);
  assert_int_equal(asc_orientation(across, corner, (asc_place){most - 1, most - 2}), -1);
  assert_int_equal(asc_in_circle(across, (asc_place){most, -most}, corner, (asc_place){-most, most}), 0);
  assert_int_equal(asc_in_circle(across, (asc_place){most, -most}, corner, (asc_place){1 - most, most}), 1);
}

/* Half a step of the grid apart, they have other neighbours on it: cells that overlap came to 1.0025. */
static void cells_of_samples_within_a_step_fill_the_bounds(void **state) {
  (void)state;
  const double close[] = {0x1.656565656566cp-2, 0x1.6565656565656p-2, 0x1.6566492d685aap-2, 0x1.6565656795656p-2,
                          0x1.6565656565656p-2, 0x1.6565656565654p-2, 0x1.6565656565656p-2, 0x1.a5a5a5a5a5a5ap-2};
  const double bounds[] = {0.0, 0.0, 1.0, 1.0};
  double areas[4], sum = 0.0;
  assert_int_equal(asc_voronoi_areas(close, 4, bounds, areas, NULL), ASC_OK);
  for (int i = 0; i < 4; i++) sum += areas[i];
  assert_true(fabs(sum - 1.0) < 1e-12); /* four cells, a few roundings each */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_method_is_tested),
      cmocka_unit_test(cells_are_the_known_fractions),
      cmocka_unit_test(one_sample_has_it_all),
      cmocka_unit_test(weights_add_up_to_one_wherever_the_samples_are),
      cmocka_unit_test(cells_fill_the_bounds),
      cmocka_unit_test(the_order_of_the_samples_does_not_matter),
      cmocka_unit_test(a_sum_between_two_doubles_has_one_side),
      cmocka_unit_test(what_cannot_be_weighted_is_refused),
      cmocka_unit_test(close_samples_keep_their_line),
      cmocka_unit_test(cells_of_samples_within_a_step_fill_the_bounds),
      cmocka_unit_test(a_cell_of_the_largest_area_is_finite),
      cmocka_unit_test(predicates_are_exact),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

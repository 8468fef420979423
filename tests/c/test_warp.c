/* Warps: round trips, densities and Jacobians of each. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "warp_tools.h"

#define PI 3.14159265358979323846

typedef asc_status (*warp_function)(const double *from, size_t n, double *to);

static asc_status unit_triangle_pdf(const double *b, size_t n, double *pdf) {
  (void)b; /* as points (b0, b1) of the plane: of area 1/2 */
  const double vertices[9] = {1, 0, 0, 0, 1, 0, 0, 0, 0};
  for (size_t i = 0; i < n; i++)
    if (asc_triangle_pdf(vertices, &pdf[i], NULL)) return ASC_INVALID_ARGUMENT;
  return ASC_OK;
}

/* `area` columns of a point make the surface whose area the pdf is per. */
static const struct warp {
  const char *name;
  warp_function sample, inverse, pdf;
  size_t columns, area;
} warps[] = {
    {"disc", asc_disc_sample, asc_disc_inverse, asc_disc_pdf, 2, 2},
    {"cosine hemisphere", asc_cosine_hemisphere_sample, asc_cosine_hemisphere_inverse, asc_cosine_hemisphere_pdf, 3, 3},
    {"uniform hemisphere", asc_uniform_hemisphere_sample, asc_uniform_hemisphere_inverse, asc_uniform_hemisphere_pdf, 3,
     3},
    {"sphere", asc_sphere_sample, asc_sphere_inverse, asc_sphere_pdf, 3, 3},
    {"triangle", asc_triangle_sample, asc_triangle_inverse, unit_triangle_pdf, 3, 2},
};
#define WARPS (sizeof warps / sizeof *warps)

static double round_trip(const struct warp *warp, const double u[2]) {
  double point[3], back[2];
  assert_int_equal(warp->sample(u, 1, point), ASC_OK);
  assert_int_equal(warp->inverse(point, 1, back), ASC_OK);
  assert_true(back[0] >= 0.0 && back[0] <= 1.0 && back[1] >= 0.0 && back[1] <= 1.0);
  return fmax(fabs(back[0] - u[0]), fabs(back[1] - u[1]));
}

/* On a grid of the values where formulas change or digits run out, so also on all edges and corners, on the axes, on
 * the diagonals; then anywhere. */
static void inverses_undo_warps(void **state) {
  (void)state;
  const double ends[] = {0.0,  5e-324,    1e-300, 0x1p-60, 0x1p-53,       1e-9,          0.1,
                         0.25, 1.0 / 3.0, 0.5,    0.75,    1.0 - 0x1p-24, 1.0 - 0x1p-53, 1.0};
  const size_t count = sizeof ends / sizeof *ends;
  for (size_t k = 0; k < WARPS; k++) {
    double worst = 0.0;
    for (size_t i = 0; i < count; i++)
      for (size_t j = 0; j < count; j++) {
        const double u[2] = {ends[i], ends[j]};
        worst = fmax(worst, round_trip(&warps[k], u));
      }
    for (uint32_t i = 0; i < 200000; i++) {
      const double u[2] = {drawn(i, 0), drawn(i, 1)}, diagonal[2] = {u[0], u[0]}, other[2] = {u[0], 1.0 - u[0]};
      const double edges[4][2] = {{u[0], 0.0}, {u[0], 1.0}, {0.0, u[0]}, {1.0, u[0]}};
      worst = fmax(worst,
                   fmax(round_trip(&warps[k], u), fmax(round_trip(&warps[k], diagonal), round_trip(&warps[k], other))));
      for (int e = 0; e < 4; e++) worst = fmax(worst, round_trip(&warps[k], edges[e]));
    }
    if (worst > ASC_WARP_ROUND_TRIP) fail_msg("%s: off by %g after a round trip", warps[k].name, worst);
  }
}

/* The area that the square is stretched by, by differences, is 1/pdf. */
static void jacobians_are_the_inverse_of_the_pdf(void **state) {
  (void)state;
  const double h = 1e-6; /* of central differences: third derivatives h^2, rounding 1e-16/h, in all about 1e-9 */
  for (size_t k = 0; k < WARPS; k++)
    for (uint32_t i = 0; i < 20000; i++) {
      const double u[2] = {0.001 + 0.998 * drawn(i, 2), 0.001 + 0.998 * drawn(i, 3)};
      const double a = 2.0 * u[0] - 1.0, b = 2.0 * u[1] - 1.0;
      /* Away from the creases, where the map is continuous and its derivative is not, and from the disc's centre. */
      if (fabs(a) < 0.02 || fabs(b) < 0.02 || fabs(fabs(a) - fabs(b)) < 1e-4 || fabs(fabs(a) + fabs(b) - 1.0) < 1e-4)
        continue;
      const double near[4][2] = {{u[0] - h, u[1]}, {u[0] + h, u[1]}, {u[0], u[1] - h}, {u[0], u[1] + h}};
      double ends[4][3] = {{0}}, point[3], pdf, e[3] = {0}, f[3] = {0};
      for (int side = 0; side < 4; side++) assert_int_equal(warps[k].sample(near[side], 1, ends[side]), ASC_OK);
      for (size_t c = 0; c < warps[k].area; c++) {
        e[c] = (ends[1][c] - ends[0][c]) / (2.0 * h);
        f[c] = (ends[3][c] - ends[2][c]) / (2.0 * h);
      }
      const double area = hypot(hypot(e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2]), e[0] * f[1] - e[1] * f[0]);
      assert_int_equal(warps[k].sample(u, 1, point), ASC_OK);
      assert_int_equal(warps[k].pdf(point, 1, &pdf), ASC_OK);
      /* At 0.001 from the rim, derivatives of the square root in the cosine's z are up to 0.002^-2.5 of their size. */
      if (fabs(area * pdf - 1.0) > 1e-5)
        fail_msg("%s at (%g, %g): area times pdf %.9f", warps[k].name, u[0], u[1], area * pdf);
    }
}

static void densities_integrate_to_one(void **state) {
  (void)state;
  const size_t n = 2000;
  double disc = 0.0, cosine = 0.0, uniform = 0.0, sphere = 0.0, value;
  for (size_t i = 0; i < n; i++)
    for (size_t j = 0; j < n; j++) {
      const double x = -1.25 + 2.5 * ((double)i + 0.5) / (double)n, y = -1.25 + 2.5 * ((double)j + 0.5) / (double)n;
      assert_int_equal(asc_disc_pdf((double[]){x, y}, 1, &value), ASC_OK);
      disc += value * 6.25;
      const double z = x / 1.25, ring = sqrt(1.0 - z * z), longitude = PI * y / 1.25; /* Archimedes: equal areas */
      const double w[3] = {ring * cos(longitude), ring * sin(longitude), z};
      assert_int_equal(asc_cosine_hemisphere_pdf(w, 1, &value), ASC_OK);
      cosine += value * 4.0 * PI;
      assert_int_equal(asc_uniform_hemisphere_pdf(w, 1, &value), ASC_OK);
      uniform += value * 4.0 * PI;
      assert_int_equal(asc_sphere_pdf(w, 1, &value), ASC_OK);
      sphere += value * 4.0 * PI;
    }
  const double cells = (double)(n * n);
  /* The rim of the disc crosses about 8 n/2.5 of the n^2 cells, whose errors of random sign add up to 1e-5; the others
   * are smooth in z, and exact for the midpoint rule but for the rounding of 4 10^6 sums. */
  assert_true(fabs(disc / cells - 1.0) < 1e-4);
  assert_true(fabs(cosine / cells - 1.0) < 1e-9);
  assert_true(fabs(uniform / cells - 1.0) < 1e-9);
  assert_true(fabs(sphere / cells - 1.0) < 1e-9);
}

/* Cells of equal probability, found by coordinates that owe nothing to the warp. */
#define SIDE 16

static size_t cell_of(size_t warp, const double *p) {
  const double turn = atan2(p[1], p[0]) / (2.0 * PI) + 0.5;
  double level;
  switch (warp) {
  case 0:
  case 1: level = p[0] * p[0] + p[1] * p[1]; break; /* of the cosine hemisphere too: sin^2 */
  case 2: level = p[2]; break;
  case 3: level = 0.5 * (p[2] + 1.0); break;
  default: { /* by square roots, the classical map: Turk 1990, "Generating random points in triangles" */
    const double root = 1.0 - p[2];
    const size_t x = (size_t)fmin(root * root * SIDE, SIDE - 1), y = (size_t)fmin(p[0] / root * SIDE, SIDE - 1);
    return x * SIDE + y;
  }
  }
  return (size_t)fmin(level * SIDE, SIDE - 1) * SIDE + (size_t)fmin(turn * SIDE, SIDE - 1);
}

/* Chi-squared of 255 degrees of freedom, fixed numbers: above 377.1 once in a million (scipy.stats.chi2.isf). */
static void warped_points_have_the_density(void **state) {
  (void)state;
  const double draws = 1 << 20, limit = 377.1;
  for (size_t k = 0; k < WARPS; k++) {
    static double counts[SIDE * SIDE];
    memset(counts, 0, sizeof counts);
    for (uint32_t i = 0; i < (uint32_t)draws; i++) {
      double point[3];
      assert_int_equal(warps[k].sample((double[]){drawn(i, 4), drawn(i, 5)}, 1, point), ASC_OK);
      counts[cell_of(k, point)] += 1.0;
    }
    const double expected = draws / (SIDE * SIDE);
    double statistic = 0.0;
    for (size_t i = 0; i < SIDE * SIDE; i++) statistic += (counts[i] - expected) * (counts[i] - expected) / expected;
    if (statistic > limit) fail_msg("%s: chi-squared %g", warps[k].name, statistic);
  }
}

/* Every point that can be drawn is one that the pdf and the inverse take; directions have length 1. */
static void points_lie_in_their_domain(void **state) {
  (void)state;
  for (size_t k = 0; k < WARPS; k++)
    for (uint32_t i = 0; i < 100000; i++) {
      const double u[2] = {drawn(i, 6), i % 3 ? drawn(i, 7) : (double)(i % 2)}; /* a third on two of the edges */
      double p[3], pdf;
      assert_int_equal(warps[k].sample(u, 1, p), ASC_OK);
      assert_int_equal(warps[k].pdf(p, 1, &pdf), ASC_OK);
      assert_true(pdf > 0.0 || (k == 1 && p[2] == 0.0));
      if (k == 0) assert_true(hypot(p[0], p[1]) <= 1.0 + 2.0 * DBL_EPSILON);
      if (k >= 1 && k <= 3) assert_true(fabs(p[0] * p[0] + p[1] * p[1] + p[2] * p[2] - 1.0) < 4.0 * DBL_EPSILON);
      if (k == 1 || k == 2) assert_true(p[2] >= 0.0);
      if (k == 4) {
        assert_true(p[0] >= 0.0 && p[1] >= 0.0 && p[2] >= 0.0);
        assert_true(fabs(p[0] + p[1] + p[2] - 1.0) <= DBL_EPSILON);
      }
    }
}

/* Published: the corners of the square go to the disc's diagonals, its edges' middles to the axes (Shirley and Chiu);
 * the octahedron's vertices are the axes (Clarberg); the square's corners are the triangle's, and the middle of a side
 * (Heitz). */
static void corners_go_where_the_papers_say(void **state) {
  (void)state;
  const double half = sqrt(0.5);
  const struct {
    size_t warp;
    double u[2], point[3];
  } known[] = {
      {0, {1, 1}, {half, half, 0}},   {0, {0, 1}, {-half, half, 0}},
      {0, {1, 0.5}, {1, 0, 0}},       {0, {0.5, 0}, {0, -1, 0}},
      {0, {0.5, 0.5}, {0, 0, 0}},     {1, {0.5, 0.5}, {0, 0, 1}},
      {1, {0, 0}, {-half, -half, 0}}, {2, {0.5, 0.5}, {0, 0, 1}},
      {2, {0.5, 1}, {0, 1, 0}},       {3, {0.5, 0.5}, {0, 0, 1}},
      {3, {0, 0.5}, {-1, 0, 0}},      {3, {0.5, 1}, {0, 1, 0}},
      {3, {1, 0}, {0, 0, -1}},        {3, {0.75, 0.75}, {half, half, 0}},
      {4, {0, 0}, {0, 0, 1}},         {4, {1, 0}, {1, 0, 0}},
      {4, {0, 1}, {0, 1, 0}},         {4, {1, 1}, {0.5, 0.5, 0}},
  };
  for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
    double point[3] = {0};
    assert_int_equal(warps[known[i].warp].sample(known[i].u, 1, point), ASC_OK);
    for (int c = 0; c < 3; c++)
      if (fabs(point[c] - known[i].point[c]) > 4e-16) /* cos(pi/2) is 6e-17; a root and a product round */
        fail_msg("%s of (%g, %g): column %d is %g", warps[known[i].warp].name, known[i].u[0], known[i].u[1], c,
                 point[c]);
  }
}

static void what_lies_outside_is_refused(void **state) {
  (void)state;
  const double outside[] = {-0x1p-60, 1.0 + DBL_EPSILON, NAN, INFINITY, -INFINITY};
  for (size_t k = 0; k < WARPS; k++) {
    double out[3];
    for (size_t i = 0; i < 5; i++) {
      assert_int_equal(warps[k].sample((double[]){outside[i], 0.5}, 1, out), ASC_INVALID_ARGUMENT);
      assert_int_equal(warps[k].sample((double[]){0.5, outside[i]}, 1, out), ASC_INVALID_ARGUMENT);
    }
    const double bad[][3] = {{NAN, 0, 1}, {0, NAN, 1}, {1.1, 0, 0}, {0, -1.1, 0}, {INFINITY, 0, 0}};
    for (size_t i = 0; i < 5; i++) assert_int_equal(warps[k].inverse(bad[i], 1, out), ASC_INVALID_ARGUMENT);
    if (k >= 1 && k <= 3) assert_int_equal(warps[k].pdf((double[]){0.5, 0.5, 0.5}, 1, out), ASC_INVALID_ARGUMENT);
    if (k < 4) assert_int_equal(warps[k].pdf((double[]){NAN, 0, 1}, 1, out), ASC_INVALID_ARGUMENT);
    assert_int_equal(warps[k].sample(NULL, 1, out), ASC_INVALID_ARGUMENT);
    assert_int_equal(warps[k].sample((double[]){0, 0}, 1, NULL), ASC_INVALID_ARGUMENT);
    assert_int_equal(warps[k].sample(NULL, 0, NULL), ASC_OK);
  }
  double out[3];
  const double below[3] = {0.6, 0, -0.8};
  for (size_t k = 1; k < 3; k++) {
    assert_int_equal(warps[k].inverse(below, 1, out), ASC_INVALID_ARGUMENT);
    assert_int_equal(warps[k].pdf(below, 1, out), ASC_OK);
    assert_true(out[0] == 0.0);
  }
  assert_int_equal(asc_disc_pdf((double[]){0.8, 0.7}, 1, out), ASC_OK);
  assert_true(out[0] == 0.0);
  /* Points in float are taken. */
  for (size_t k = 0; k < WARPS; k++)
    for (uint32_t i = 0; i < 1000; i++) {
      double p[3], back[2];
      const double u[2] = {drawn(i, 8), i % 2 ? 1.0 : drawn(i, 9)};
      assert_int_equal(warps[k].sample(u, 1, p), ASC_OK);
      for (size_t c = 0; c < warps[k].columns; c++) p[c] = (double)(float)p[c];
      assert_int_equal(warps[k].inverse(p, 1, back), ASC_OK);
    }
}

static void triangles_have_an_area_or_are_refused(void **state) {
  (void)state;
  double pdf = 7.0;
  const double right[9] = {1, 1, 1, 1, 4, 1, 1, 1, 5};
  assert_int_equal(asc_triangle_pdf(right, &pdf, NULL), ASC_OK);
  assert_true(pdf == 1.0 / 6.0);
  const double flat[][9] = {{1, 2, 3, 1, 2, 3, 4, 5, 6},
                            {0, 0, 0, 1, 1, 1, 2, 2, 2},
                            {0, 0, 0, 0, 0, 0, 0, 0, 0},
                            {0, 0, NAN, 1, 0, 0, 0, 1, 0},
                            {0, 0, 0, INFINITY, 0, 0, 0, 1, 0}};
  for (size_t i = 0; i < sizeof flat / sizeof *flat; i++) {
    asc_error error = {{0}};
    assert_int_equal(asc_triangle_pdf(flat[i], &pdf, &error), ASC_INVALID_ARGUMENT);
    assert_true(strlen(error.text) > 20 && pdf == 1.0 / 6.0);
  }
}

/* Of a sliver almost all of the determinants cancels; its area in fractions of the same doubles. And no square of an
 * edge has to be a double. */
static void slivers_and_triangles_of_every_size_have_their_area(void **state) {
  (void)state;
  double pdf;
  const double sliver[9] = {0.1, 0.2, 0.3, 1.2, 0.9, -0.2, 0.65, 0.55, 0.05 + 0x1p-30};
  assert_int_equal(asc_triangle_pdf(sliver, &pdf, NULL), ASC_OK);
  assert_true(fabs(pdf / 1647044713.66843099870840552042 - 1.0) <= 1e-12);
  for (int exponent = -500; exponent <= 500; exponent += 100) {
    const double side = ldexp(1.0, exponent), right[9] = {0, 0, 0, 0, 3.0 * side, 0, 0, 0, 4.0 * side};
    assert_int_equal(asc_triangle_pdf(right, &pdf, NULL), ASC_OK);
    assert_true(pdf == ldexp(1.0 / 6.0, -2 * exponent));
  }
}

/* Samples are divided by the density, which is the height over the rim: it has its digits for u however near to 0. */
static void heights_over_the_rim(void **state) {
  (void)state;
  for (double u = 0.25; u > 1e-300; u *= 1e-7) {
    double w[3];
    const double edge[2] = {u, 0.5}, other[2] = {0.5, u};
    assert_int_equal(asc_cosine_hemisphere_sample(edge, 1, w), ASC_OK);
    assert_true(fabs(w[2] / (2.0 * sqrt(u) * sqrt(1.0 - u)) - 1.0) <= 1e-15);
    assert_int_equal(asc_uniform_hemisphere_sample(other, 1, w), ASC_OK);
    assert_true(fabs(w[2] / (4.0 * u * (1.0 - u)) - 1.0) <= 1e-15);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(inverses_undo_warps),
      cmocka_unit_test(jacobians_are_the_inverse_of_the_pdf),
      cmocka_unit_test(densities_integrate_to_one),
      cmocka_unit_test(warped_points_have_the_density),
      cmocka_unit_test(points_lie_in_their_domain),
      cmocka_unit_test(corners_go_where_the_papers_say),
      cmocka_unit_test(what_lies_outside_is_refused),
      cmocka_unit_test(triangles_have_an_area_or_are_refused),
      cmocka_unit_test(slivers_and_triangles_of_every_size_have_their_area),
      cmocka_unit_test(heights_over_the_rim),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* The root mean square discrepancy of random edges: exact for isotropic ones, drawn for the others.
 *
 * An isotropic edge is a line from the measure that is invariant under motions, restricted to lines that meet the unit
 * square; its discrepancy is mu(A) = n(A)/N - area(A), A what lies on one side of it. mu has mass 0 on the square, so
 * mu(A)^2 = -mu(A) mu(A') for A' the other side. The double integral of [the edge separates x and y] dmu dmu is
 * 2 mu(A) mu(A'). Lines that separate x and y have the measure 2 |x - y|, those that meet the square that of its
 * perimeter, 4 (Crofton; Santalo 1976, "Integral geometry and geometric probability", I.3). So
 *
 *   D^2 = E mu(A)^2 = -1/4 * double integral of |x - y| dmu dmu
 *       = 1/4 [ (2/N) sum_i phi(x_i) - (1/N^2) sum_ij |x_i - x_j| - (2 + sqrt 2 + 5 asinh 1) / 15 ],
 *
 * an energy distance (Szekely and Rizzo 2013), phi(x) the integral of |x - y| over y in the square, the last term the
 * mean distance of two points in it. For N random points E D^2 is 1/N of 1/4 of that mean distance: 0.361042^2 / N.
 *
 * At N points of a good set it is about 0.06 N^(-3/2) of terms near 1/2. So distances keep what they lose (kept.h), and
 * MIDDLE, near the mean distance, is taken off each term: 12 digits at 2^16 points. */
#include <math.h>
#include <stdlib.h>

#include "edges.h"
#include "kept.h"
#include "measure.h"
#include "vectorise.h"

#define RUN 64

#define MIDDLE (267.0L / 512.0L)
#define MEAN_DISTANCE_LESS_MIDDLE (-7.894183527932166901764e-5L) /* (2 + sqrt 2 + 5 asinh 1) / 15, less it */

/* side^3 [asinh(low / side) + asinh((1 - low) / side)] / 6, the part that a side of the point's four rectangles has in
 * phi; `to_low` and `to_high` are the distances to the corners that it leads to. One logarithm of a product: that loses
 * digits of what is small, but not against phi, which is 0.38 or more. */
static long double side_part(long double side, long double low, long double to_low, long double to_high) {
  if (side == 0.0L) return 0.0L;
  return side * side * side * logl((low + to_low) * (1.0L - low + to_high) / (side * side)) / 6.0L;
}

/* phi(x, y), by the integral over [0, a] x [0, b] of sqrt(u^2 + v^2) for the four rectangles around the point,
 * a b sqrt(a^2 + b^2) / 3 + [a^3 asinh(b / a) + b^3 asinh(a / b)] / 6. */
static long double mean_distance_from(long double x, long double y) {
  const long double u = 1.0L - x, v = 1.0L - y;
  const long double xy = sqrtl(x * x + y * y), uy = sqrtl(u * u + y * y);
  const long double xv = sqrtl(x * x + v * v), uv = sqrtl(u * u + v * v);
  return (x * y * xy + u * y * uy + x * v * xv + u * v * uv) / 3.0L + side_part(x, y, xy, xv) +
         side_part(u, y, uy, uv) + side_part(y, x, xy, uy) + side_part(v, x, xv, uv);
}

/* How far along a coordinate, squared. */
ASC_INLINE asc_kept squared_apart(double a, double b) {
  const asc_kept apart = asc_kept_difference(a > b ? a : b, a > b ? b : a);
  return asc_kept_product(apart, apart);
}

/* The sum of the distances from (x, y) to `count` points, RUN of which can be read. Of a root, Newton's step tells what
 * it lost. */
ASC_VECTORISE
static asc_kept sum_distances(double x, double y, const double *xs, const double *ys, size_t count) {
  double distances[RUN], lost[RUN];
  for (size_t j = 0; j < RUN; j++) {
    const asc_kept along = squared_apart(xs[j], x), across = squared_apart(ys[j], y);
    const asc_kept square = asc_kept_sum(along.value, across.value);
    const double root = sqrt(square.value), twice = 2.0 * root;
    const double rest = fma(-root, root, square.value) + (square.lost + (along.lost + across.lost));
    distances[j] = root;
    lost[j] = rest / (twice > 0.0 ? twice : 1.0);
  }
  for (size_t j = count; j < RUN; j++) distances[j] = lost[j] = 0.0;
  return asc_kept_total(distances, lost, RUN);
}

static asc_status evaluate_exactly(const asc_point_set *set, asc_measurement *made, asc_error *error) {
  const size_t n = set->count;
  if (n > SIZE_MAX / 4 / sizeof(double) - RUN) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double *xs = calloc(2 * (n + RUN), sizeof *xs);
  if (!xs) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double *ys = xs + n + RUN;
  asc_kept_long potentials = {0.0L, 0.0L}, pairs = {0.0L, 0.0L};
  for (size_t i = 0; i < n; i++) {
    const long double x = xs[i] = set->points[2 * i], y = ys[i] = set->points[2 * i + 1];
    asc_kept_add(&potentials, mean_distance_from(x, y) - MIDDLE);
  }
  for (size_t i = 0; i < n; i++)
    for (size_t j = i + 1; j < n; j += RUN) {
      const size_t count = n - j < RUN ? n - j : RUN;
      const asc_kept sum = sum_distances(xs[i], ys[i], xs + j, ys + j, count);
      asc_kept_add(&pairs, (sum.value - (long double)count * MIDDLE) + sum.lost);
    }
  free(xs);
  const long double points = (long double)n; /* each of which is also one with itself, at no distance */
  const long double all_pairs = 2.0L * asc_kept_value(&pairs) - points * MIDDLE;
  const long double square =
      (2.0L * asc_kept_value(&potentials) / points - all_pairs / points / points - MEAN_DISTANCE_LESS_MIDDLE) / 4.0L;
  asc_measured(made, (double)sqrtl(square > 0.0L ? square : 0.0L));
  return ASC_OK;
}

/* The root of a mean square; its standard error by the delta method, that of the square over twice the root. */
static asc_status evaluate_by_draws(const asc_point_set *set, asc_edges edges, uint64_t draws, asc_measurement *made,
                                    asc_error *error) {
  asc_edge_statistics statistics = {0};
  const asc_status status = asc_edges_measure(set, edges, draws, &statistics, error);
  if (status) return status;
  const double root = sqrt(statistics.square);
  asc_measured(made, root);
  made->standard_error = root > 0.0 ? statistics.square_error / (2.0 * root) : 0.0;
  made->certainty = ASC_ESTIMATED;
  return ASC_OK;
}

static asc_status edge_rms_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                    asc_error *error) {
  const asc_edges edges = (asc_edges)values[0];
  const uint64_t draws = (uint64_t)values[1];
  if (draws == 1) return asc_fail(error, ASC_INVALID_VALUE, "edge-rms: draws=1 has no standard error: draw 2 or more");
  if (draws == 0 && edges == ASC_EDGES_ISOTROPIC) return evaluate_exactly(set, made, error);
  return evaluate_by_draws(set, edges, draws ? draws : ASC_USUAL_DRAWS, made, error);
}

static const asc_parameter parameters[] = {
    ASC_EDGES_PARAMETER,
    {"draws", ASC_INTEGER, NULL, 0, ASC_MOST_DRAWS, 0,
     "how many edges are drawn; 0: isotropic ones not at all, but exact, others 524,288"},
};

const asc_measure_interface asc_measure_edge_rms = {
    .name = "edge-rms",
    .title = "root mean square of n/N - area over random edges, exact where they are isotropic",
    .source = "Mitchell 1992; Crofton's formula",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .least_dimensions = 2,
    .most_dimensions = 2,
    .quick_points = 20000,
    .evaluate = edge_rms_evaluate,
};

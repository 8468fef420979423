/* All directions, uniform, by an octahedron: the diamond in the middle of the square is the upper hemisphere, the four
 * corners, folded over its sides, are the lower one.
 *
 * Source: Clarberg 2008, "Fast equal-area mapping of the (hemi)sphere using SIMD", Journal of Graphics Tools 13(3). In
 * one eighth, (p, q) with p + q <= 1, lines p + q = r become parallels z = 1 - r^2, evenly. */
#include <math.h>

#include "rows.h"

static int sample(const double *u, double *w) {
  if (!asc_in_unit(u[0]) || !asc_in_unit(u[1])) return 0;
  const double a = 2.0 * u[0] - 1.0, b = 2.0 * u[1] - 1.0;
  const int below = fabs(a) + fabs(b) > 1.0;
  const double p = below ? 1.0 - fabs(b) : fabs(a), q = below ? 1.0 - fabs(a) : fabs(b);
  const double r = fmin(p + q, 1.0);
  const double longitude = r > 0.0 ? ASC_PI / 2.0 * fmin(q / r, 1.0) : 0.0;
  const double z = (1.0 - r) * (1.0 + r), ring = r * sqrt(2.0 - r * r);
  w[0] = copysign(ring * cos(longitude), a);
  w[1] = copysign(ring * sin(longitude), b);
  w[2] = below ? -z : z;
  return 1;
}

static int inverse(const double *w, double *u) {
  if (!asc_is_direction(w)) return 0;
  const double r = fmin(hypot(w[0], w[1]) / sqrt(1.0 + fabs(w[2])), 1.0);
  const double q = r * fmin(atan2(fabs(w[1]), fabs(w[0])) * (2.0 / ASC_PI), 1.0), p = r - q;
  const int below = w[2] < 0.0;
  u[0] = 0.5 * (copysign(below ? 1.0 - q : p, w[0]) + 1.0);
  u[1] = 0.5 * (copysign(below ? 1.0 - p : q, w[1]) + 1.0);
  return 1;
}

static int pdf(const double *w, double *density) {
  if (!asc_is_direction(w)) return 0;
  *density = 0.25 / ASC_PI;
  return 1;
}

asc_status asc_sphere_sample(const double *u, size_t n, double *directions) {
  return asc_rows(sample, u, 2, n, directions, 3);
}

asc_status asc_sphere_inverse(const double *directions, size_t n, double *u) {
  return asc_rows(inverse, directions, 3, n, u, 2);
}

asc_status asc_sphere_pdf(const double *directions, size_t n, double *density) {
  return asc_rows(pdf, directions, 3, n, density, 1);
}

/* Directions of a hemisphere, uniform: the concentric disc through Lambert's equal-area projection, z = 1 - r^2.
 *
 * Source: Shirley and Chiu 1997, section 3. */
#include "concentric.h"

static int sample(const double *u, double *w) {
  if (!asc_in_unit(u[0]) || !asc_in_unit(u[1])) return 0;
  const double radius = asc_to_disc(u, w), short_of_rim = asc_short_of_rim(u);
  const double stretch = sqrt(2.0 - radius * radius);
  w[0] *= stretch;
  w[1] *= stretch;
  w[2] = short_of_rim * (2.0 - short_of_rim);
  return 1;
}

static int inverse(const double *w, double *u) {
  if (!asc_is_direction(w) || w[2] < 0.0) return 0;
  const double stretch = sqrt(1.0 + w[2]); /* 2 - r^2 = 1 + z */
  asc_from_disc(w[0] / stretch, w[1] / stretch, u);
  return 1;
}

static int pdf(const double *w, double *density) {
  if (!asc_is_direction(w)) return 0;
  *density = w[2] >= 0.0 ? 0.5 / ASC_PI : 0.0;
  return 1;
}

asc_status asc_uniform_hemisphere_sample(const double *u, size_t n, double *directions) {
  return asc_rows(sample, u, 2, n, directions, 3);
}

asc_status asc_uniform_hemisphere_inverse(const double *directions, size_t n, double *u) {
  return asc_rows(inverse, directions, 3, n, u, 2);
}

asc_status asc_uniform_hemisphere_pdf(const double *directions, size_t n, double *density) {
  return asc_rows(pdf, directions, 3, n, density, 1);
}

/* Directions of a hemisphere by their cosine: the concentric disc seen from above, as Malley noted (Shirley and Chiu
 * 1997, section 3; pbrt names the method). */
#include "concentric.h"

static int sample(const double *u, double *w) {
  if (!asc_in_unit(u[0]) || !asc_in_unit(u[1])) return 0;
  const double short_of_rim = asc_short_of_rim(u);
  (void)asc_to_disc(u, w);
  w[2] = sqrt(short_of_rim * (2.0 - short_of_rim)); /* 1 - radius^2 without its cancellation near the rim */
  return 1;
}

static int inverse(const double *w, double *u) {
  if (!asc_is_direction(w) || w[2] < 0.0) return 0;
  asc_from_disc(w[0], w[1], u);
  return 1;
}

static int pdf(const double *w, double *density) {
  if (!asc_is_direction(w)) return 0;
  *density = w[2] > 0.0 ? w[2] / ASC_PI : 0.0;
  return 1;
}

asc_status asc_cosine_hemisphere_sample(const double *u, size_t n, double *directions) {
  return asc_rows(sample, u, 2, n, directions, 3);
}

asc_status asc_cosine_hemisphere_inverse(const double *directions, size_t n, double *u) {
  return asc_rows(inverse, directions, 3, n, u, 2);
}

asc_status asc_cosine_hemisphere_pdf(const double *directions, size_t n, double *density) {
  return asc_rows(pdf, directions, 3, n, density, 1);
}

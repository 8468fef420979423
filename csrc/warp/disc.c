/* The unit disc; the map and its source are in concentric.h. */
#include "concentric.h"

static int sample(const double *u, double *point) {
  if (!asc_in_unit(u[0]) || !asc_in_unit(u[1])) return 0;
  (void)asc_to_disc(u, point);
  return 1;
}

static int inverse(const double *point, double *u) {
  if (!(hypot(point[0], point[1]) <= 1.0 + ASC_ROUNDING)) return 0;
  asc_from_disc(point[0], point[1], u);
  return 1;
}

static int pdf(const double *point, double *density) {
  if (isnan(point[0]) || isnan(point[1])) return 0;
  /* A point of the rim is off by the rounding of its sine and cosine. */
  *density = hypot(point[0], point[1]) <= 1.0 + 0x1p-50 ? 1.0 / ASC_PI : 0.0;
  return 1;
}

asc_status asc_disc_sample(const double *u, size_t n, double *points) { return asc_rows(sample, u, 2, n, points, 2); }

asc_status asc_disc_inverse(const double *points, size_t n, double *u) { return asc_rows(inverse, points, 2, n, u, 2); }

asc_status asc_disc_pdf(const double *points, size_t n, double *density) {
  return asc_rows(pdf, points, 2, n, density, 1);
}

/* A triangle, uniform.
 *
 * Source: Heitz 2019, "A low-distortion map between triangle and square": each half of the square beside its diagonal
 * is sheared onto half of the triangle, so that no edge shrinks to a corner, as it does with square roots. */
#include <math.h>

#include "kept.h"
#include "rows.h"

static int sample(const double *u, double *b) {
  if (!asc_in_unit(u[0]) || !asc_in_unit(u[1])) return 0;
  const int far = u[1] > u[0];
  const double half = 0.5 * u[far ? 0 : 1], most = u[far ? 1 : 0];
  b[far ? 0 : 1] = half;
  b[far ? 1 : 0] = most - half;
  b[2] = 1.0 - most; /* 1 - b0 - b1, not below 0 */
  return 1;
}

static int inverse(const double *b, double *u) {
  if (!(b[0] >= 0.0 && b[1] >= 0.0 && b[2] >= 0.0 && fabs(b[0] + b[1] + b[2] - 1.0) <= ASC_ROUNDING)) return 0;
  const int far = b[1] > b[0];
  u[far ? 0 : 1] = fmin(2.0 * b[far ? 0 : 1], 1.0);
  u[far ? 1 : 0] = fmin(b[0] + b[1], 1.0);
  return 1;
}

asc_status asc_triangle_sample(const double *u, size_t n, double *barycentrics) {
  return asc_rows(sample, u, 2, n, barycentrics, 3);
}

asc_status asc_triangle_inverse(const double *barycentrics, size_t n, double *u) {
  return asc_rows(inverse, barycentrics, 3, n, u, 2);
}

/* p q - r s: of a sliver's edges nearly all of it cancels. */
static double determinant(asc_kept p, asc_kept q, asc_kept r, asc_kept s) {
  const asc_kept left = asc_kept_product(p, q), right = asc_kept_product(r, s);
  const asc_kept whole = asc_kept_sum(left.value, -right.value);
  return whole.value + (whole.lost + (left.lost - right.lost));
}

/* From one vertex to another along an axis. */
static asc_kept edge(double from, double to, int exponent) {
  const asc_kept made = asc_kept_sum(to, -from);
  return (asc_kept){ldexp(made.value, -exponent), ldexp(made.lost, -exponent)};
}

asc_status asc_triangle_pdf(const double vertices[9], double *pdf, asc_error *error) {
  if (!vertices || !pdf) return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_triangle_pdf: a null pointer");
  double extent = 0.0;
  for (int i = 0; i < 9; i++) extent = fmax(extent, fabs(vertices[i] - vertices[i % 3]));
  int exponent; /* edges of about 1 have squares that are doubles */
  (void)frexp(extent, &exponent);
  asc_kept e[3], f[3];
  for (int i = 0; i < 3; i++) {
    e[i] = edge(vertices[i], vertices[3 + i], exponent);
    f[i] = edge(vertices[i], vertices[6 + i], exponent);
  }
  const double x = determinant(e[1], f[2], e[2], f[1]), y = determinant(e[2], f[0], e[0], f[2]),
               z = determinant(e[0], f[1], e[1], f[0]);
  const double scaled = hypot(hypot(x, y), z), twice = ldexp(scaled, 2 * exponent); /* the area */
  if (!(twice > 0.0 && isfinite(twice) && isfinite(2.0 / twice)))
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "a triangle of area %g has no density: its vertices lie on one line, or are not finite",
                    0.5 * twice);
  *pdf = 2.0 / twice;
  return ASC_OK;
}

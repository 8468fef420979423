/* The cubic filters of Mitchell and Netravali, with their parameters B and C.
 *
 * Source: Mitchell and Netravali 1988, "Reconstruction filters in computer graphics". With t = |x|, 6 k(x) is
 *
 *   (12 - 9 B - 6 C) t^3 + (-18 + 12 B + 6 C) t^2 + (6 - 2 B)              for t < 1,
 *   (-B - 6 C) t^3 + (6 B + 30 C) t^2 + (-12 B - 48 C) t + (8 B + 24 C)    for 1 <= t < 2.
 *
 * B = C = 1/3 is what they recommend; (1, 0) is the cubic B-spline, (0, C) the cardinal splines, (3/2, -1/4) their
 * notch filter. Another radius than 2 stretches it. */
#include <math.h>

#include "cubic.h"
#include "profile.h"
#include "vectorise.h"

enum { B, C, RADIUS };

typedef struct cubic {
  double near[4], far[4]; /* by powers of t, for t < 1 and for 1 <= t <= 2 */
} cubic;

static cubic cubic_of(double b, double c) {
  return (cubic){{6 - 2 * b, 0, -18 + 12 * b + 6 * c, 12 - 9 * b - 6 * c},
                 {8 * b + 24 * c, -12 * b - 48 * c, 6 * b + 30 * c, -b - 6 * c}};
}

static inline double polynomial(const double a[4], double t) { return a[0] + t * (a[1] + t * (a[2] + t * a[3])); }

static double polynomial_integral(const double a[4], double t) {
  return t * (a[0] + t * (a[1] / 2 + t * (a[2] / 3 + t * a[3] / 4)));
}

uint32_t asc_cubic_pieces(const double *values) {
  (void)values;
  return 2;
}

ASC_VECTORISE void asc_cubic_evaluate(double b, double c, double radius, const double *x, size_t n, double *profile) {
  const cubic of = cubic_of(b, c);
  const double scale = 2.0 / radius;
  for (size_t i = 0; i < n; i++) {
    const double t = scale * x[i];
    const double near = polynomial(of.near, t), far = polynomial(of.far, t);
    profile[i] = t < 1.0 ? near : far;
  }
}

double asc_cubic_primitive(double b, double c, double radius, double x) {
  const cubic of = cubic_of(b, c);
  const double t = 2.0 / radius * x;
  double sum = polynomial_integral(of.near, fmin(t, 1.0));
  if (t > 1.0) sum += polynomial_integral(of.far, t) - polynomial_integral(of.far, 1.0);
  return 0.5 * radius * sum;
}

static double mitchell_radius(const double *values) { return values[RADIUS]; }

static void mitchell_evaluate(const double *values, const double *x, size_t n, double *profile) {
  asc_cubic_evaluate(values[B], values[C], values[RADIUS], x, n, profile);
}

static double mitchell_primitive(const double *values, double x) {
  return asc_cubic_primitive(values[B], values[C], values[RADIUS], x);
}

static const asc_parameter mitchell_parameters[] = {
    [B] = {"b", ASC_REAL, NULL, -2, 2, 1.0 / 3.0, "B: how much of the cubic B-spline"},
    [C] = {"c", ASC_REAL, NULL, -2, 2, 1.0 / 3.0, "C: how deep the negative lobes"},
    [RADIUS] = ASC_RADIUS_PARAMETER(2),
};

const asc_filter_interface asc_filter_mitchell = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "mitchell",
    .title = "cubics in two pieces, with parameters B and C",
    .source = "Mitchell and Netravali 1988",
    .parameters = mitchell_parameters,
    .parameter_count = 3,
    .radius = mitchell_radius,
    .pieces = asc_cubic_pieces,
    .evaluate = mitchell_evaluate,
    .primitive = mitchell_primitive,
};

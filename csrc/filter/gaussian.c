/* The Gaussian exp(-x^2 / (2 sigma^2)), cut off at its radius and normalised there.
 *
 * The defaults, sigma 1/2 and radius 3/2, are those of Pharr, Jakob and Humphreys 2023, "Physically Based Rendering",
 * 4th edition, 8.8. There the value at the radius is subtracted besides, so that the profile ends at zero; here it is
 * not: the profile is the Gaussian itself, which ends in a step of exp(-4.5) = 1.1 % of its height. */
#include <math.h>

#include "profile.h"

enum { RADIUS, SIGMA };

static const double root_half = 0.707106781186547524;

static uint32_t gaussian_pieces(const double *values) { return (uint32_t)ceil(values[RADIUS] / values[SIGMA]); }

static void gaussian_evaluate(const double *values, const double *x, size_t n, double *profile) {
  const double factor = -0.5 / (values[SIGMA] * values[SIGMA]);
  for (size_t i = 0; i < n; i++) profile[i] = exp(factor * x[i] * x[i]);
}

static double gaussian_primitive(const double *values, double x) {
  const double root_half_pi = 1.25331413731550025;
  return values[SIGMA] * root_half_pi * erf(x / values[SIGMA] * root_half);
}

static double gaussian_tail(const double *values, double x) {
  const double root_half_pi = 1.25331413731550025, across = root_half / values[SIGMA];
  return values[SIGMA] * root_half_pi * (erfc(x * across) - erfc(values[RADIUS] * across));
}

static const asc_parameter gaussian_parameters[] = {
    [RADIUS] = ASC_RADIUS_PARAMETER(1.5),
    [SIGMA] = {"sigma", ASC_REAL, NULL, 0.1, 8, 0.5, "the standard deviation, in pixels, of the whole Gaussian"},
};

const asc_filter_interface asc_filter_gaussian = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "gaussian",
    .title = "exp(-x^2 / (2 sigma^2)), cut off at the radius",
    .source = "Pharr, Jakob and Humphreys 2023, 8.8",
    .parameters = gaussian_parameters,
    .parameter_count = 2,
    .radius = asc_first_value,
    .pieces = gaussian_pieces,
    .evaluate = gaussian_evaluate,
    .primitive = gaussian_primitive,
    .tail = gaussian_tail,
};

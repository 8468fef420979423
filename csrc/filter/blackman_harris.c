/* The four-term window of Blackman and Harris as a filter.
 *
 * Source: Harris 1978, "On the use of windows for harmonic analysis with the discrete Fourier transform": the
 * coefficients whose side lobes lie below -92 dB. The default radius of 3/2 pixels is that of Blender's Cycles, whose
 * filter width of 1.5 is half the support. It ends in a step of 6e-5 of its height. */
#include "profile.h"
#include "vectorise.h"

static const double terms[4] = {0.35875, 0.48829, 0.14128, 0.01168};

static uint32_t blackman_harris_pieces(const double *values) {
  (void)values;
  return 2; /* its fastest cosine turns 1.5 times */
}

ASC_VECTORISE static void blackman_harris_evaluate(const double *values, const double *x, size_t n, double *profile) {
  const double inverse = 1.0 / values[0];
  for (size_t i = 0; i < n; i++) {
    const double c = asc_sin_pi(0.5 - x[i] * inverse); /* the cosine of pi x / radius */
    profile[i] = terms[0] + terms[1] * c + terms[2] * (2.0 * c * c - 1.0) + terms[3] * c * (4.0 * c * c - 3.0);
  }
}

static double blackman_harris_primitive(const double *values, double x) {
  const double pi = 3.14159265358979324;
  double sum = terms[0] * x;
  for (int k = 1; k <= 3; k++) sum += terms[k] * values[0] / (k * pi) * asc_sin_pi(k * x / values[0]);
  return sum;
}

static const asc_parameter blackman_harris_parameters[] = {ASC_RADIUS_PARAMETER(1.5)};

const asc_filter_interface asc_filter_blackman_harris = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "blackman-harris",
    .title = "the four-term window, side lobes below -92 dB",
    .source = "Harris 1978",
    .parameters = blackman_harris_parameters,
    .parameter_count = 1,
    .radius = asc_first_value,
    .pieces = blackman_harris_pieces,
    .evaluate = blackman_harris_evaluate,
    .primitive = blackman_harris_primitive,
};

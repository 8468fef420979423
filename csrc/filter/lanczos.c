/* Lanczos' windowed sinc: sinc(x) sinc(x / a) for |x| < a, with sinc(x) = sin(pi x) / (pi x) and a the lobes.
 *
 * Source: Duchon 1979, "Lanczos filtering in one and two dimensions"; as a filter of pictures Turkowski 1990, "Filters
 * for common resampling tasks", whose choices are a = 2 and 3. Its integral is not 1 (0.997 for a = 3) and has no
 * elementary form, so it is found by quadrature. */
#include "profile.h"
#include "vectorise.h"

static uint32_t lanczos_pieces(const double *values) { return (uint32_t)values[0]; }

ASC_VECTORISE static void lanczos_evaluate(const double *values, const double *x, size_t n, double *profile) {
  const double pi_squared = 9.86960440108935862, lobes = values[0], inverse = 1.0 / lobes;
  for (size_t i = 0; i < n; i++) {
    const double t = x[i] > 1e-9 ? x[i] : 1e-9; /* where the profile is 1 - 2e-18, and 0 / 0 is not met */
    profile[i] = lobes * asc_sin_pi(t) * asc_sin_pi(t * inverse) / (pi_squared * t * t);
  }
}

static const asc_parameter lanczos_parameters[] = {
    {"lobes", ASC_INTEGER, NULL, 1, ASC_FILTER_RADIUS_MOST, 3, "a: the lobes either way, and the radius in pixels"},
};

const asc_filter_interface asc_filter_lanczos = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "lanczos",
    .title = "the sinc, windowed by the middle lobe of a wider sinc",
    .source = "Duchon 1979; Turkowski 1990",
    .parameters = lanczos_parameters,
    .parameter_count = 1,
    .radius = asc_first_value,
    .pieces = lanczos_pieces,
    .evaluate = lanczos_evaluate,
};

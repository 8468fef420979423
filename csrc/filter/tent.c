/* The tent: 1 - |x| / radius, linear interpolation at its default radius of one pixel.
 *
 * Source: Hou and Andrews 1978, "Cubic splines for image interpolation and digital filtering", where it is the B-spline
 * of first order. */
#include "profile.h"

static void tent_evaluate(const double *values, const double *x, size_t n, double *profile) {
  for (size_t i = 0; i < n; i++) profile[i] = values[0] - x[i];
}

static double tent_primitive(const double *values, double x) { return x * (values[0] - 0.5 * x); }

static const asc_parameter tent_parameters[] = {ASC_RADIUS_PARAMETER(1)};

const asc_filter_interface asc_filter_tent = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "tent",
    .title = "1 - |x| / radius",
    .source = "Hou and Andrews 1978",
    .parameters = tent_parameters,
    .parameter_count = 1,
    .radius = asc_first_value,
    .pieces = asc_one_piece,
    .evaluate = tent_evaluate,
    .primitive = tent_primitive,
};

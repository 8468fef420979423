/* The box: the mean over a square. At its default radius of half a pixel, the mean over the pixel.
 *
 * Source: Catmull 1978, "A hidden-surface algorithm with anti-aliasing", for the mean over the pixel. */
#include "profile.h"

static void box_evaluate(const double *values, const double *x, size_t n, double *profile) {
  (void)values;
  (void)x;
  for (size_t i = 0; i < n; i++) profile[i] = 1.0;
}

static double box_primitive(const double *values, double x) {
  (void)values;
  return x;
}

static const asc_parameter box_parameters[] = {ASC_RADIUS_PARAMETER(0.5)};

const asc_filter_interface asc_filter_box = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "box",
    .title = "the mean over a square, by default the pixel",
    .source = "Catmull 1978",
    .parameters = box_parameters,
    .parameter_count = 1,
    .radius = asc_first_value,
    .pieces = asc_one_piece,
    .evaluate = box_evaluate,
    .primitive = box_primitive,
};

/* The kernel of the multi-stage filter: a box of one pixel, two of a half and one of a quarter, convolved.
 *
 * Source: Mitchell 1987, "Generating antialiased images at low sampling densities", as the lecture has it:
 * k(x) = box(x) * box(2x) * box(2x) * box(4x), with * for convolution and box(x) one pixel wide. So the widths are 1,
 * 1/2, 1/2, 1/4. That the boxes are of "ever increasing width" is no other kernel if it is said of the order in which
 * they are applied: the samples meet the narrowest first (see stages.c). With widths that grow with the factor, 1, 2,
 * 2, 4, it would be this one four times as wide: radius=4.5, whose response ends at a quarter of a cycle a pixel, half
 * of what a picture holds.
 *
 * With t = 8 |x| / width the knots are at 3, 5, 7 and 9, and the profile is, up to a constant, the sum of
 * c (a - t)^3 over the knots a above t, with c = 2, -2, -1, 1. */
#include "profile.h"
#include "vectorise.h"

#define KNOTS 4
static const double knots[KNOTS] = {3, 5, 7, 9}, factors[KNOTS] = {2, -2, -1, 1};

static uint32_t multi_stage_pieces(const double *values) {
  (void)values;
  return 9;
}

ASC_VECTORISE static void multi_stage_evaluate(const double *values, const double *x, size_t n, double *profile) {
  const double scale = 9.0 / values[0];
  for (size_t i = 0; i < n; i++) {
    double sum = 0.0;
    for (int k = 0; k < KNOTS; k++) {
      const double above = knots[k] > scale * x[i] ? knots[k] - scale * x[i] : 0.0;
      sum += factors[k] * above * above * above;
    }
    profile[i] = sum;
  }
}

static double multi_stage_primitive(const double *values, double x) {
  const double t = 9.0 / values[0] * x;
  double sum = 0.0;
  for (int k = 0; k < KNOTS; k++) {
    const double above = knots[k] > t ? knots[k] - t : 0.0;
    sum += factors[k] * (knots[k] * knots[k] * knots[k] * knots[k] - above * above * above * above);
  }
  return values[0] / 36.0 * sum;
}

static double multi_stage_tail(const double *values, double x) {
  const double t = 9.0 / values[0] * x;
  double sum = 0.0;
  for (int k = 0; k < KNOTS; k++) {
    const double above = knots[k] > t ? knots[k] - t : 0.0;
    sum += factors[k] * above * above * above * above;
  }
  return values[0] / 36.0 * sum;
}

static const asc_parameter multi_stage_parameters[] = {ASC_RADIUS_PARAMETER(1.125)};

const asc_filter_interface asc_filter_multi_stage = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "multi-stage",
    .title = "boxes of a pixel, a half, a half and a quarter, convolved",
    .source = "Mitchell 1987",
    .parameters = multi_stage_parameters,
    .parameter_count = 1,
    .radius = asc_first_value,
    .pieces = multi_stage_pieces,
    .evaluate = multi_stage_evaluate,
    .primitive = multi_stage_primitive,
    .tail = multi_stage_tail,
};

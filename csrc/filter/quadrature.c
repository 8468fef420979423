/* The rule of Gauss and Legendre with 16 points on each of a number of panels.
 *
 * A cosine over one cycle is integrated to 1e-28 of its height by 16 points (the error's bound is
 * (16!)^4 (2 pi)^32 / (33 (32!)^3)), so with panels of a cycle at most, on which the profile is smooth, rounding is
 * what remains. */
#include "quadrature.h"

#include <math.h>

#define POINTS 16

static const double rule[POINTS / 2][2] = {
    {0.0950125098376374402, 0.189450610455068496}, {0.281603550779258913, 0.182603415044923589},
    {0.458016777657227386, 0.169156519395002538},  {0.617876244402643748, 0.149595988816576732},
    {0.755404408355003034, 0.124628971255533872},  {0.865631202387831744, 0.0951585116824927848},
    {0.944575023073232576, 0.0622535239386478929}, {0.989400934991649933, 0.0271524594117540949},
};

static double panel(const asc_filter_interface *interface, const double *values, double begin, double end,
                    double frequency) {
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  double x[POINTS], profile[POINTS], sum = 0.0;
  for (int i = 0; i < POINTS; i++) x[i] = middle + (i % 2 ? half : -half) * rule[i / 2][0];
  interface->evaluate(values, x, POINTS, profile);
  for (int i = 0; i < POINTS; i++) sum += rule[i / 2][1] * profile[i] * asc_sin_pi(2.0 * frequency * x[i] + 0.5);
  return half * sum;
}

double asc_profile_integral(const asc_filter_interface *interface, const double *values, double end, double frequency) {
  const uint32_t pieces = interface->pieces(values);
  const double width = interface->radius(values) / pieces;
  const uint32_t panels = (uint32_t)ceil(fmax(1.0, width * frequency)); /* in a piece */
  double sum = 0.0;
  for (uint32_t piece = 0; piece < pieces && piece * width < end; piece++) {
    const double begin = piece * width, length = fmin(width, end - begin);
    for (uint32_t i = 0; i < panels; i++)
      sum += panel(interface, values, begin + length * i / panels, begin + length * (i + 1) / panels, frequency);
  }
  return sum;
}

/* The concentric map between square and disc, which the hemispheres use too.
 *
 * Source: Shirley and Chiu 1997, "A low distortion map between disk and square", Journal of Graphics Tools 2(3): rings
 * of the square, max(|a|, |b|) = r, become circles of radius r, evenly. Its four wedges are two here: a negative r
 * stands for the opposite ones. */
#ifndef ASC_CONCENTRIC_H
#define ASC_CONCENTRIC_H

#include <math.h>

#include "rows.h"

/* Sine and cosine of up to an eighth of a turn: the same bits on every machine, and in a loop that compilers vectorise,
 * both of which the C library's are not. The series' next terms are below 8e-20 and 2e-18. */
static inline void asc_eighth_turn(double x, double *sine, double *cosine) {
  static const double odd[] = {-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,          1.0 / 362880.0,
                               -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368000.0, 1.0 / 355687428096000.0};
  static const double even[] = {-1.0 / 2.0,       1.0 / 24.0,        -1.0 / 720.0,         1.0 / 40320.0,
                                -1.0 / 3628800.0, 1.0 / 479001600.0, -1.0 / 87178291200.0, 1.0 / 20922789888000.0};
  const double square = x * x;
  double s = odd[7], c = even[7];
  for (int k = 6; k >= 0; k--) {
    s = s * square + odd[k];
    c = c * square + even[k];
  }
  *sine = x + x * (square * s);
  *cosine = 1.0 + square * c;
}

/* Returns the radius, which is exact where that of the point is rounded. */
static inline double asc_to_disc(const double *u, double *point) {
  const double a = 2.0 * u[0] - 1.0, b = 2.0 * u[1] - 1.0;
  const int along_x = fabs(a) > fabs(b);
  const double radius = along_x ? a : b, across = along_x ? b : a;
  double sine, cosine; /* of the angle from the wedge's axis */
  asc_eighth_turn(ASC_PI / 4.0 * (across / (radius == 0.0 ? 1.0 : radius)), &sine, &cosine);
  point[0] = radius * (along_x ? cosine : sine);
  point[1] = radius * (along_x ? sine : cosine);
  return fabs(radius);
}

static inline void asc_from_disc(double x, double y, double *u) {
  const int along_x = fabs(x) > fabs(y);
  const double axis = along_x ? x : y, across = along_x ? y : x;
  const double radius = copysign(hypot(x, y), axis);
  const double angle = axis == 0.0 ? 0.0 : atan(across / axis);
  const double side = radius * (angle * (4.0 / ASC_PI));
  u[along_x ? 0 : 1] = asc_limited(0.5 * (radius + 1.0), 0.0, 1.0);
  u[along_x ? 1 : 0] = asc_limited(0.5 * (side + 1.0), 0.0, 1.0);
}

#endif

/* The concentric map between square and disc, which the hemispheres use too.
 *
 * Source: Shirley and Chiu 1997, "A low distortion map between disk and square", Journal of Graphics Tools 2(3): rings
 * of the square, max(|a|, |b|) = r, become circles of radius r, evenly. Its four wedges are two here: a negative r
 * stands for the opposite ones. */
#ifndef ASC_CONCENTRIC_H
#define ASC_CONCENTRIC_H

#include <math.h>
#include <stddef.h>

#include "rows.h"

/* Sine and cosine of up to an eighth of a turn: the same bits on every machine, and in a loop that compilers vectorise,
 * both of which the C library's are not. The series have the least largest errors (Remez' exchange), 3.5e-18 and 4e-20,
 * and are halved twice, as steps of one long sum would wait for each other (Estrin's scheme). */
static inline void asc_eighth_turn(double x, double *sine, double *cosine) {
  static const double odd[] = {-0x1.5555555555549p-3, 0x1.111111110f880p-7,   -0x1.a01a019c125ffp-13,
                               0x1.71de35786aafap-19, -0x1.ae5e66cd345adp-26, 0x1.5d932d038a706p-33};
  static const double even[] = {-0x1.0000000000000p-1, 0x1.555555555553cp-5,   -0x1.6c16c16c13f18p-10,
                                0x1.a01a019b6f81dp-16, -0x1.27e4f753749d2p-22, 0x1.1ee984a8b251bp-29,
                                -0x1.8f806c8fbd51fp-37};
  const double square = x * x, fourth = square * square;
  double s[3], c[3];
  for (size_t k = 0; k < 3; k++) {
    s[k] = odd[2 * k] + odd[2 * k + 1] * square;
    c[k] = even[2 * k] + even[2 * k + 1] * square;
  }
  c[2] += even[6] * fourth;
  *sine = x + x * (square * (s[0] + fourth * (s[1] + fourth * s[2])));
  *cosine = 1.0 + square * (c[0] + fourth * (c[1] + fourth * c[2]));
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

/* What that radius lacks of 1: exact, for u however near to 0 too. */
static inline double asc_short_of_rim(const double *u) {
  const double across = u[0] < 0.5 ? u[0] : 1.0 - u[0], along = u[1] < 0.5 ? u[1] : 1.0 - u[1];
  return 2.0 * fmin(across, along);
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

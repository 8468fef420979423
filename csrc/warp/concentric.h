/* The concentric map between square and disc, which the hemispheres use too.
 *
 * Source: Shirley and Chiu 1997, "A low distortion map between disk and square", Journal of Graphics Tools 2(3): rings
 * of the square, max(|a|, |b|) = r, become circles of radius r, evenly. Its four wedges are two here: a negative r
 * stands for the opposite ones. */
#ifndef ASC_CONCENTRIC_H
#define ASC_CONCENTRIC_H

#include <math.h>

#include "rows.h"

/* Returns the radius, which is exact where that of the point is rounded. */
static inline double asc_to_disc(const double *u, double *point) {
  const double a = 2.0 * u[0] - 1.0, b = 2.0 * u[1] - 1.0;
  const int along_x = fabs(a) > fabs(b);
  const double radius = along_x ? a : b;
  const double angle = radius == 0.0 ? 0.0 : ASC_PI / 4.0 * ((along_x ? b : a) / radius); /* from the wedge's axis */
  point[along_x ? 0 : 1] = radius * cos(angle);
  point[along_x ? 1 : 0] = radius * sin(angle);
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

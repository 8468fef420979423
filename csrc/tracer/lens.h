/* Points of the lens. */
#ifndef TRACER_LENS_H
#define TRACER_LENS_H

#include <stddef.h>

#include "aliascope/scene.h"

#define LENS_BLADES_MOST 64

typedef struct lens {
  double radius;
  uint32_t blades;                         /* 0: round */
  double corners[LENS_BLADES_MOST + 1][2]; /* of a polygon, the first again after the last */
} lens;

void lens_make(const asc_view *view, lens *made);

/* Takes points of the unit square, each `stride` numbers after the one before, to points of the lens, uniform over it;
 * tracer.h says how. */
void lens_points(const lens *through, size_t count, const double *u, size_t stride, double (*points)[2]);

#endif

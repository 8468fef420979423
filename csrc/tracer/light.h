/* Lights, seen from a point. */
#ifndef TRACER_LIGHT_H
#define TRACER_LIGHT_H

#include "aliascope/scene.h"

/* A light in the camera's frame; a directional one's place is the way toward it, of length 1. */
typedef struct light_source {
  asc_light given;
  double normal[3]; /* of a parallelogram or a disc: the side to which it shines, of length 1 */
  uint32_t numbers; /* where a sample has the two that choose the light's point, from the third number on */
} light_source;

int light_has_area(const asc_light *given);

/* Toward the light's point that u chooses, of length 1, and how much arrives there: 1, or the fall-off, with the cosine
 * at the light where it has an area; 0 where the light does not shine that way, and where the point is so near
 * that float does not part them. Gives how far the way has to be free: short of the light by 1.2e-4 of the coordinates,
 * so that a surface on which it lies does not stand in its way; infinite for a directional light. */
double light_toward(const light_source *from, const double u[2], const double point[3], double toward[3],
                    double *arriving);

#endif

/* Lights, seen from points. */
#ifndef TRACER_LIGHT_H
#define TRACER_LIGHT_H

#include <stdalign.h>

#include "aliascope/scene.h"
#include "vector.h"

/* A light in the camera's frame; a directional one's place is the way toward it, of length 1. */
typedef struct light_source {
  asc_light given;
  double normal[3]; /* of a parallelogram or a disc: the side to which it shines, of length 1 */
  uint32_t numbers; /* where a sample has the two that choose the light's point, from the third number on */
} light_source;

int light_has_area(const asc_light *given);

/* What lanes have of a light. */
typedef struct light_ways {
  vectors toward; /* its point, of length 1 */
  /* How much arrives: 1, or the fall-off, with the cosine at the light where it has an area; 0 where the light does not
   * shine that way, and where the point is so near that float does not part them. */
  alignas(64) double arriving[PACKET];
  /* How far the way has to be free: short of the light by 1.2e-4 of the coordinates, so that a surface on which it lies
   * does not stand in its way; infinite for a directional light. */
  alignas(64) double distance[PACKET];
} light_ways;

/* From the lanes' points to those of the light that u chooses. */
void light_toward(const light_source *from, const pairs *u, const vectors *point, light_ways *found);

#endif

/* Surfaces that shine, as places to send shadow rays to: triangles, discs and spheres, each chosen as often as its
 * power is of all. Planes have no end, and the triangles of frames no area of their own, so rays only come upon them.
 */
#ifndef TRACER_EMITTER_H
#define TRACER_EMITTER_H

#include "meeting.h"

typedef struct emitter {
  surface of;
  double up_to; /* the chances of those before it and its own, summed */
  double chance, area;
  double corner[3], edges[2][3]; /* at time 0: of a triangle; of a disc its centre and two radii */
} emitter;

/* Lists them. After the geometry. */
asc_status emitter_take(tracer *made, const asc_scene *scene, asc_error *error);

/* A place on an emitter, seen from a point. */
typedef struct emitter_place {
  double point[3], normal[3]; /* the normal toward the one who sees it */
  double slack;               /* as in a meeting */
  double radiance[3];
  double density; /* of being chosen, over the solid angle it is seen under */
} emitter_place;

/* The place that u chooses. Gives 0 where it is seen edge-on. */
int emitter_choose(const tracer *made, double time, const double u[2], const double seen_from[3],
                   emitter_place *chosen);

/* The density with which emitter_choose finds a place that a ray of length 1 from there met; 0 where it does not. */
double emitter_density(const tracer *made, double time, const meeting *met, const double origin[3],
                       const double direction[3]);

#endif

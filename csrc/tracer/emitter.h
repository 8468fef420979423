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
  double across[3], length;      /* the edges' product, and its length */
} emitter;

/* Lists them. After the geometry. */
asc_status emitter_take(tracer *made, const asc_scene *scene, asc_error *error);

/* Places on emitters, seen from the points of lanes. */
typedef struct emitter_places {
  vectors point, normal; /* the normal toward the one who sees it */
  vectors radiance;
  scalars slack;      /* how far Embree's surface may be off, as meeting.h has it */
  scalars least_lift; /* as meeting.h has it */
  scalars density;    /* of being chosen, over the solid angle it is seen under; 0 where it is seen edge-on */
} emitter_places;

/* The places that u chooses; `there`: bits, the lanes that ask for one. Of others the density is 0. */
void emitter_choose(const tracer *made, const double time[PACKET], const pairs *u, const vectors *seen_from,
                    uint32_t there, emitter_places *chosen);

/* The density with which emitter_choose finds a place that a ray of length 1 from there met; 0 where it does not. */
double emitter_density(const tracer *made, double time, const meeting *met, const double origin[3],
                       const double direction[3]);

#endif

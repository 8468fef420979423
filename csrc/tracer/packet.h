/* Sixteen paths that are traced together, and the radiance along each. */
#ifndef TRACER_PACKET_H
#define TRACER_PACKET_H

#include <stdalign.h>

#include "scene.h"

#define PACKET 16

/* Rays that were traced, beside those from the eye. */
typedef struct ray_counts {
  uint64_t reflection; /* along mirrors and in their lobes */
  uint64_t bounce;     /* scattered by an albedo */
  uint64_t shadow;
} ray_counts;

/* How a lane's path has come to where its ray ends. */
typedef struct path {
  double throughput[3]; /* the share of the radiance there that the path brings to the eye, over its chances */
  uint32_t mirrors_left, scatters_left;
  double density; /* with which its last direction was chosen, in a steradian; -1 where there was no choice */
  double mirror,
      scatter; /* the chances that it goes on by the reflection, or by the albedo; set once a ray has ended */
} path;

typedef struct packet {
  alignas(64) struct RTCRayHit16 rays;
  alignas(64) struct RTCRay16 shadows;
  alignas(64) int valid[PACKET];    /* which lanes have a ray */
  alignas(64) int shadowed[PACKET]; /* which lanes have a shadow ray */
  struct RTCIntersectContext context,
      scattered;                     /* for rays from the eye, and to the lights from what they meet; others */
  const double *sample_x, *sample_y; /* where in the picture, in pixels: numbers for all lanes */
  const double *further[PACKET]; /* the samples' other numbers, from the third on, as the layout says; those of lanes
                                    that are not in use are any */
  const double (*lens)[2];       /* where there is one, [PACKET] points of it, along right and up */
  double time[PACKET];           /* set where something moves */
  uint32_t lanes;                /* how many are in use, the first ones */
  double origin[PACKET][3], direction[PACKET][3]; /* of the rays again, in double; unset where the scene is plain */
  path paths[PACKET];                             /* likewise */
  double (*radiance)[4]; /* [PACKET], the fourth of each not used, so that three of all lanes are read alike */
  ray_counts counts;
} packet;

/* Sets what never changes. */
void packet_begin(packet *rays);

/* Sends the rays of the lanes in use from the eye: to sample_x, sample_y and, where the layout has any, by `further`.
 * `lens` holds numbers for all lanes. */
void packet_cast(const tracer *made, packet *rays);

/* Then: sets their radiance. */
void packet_shade(const tracer *made, packet *rays);

#endif

/* Sixteen paths that are traced together, and the radiance along each. */
#ifndef TRACER_PACKET_H
#define TRACER_PACKET_H

#include <stdalign.h>

#include "scene.h"

/* Rays that were traced, beside those from the eye. */
typedef struct ray_counts {
  uint64_t reflection; /* along mirrors and in their lobes */
  uint64_t bounce;     /* scattered by an albedo */
  uint64_t shadow;
} ray_counts;

typedef struct packet {
  alignas(64) struct RTCRayHit16 rays;
  alignas(64) struct RTCRay16 shadows;
  alignas(64) int valid[PACKET];    /* which lanes have a ray */
  alignas(64) int shadowed[PACKET]; /* which lanes have a shadow ray */
  /* Of the rays again, in double; unset where the scene is plain, as the rows that follow. */
  vectors origin, direction;
  /* The share of the radiance where a ray ends that its path brings to the eye, over its chances; and what it has
   * brought. */
  vectors throughput, gathered;
  /* Unset where no path goes on: how many bounces the paths have left; the density with which their last directions
   * were chosen, in a steradian, -1 where there was no choice; and, once a ray has ended, the chances that its path
   * goes on by the reflection, or by the albedo. */
  scalars mirrors_left, scatters_left, density, mirror, scatter;
  struct RTCIntersectContext context,
      scattered;                     /* for rays from the eye, and to the lights from what they meet; others */
  const double *sample_x, *sample_y; /* where in the picture, in pixels: numbers for all lanes */
  const double *further[PACKET]; /* the samples' other numbers, from the third on, as the layout says; those of lanes
                                    that are not in use are any */
  const double (*lens)[2];       /* where there is one, [PACKET] points of it, along right and up */
  double time[PACKET];           /* set where something moves */
  double (*radiance)[4];         /* [PACKET], the fourth of each not used, so that three of all lanes are read alike */
  ray_counts counts;
  uint32_t lanes; /* how many are in use, the first ones */
} packet;

/* The further numbers of a lane, or of the first for one that is not in use. */
static inline const double *packet_numbers(const packet *rays, uint32_t lane) {
  return rays->further[lane < rays->lanes ? lane : 0];
}

/* Sets what never changes. */
void packet_begin(packet *rays);

/* Sends the rays of the lanes in use from the eye: to sample_x, sample_y and, where the layout has any, by `further`.
 * `lens` holds numbers for all lanes. */
void packet_cast(const tracer *made, packet *rays);

/* Then: sets their radiance. */
void packet_shade(const tracer *made, packet *rays);

#endif

/* Sixteen rays that are traced together, and the radiance along each. */
#ifndef TRACER_PACKET_H
#define TRACER_PACKET_H

#include <stdalign.h>

#include "scene.h"

#define PACKET 16

typedef struct packet {
  alignas(64) struct RTCRayHit16 rays;
  alignas(64) struct RTCRay16 shadows;
  alignas(64) int valid[PACKET];
  alignas(64) int shadowed[PACKET]; /* which lanes have a shadow ray */
  struct RTCIntersectContext context;
  double sample_x[PACKET], sample_y[PACKET]; /* where in the picture, in pixels */
  const double *further[PACKET];             /* the samples' other numbers, from the third on, as the layout says */
  double lens[PACKET][2];                    /* points of the lens, along right and up; set where there is one */
  double time[PACKET];                       /* set where something moves */
  uint32_t lanes;                            /* how many are in use, the first ones */
  double radiance[PACKET][3];
  uint64_t shadow_rays;
} packet;

/* Sets what never changes. */
void packet_begin(packet *rays);

/* Traces and shades the lanes in use, from sample_x, sample_y and, where the layout has any, `further` to radiance. */
void packet_trace(const tracer *made, packet *rays);

/* Radiance where more than the primitive matters: patterns, lights, planes. Called by packet_trace. */
void packet_shade(const tracer *made, packet *rays);

#endif

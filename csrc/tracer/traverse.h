/* Rays through Embree's acceleration structure: those of a packet together, or fewer at a time, as the options say. */
#ifndef TRACER_TRAVERSE_H
#define TRACER_TRAVERSE_H

#include "scene.h"

/* Where fewer than PACKET rays go together. */
void traverse_closest_by_parts(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                               struct RTCRayHit16 *rays);
void traverse_any_by_parts(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                           struct RTCRay16 *rays);

/* The nearest surface on the way of the rays that are `valid` (-1). */
static inline void traverse_closest(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                                    struct RTCRayHit16 *rays) {
  if (made->options.packet == PACKET)
    rtcIntersect16(valid, made->scene, context, rays);
  else
    traverse_closest_by_parts(made, valid, context, rays);
}

/* Then: looks a second time where some of the rays met something and others nothing, which may have passed by roundings
 * through a corner that triangles share: they have met what both of two rays meet that go close by, one on either side.
 * Their directions stay as they are. */
void traverse_look_again(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                         struct RTCRayHit16 *rays);

/* Any surface: sets tfar to -inf. */
static inline void traverse_any(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                                struct RTCRay16 *rays) {
  if (made->options.packet == PACKET)
    rtcOccluded16(valid, made->scene, context, rays);
  else
    traverse_any_by_parts(made, valid, context, rays);
}

#endif

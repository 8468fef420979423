/* Light that reaches what the rays meet on a straight way from its source. */
#ifndef TRACER_DIRECT_H
#define TRACER_DIRECT_H

#include "meeting.h"

/* Adds to what the lanes gathered what the scene's lights give where their rays end. `met` has no material where a lane
 * is over. `context` says how much the shadow rays have in common. */
void direct_add_lights(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context);

static inline void direct_set_shadow_ray(struct RTCRay16 *ray, uint32_t lane, const vectors *origin,
                                         const double toward[3], double distance) {
  ray->org_x[lane] = (float)origin->row[0][lane];
  ray->org_y[lane] = (float)origin->row[1][lane];
  ray->org_z[lane] = (float)origin->row[2][lane];
  ray->dir_x[lane] = (float)toward[0];
  ray->dir_y[lane] = (float)toward[1];
  ray->dir_z[lane] = (float)toward[2];
  ray->tfar[lane] = (float)distance;
}

/* Traces the shadow rays of the lanes that are `shadowed`, which the rays that endless planes block are no more. Gives
 * how many there are. */
int direct_trace_shadows(const tracer *made, packet *rays, const vectors *origin, const vectors *toward,
                         const double distance[PACKET], struct RTCIntersectContext *context);

/* Whether a lane has a shadow ray, and that was not blocked: Embree sets tfar to -inf where it is. */
static inline int direct_reaches(const packet *rays, uint32_t lane) {
  return (rays->shadowed[lane] != 0) & !(rays->shadows.tfar[lane] < 0.0f);
}

#endif

/* Light of surfaces that shine, sent for from what the rays meet. */
#ifndef TRACER_EMITTED_H
#define TRACER_EMITTED_H

#include "meeting.h"

/* Adds to what the lanes gathered what one place of the surfaces that shine gives, to lanes whose path may go on;
 * counted for as much as rays that come upon such surfaces leave. `context` says how much the shadow rays have in
 * common. */
void emitted_add(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context);

/* What share of a surface's light counts on a ray that comes upon it, and so what share does not on one that was sent
 * to it, by the densities with which either finds the place. */
static inline double emitted_share_of_rays(emission_from from, double density_of_ray, double density_of_emitter) {
  const int both = density_of_emitter > 0.0 && from != FROM_RAYS;
  const double sum = both ? density_of_ray + density_of_emitter : 1.0;
  const double share = from == FROM_EMITTERS ? 0.0 : density_of_ray / sum;
  return both ? share : 1.0;
}

#endif

/* Light that reaches what the rays meet on a straight way from its source. */
#ifndef TRACER_DIRECT_H
#define TRACER_DIRECT_H

#include "emitter.h"

/* Adds to what the lanes gathered what the scene's lights give where their rays end. `met` has no material where a lane
 * is over. `context` says how much the shadow rays have in common. */
void direct_add_lights(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context);

/* The same of the surfaces that shine, one place of them, to lanes whose path may go on; counted for as much as rays
 * that come upon such surfaces leave. */
void direct_add_emitters(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context);

/* What share of a surface's light counts on a ray that comes upon it, and so what share does not on one that was sent
 * to it, by the densities with which either finds the place. */
double direct_share_of_rays(const tracer *made, double density_of_ray, double density_of_emitter);

#endif

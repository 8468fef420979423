/* Light that reaches what the rays meet on a straight way from its source. */
#ifndef TRACER_DIRECT_H
#define TRACER_DIRECT_H

#include "meeting.h"

/* Adds to the lanes' radiance what the scene's lights give where their rays end. `met` has no material where a lane is
 * over. `context` says how much the shadow rays have in common. */
void direct_add_lights(const tracer *made, packet *rays, const meeting met[PACKET],
                       struct RTCIntersectContext *context);

#endif

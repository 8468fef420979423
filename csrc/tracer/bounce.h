/* How paths go on from where rays end. */
#ifndef TRACER_BOUNCE_H
#define TRACER_BOUNCE_H

#include "meeting.h"

/* Sets the chances that the lanes' paths go on by the reflection and by the albedo. Gives 0 where all end. */
int bounce_set_chances(const transport *far, packet *rays, const meetings *met, uint32_t bounce);

/* Sends the lanes' paths on, and traces their rays. Gives 0 where all end. */
int bounce_go_on(const tracer *made, packet *rays, const meetings *met, uint32_t bounce);

#endif

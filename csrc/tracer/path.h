/* Paths from the eye, from surface to surface. */
#ifndef TRACER_PATH_H
#define TRACER_PATH_H

#include "packet.h"

/* Sets the radiance of the lanes in use, whose rays from the eye Embree has traced. */
void path_follow(const tracer *made, packet *rays);

#endif

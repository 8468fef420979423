/* Points of the lens. */
#ifndef TRACER_LENS_H
#define TRACER_LENS_H

#include <stddef.h>

#include "aliascope/scene.h"

/* Takes points of the unit square to points of the view's lens, uniform over it; tracer.h says how. */
void lens_points(const asc_view *view, size_t count, const double (*u)[2], double (*points)[2]);

#endif

/* Pictures of filters that reach past the pixel. */
#ifndef TRACER_FILTERED_H
#define TRACER_FILTERED_H

#include "crew.h"
#include "film.h"

/* Renders a picture, tracing the pixels within the film's reach of it too. */
asc_status filtered_render(const tracer *made, const asc_sampler *sampler, const film *target, uint32_t threads,
                           float *pixels, crew_cost *cost);

#endif

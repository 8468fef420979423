/* Pictures of filters that reach past the pixel. */
#ifndef TRACER_FILTERED_H
#define TRACER_FILTERED_H

#include "crew.h"
#include "film.h"

/* Renders all of a picture, `samples` points for each pixel, those within `film`'s reach of the picture among them. */
asc_status filtered_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, const film *target,
                           uint32_t threads, float *pixels, crew_cost *cost);

#endif

/* Pictures whose pixels get as many samples as an estimator of the library finds that they need. */
#ifndef TRACER_ADAPTIVE_H
#define TRACER_ADAPTIVE_H

#include "aliascope/estimate.h"
#include "crew.h"

/* Adds all samples to `samples`; `counts` may be NULL. `dimensions` are those of the estimator's sampler.
 * `error`, which names the first pixel that fails, is for one thread alone: NULL for more. */
asc_status adaptive_render(const tracer *made, const asc_estimator *estimator, uint32_t dimensions, uint32_t threads,
                           float *pixels, uint32_t *counts, crew_cost *cost, uint64_t *samples, asc_error *error);

#endif

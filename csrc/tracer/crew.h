/* Threads that share the units of a job. Nothing that is computed depends on who takes which unit. */
#ifndef TRACER_CREW_H
#define TRACER_CREW_H

#include "block.h"

/* Does one unit, with a thread's own memory. */
typedef asc_status (*crew_unit)(void *job, uint32_t unit, block_work *memory);

/* What a crew has done so far. */
typedef struct crew_cost {
  double cpu_seconds; /* of all threads */
  ray_counts rays;
} crew_cost;

/* Does units 0 to count - 1, this thread among `threads`, each with memory for the tracer, and adds to `cost`. Stops at
 * the first failure. */
asc_status crew_run(const tracer *made, uint32_t threads, uint32_t count, crew_unit unit, void *job, crew_cost *cost);

#endif

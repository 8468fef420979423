/* The rays of a picture, kept as the tracer gives them to Embree, and a bare loop that gives them to it again: to the
 * same structure in the same packets, rtcIntersect16 and rtcOccluded16 by themselves. These two functions are defined
 * here, in between: in the program itself, or in a library that symbols are looked for in before Embree's. */
#ifndef BENCH_KEPT_RAYS_H
#define BENCH_KEPT_RAYS_H

#include <stdint.h>

#include "aliascope/base.h"

typedef struct kept_counts {
  uint64_t intersected, occluded; /* rays given to rtcIntersect16, and to rtcOccluded16 */
  uint64_t hits;                  /* of the first: what the last bare loop found */
} kept_counts;

/* Forgets what was kept, and keeps the rays that are traced from here on, by one thread alone, in one structure. Gives
 * 0 where there is no Embree to give them to. */
ASC_API int kept_begin(void);
ASC_API void kept_end(void);

/* One bare loop over what was kept, whose structure must still be there: its CPU seconds. */
ASC_API double kept_loop(kept_counts *counts);

ASC_API void kept_free(void);

#endif

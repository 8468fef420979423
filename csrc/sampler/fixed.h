/* Patterns that are a table: sets of 1, 2, 4, ... points of the plane, in sixteenths, the same in every pixel. */
#ifndef ASC_FIXED_H
#define ASC_FIXED_H

#include "pattern.h"

typedef struct asc_fixed_table {
  const char *name;
  const uint8_t (*sixteenths)[2]; /* {x, y} of the set of 1, then of the set of 2, of 4, ... */
  uint64_t most;                  /* the points of the last set */
} asc_fixed_table;

/* ASC_UNSUPPORTED for a count that has no set, and in other than two dimensions. `table` outlives what is made. */
asc_status asc_fixed_create(const asc_fixed_table *table, const asc_sampler_config *config, asc_sampler_state *made,
                            asc_error *error);

/* For `fill` of the interface; `destroy` is free. */
asc_status asc_fixed_fill(const void *opaque, const asc_range *range, double *points);

#endif

/* Patterns of space and time, three dimensions x, y and t: N = k x k points, one in each cell of a k x k grid of the
 * plane, one in each of N slots of time. Which cell has which slot is the pattern: a table of the slots of cells.
 *
 * A pixel has the table moved: shifted along both axes (around the border), perhaps mirrored, transposed, and run
 * backward in time, at random. Every cell then has every slot equally often, so estimates are unbiased, and what the
 * tables are made for is kept: sums of rows, columns and broken diagonals, and distances around the border. Each point
 * is jittered in its cell and slot.
 *
 * Sample i lies in column i mod k and row i / k, the upper row first. centred=1 has the table itself, the same in every
 * pixel, the points at the centres of their cells and slots. */
#ifndef ASC_SPACE_TIME_H
#define ASC_SPACE_TIME_H

#include "pattern.h"

typedef struct asc_space_time asc_space_time;

/* The slot of a cell, 0 to side^2 - 1. */
typedef uint64_t (*asc_slot_function)(const asc_space_time *pattern, uint64_t column, uint64_t row);

struct asc_space_time {
  uint64_t seed, side, step; /* `step` and `slots` are the slot function's */
  int centred;
  asc_slot_function slot;
  uint32_t slots[];
};

/* The one parameter that these patterns have. */
extern const asc_parameter asc_space_time_centred;

/* A pattern with room for `slots` entries, its `step` 0, to be freed by free(), or NULL: out of memory. side up to
 * 2^24, so that N has room for a jitter in a double. */
asc_space_time *asc_space_time_new(const asc_sampler_config *config, uint64_t side, asc_slot_function slot,
                                   size_t slots);

/* ASC_UNSUPPORTED in other than three dimensions. */
asc_status asc_space_time_check(const char *name, const asc_sampler_config *config, asc_error *error);

asc_sampler_state asc_space_time_state(asc_space_time *pattern);

/* For `fill` of the interface. */
asc_status asc_space_time_fill(const void *opaque, const asc_range *range, double *points);

#endif

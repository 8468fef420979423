/* 1, 2, 4 or 8 points at the centres of cells of an 8 x 8 grid: those with the least edge discrepancy.
 *
 * Silicon Graphics' InfiniteReality took 1, 2, 4 or 8 samples on an 8 x 8 sub-pixel grid (Hanrahan 2000, CS348B, "Edge
 * discrepancy"). Which of its positions it used could not be found published. These are therefore not the hardware's:
 * they are the sets that have the least root mean square discrepancy of random edges, the measure by which Mitchell
 * (1992, "Ray tracing and irregularities of distribution") compared patterns, found by an exhaustive search over all
 * sets of 1, 2, 4 and 8 cells. make_sgi_positions.py defines the measure, makes the search and wrote the table. Of sets
 * that are equally good, which are each other's mirror images, it takes the first.
 *
 * Two dimensions; not randomised: every pixel has the same points. */
#include <stdlib.h>

#include "fixed.h"
#include "sgi_positions.h"

static const asc_fixed_table table = {"sgi-8x8", sgi_positions, 8};

static asc_status sgi_8x8_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  return asc_fixed_create(&table, config, made, error);
}

const asc_sampler_interface asc_sampler_sgi_8x8 = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "sgi-8x8",
    .title = "the best 1, 2, 4 or 8 cells of an 8 x 8 grid",
    .source = "least edge discrepancy, by search; the InfiniteReality's own positions are not published",
    .create = sgi_8x8_create,
    .destroy = free,
    .fill = asc_fixed_fill,
};

/* The grid on which the star discrepancy is met, for searches over it: in each dimension the points' coordinates, and 1
 * where the border is open. A corner of the grid is a rank in each dimension. */
#ifndef ASC_STAR_GRID_H
#define ASC_STAR_GRID_H

#include "measure.h"

typedef struct asc_star_grid {
  const asc_point_set *set;
  uint32_t *ranks;  /* [dimension][point]: of the point's coordinate among the different ones */
  double *values;   /* [dimension][rank], count + 1 of them a dimension; 1 after the last */
  uint32_t *levels; /* [dimension]: different coordinates */
} asc_star_grid;

/* The best corner so far. */
typedef struct asc_star_corner {
  double value;    /* |n/N - volume| */
  int closed;      /* with the points of the border counted in */
  uint32_t *ranks; /* [dimension] */
} asc_star_corner;

/* ASC_OK or ASC_OUT_OF_MEMORY; so does asc_star_threshold. */
asc_status asc_star_grid_make(asc_star_grid *grid, const asc_point_set *set);
void asc_star_grid_free(asc_star_grid *grid);

static inline const uint32_t *asc_star_ranks(const asc_star_grid *grid, uint32_t dimension) {
  return grid->ranks + dimension * grid->set->count;
}

static inline const double *asc_star_values(const asc_star_grid *grid, uint32_t dimension) {
  return grid->values + dimension * (grid->set->count + 1);
}

/* The last rank of a corner: an open one's is that of 1. */
static inline uint32_t asc_star_last(const asc_star_grid *grid, uint32_t dimension, int closed) {
  const uint32_t levels = grid->levels[dimension];
  return !closed && asc_star_values(grid, dimension)[levels - 1] < 1.0 ? levels : levels - 1;
}

static inline double asc_star_volume(const asc_star_grid *grid, const uint32_t *corner) {
  double volume = 1.0;
  for (uint32_t d = 0; d < grid->set->dimensions; d++) volume *= asc_star_values(grid, d)[corner[d]];
  return volume;
}

/* Takes a corner for the best, if it is: `inside` points are in its box. */
void asc_star_offer(const asc_star_grid *grid, const uint32_t *corner, int closed, double inside,
                    asc_star_corner *best);

/* Improves `best` by threshold accepting, `iterations` steps of at most about 2 N d each, drawn from the set's seed. */
asc_status asc_star_threshold(const asc_star_grid *grid, uint64_t iterations, asc_star_corner *best);

#endif

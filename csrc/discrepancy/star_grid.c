#include "star_grid.h"

#include <stdlib.h>
#include <string.h>

#include "coordinates.h"

static void rank_dimension(asc_star_grid *grid, uint32_t dimension, asc_coordinate *sorted) {
  const asc_point_set *set = grid->set;
  asc_sort_coordinates(set, dimension, sorted);
  double *values = grid->values + dimension * (set->count + 1);
  uint32_t *ranks = grid->ranks + dimension * set->count, levels = 0;
  for (size_t i = 0; i < set->count; i++) {
    if (levels == 0 || sorted[i].value != values[levels - 1]) values[levels++] = sorted[i].value;
    ranks[sorted[i].point] = levels - 1;
  }
  values[levels] = 1.0;
  grid->levels[dimension] = levels;
}

asc_status asc_star_grid_make(asc_star_grid *grid, const asc_point_set *set) {
  const size_t count = set->count;
  *grid = (asc_star_grid){.set = set};
  grid->ranks = malloc(count * set->dimensions * sizeof *grid->ranks);
  grid->values = malloc((count + 1) * set->dimensions * sizeof *grid->values);
  grid->levels = malloc(set->dimensions * sizeof *grid->levels);
  asc_coordinate *sorted = malloc(count * sizeof *sorted);
  asc_status status = ASC_OK;
  if (grid->ranks && grid->values && grid->levels && sorted)
    for (uint32_t d = 0; d < set->dimensions; d++) rank_dimension(grid, d, sorted);
  else
    status = ASC_OUT_OF_MEMORY;
  free(sorted);
  if (status) asc_star_grid_free(grid);
  return status;
}

void asc_star_grid_free(asc_star_grid *grid) {
  free(grid->ranks);
  free(grid->values);
  free(grid->levels);
  *grid = (asc_star_grid){.set = NULL};
}

void asc_star_offer(const asc_star_grid *grid, const uint32_t *corner, int closed, double inside,
                    asc_star_corner *best) {
  const double excess = inside / (double)grid->set->count - asc_star_volume(grid, corner);
  const double value = closed ? excess : -excess;
  if (!(value > best->value)) return;
  best->value = value;
  best->closed = closed;
  memcpy(best->ranks, corner, grid->set->dimensions * sizeof *corner);
}

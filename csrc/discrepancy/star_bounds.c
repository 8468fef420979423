/* Bounds of the star discrepancy, for more points or dimensions than can be done exactly.
 *
 * The lower bound is the best corner seen: by threshold accepting first (star_threshold.c), then by the search for the
 * upper one. For that the corners are parted into cells, as in Thiemard 2001, "An algorithm to compute bounds for the
 * star discrepancy" (J. Complexity 17): between the corners lo and hi no box has more than
 *   vol(hi) - n([0, lo))/N   too few points, its border open,
 *   n([0, hi])/N - vol(lo)   too many, its border closed.
 * A cell is cut while that is above the lower bound plus the wanted gap, along the dimension in which it is widest, and
 * where the upper part should just pass (Thiemard's choice, section 3, but by what is counted instead of for all cells
 * alike; and lo and hi are corners of the grid, so that a cell ends at a single one, and a gap of 0 is the exact
 * value).
 *
 * Gaps are tried from wide to narrow, until the wanted one is reached or as much work done as is allowed, which is
 * counted in points looked at. The upper bound is that of the narrowest gap that was done. It is true whatever the
 * work: 1 if there was none. Both are true to rounding: the upper one is rounded up, the lower one to the nearest
 * double. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "star_grid.h"

#define MOST_POINTS ((size_t)1 << 28)
#define FIRST_CELLS 256
#define FIRST_GAP 0.9
#define LEAST_GAP 0x1p-20 /* the next one is the wanted one, even if that is 0 */

enum { GAP, ITERATIONS, WORK };

static const asc_parameter parameters[] = {
    {"gap", ASC_REAL, NULL, 0.0, 1.0, 0.01, "wanted between the bounds; 0: the exact value"},
    {"iterations", ASC_INTEGER, NULL, 0.0, 1e9, 4000.0, "steps of threshold accepting, for the lower bound"},
    {"work", ASC_REAL, NULL, 0.0, 1e9, 300.0, "most points looked at for the upper bound, in millions"},
};

/* Cells still to be looked at. The points that are in some but not in all boxes of a cell are points[begin, end); those
 * of a cell's parts are among them, so that all cells share one array. */
typedef struct star_cell {
  size_t begin, end;
  size_t inside; /* points in all boxes of the cell */
  uint32_t cut;  /* the dimension in which lo was raised last */
} star_cell;

typedef struct bound_search {
  const asc_star_grid *grid;
  asc_star_corner *best;
  int closed;
  double gap;       /* tried now */
  double upper;     /* of the cells that were done */
  double work_left; /* in points */
  uint32_t *points;
  star_cell *cells; /* a stack, and of each the ranks of lo, then of hi */
  uint32_t *ranks;
  size_t count, capacity;
} bound_search;

static uint32_t *low_of(const bound_search *search, size_t index) {
  return search->ranks + 2 * index * search->grid->set->dimensions;
}

static uint32_t *high_of(const bound_search *search, size_t index) {
  return low_of(search, index) + search->grid->set->dimensions;
}

/* Room for one more cell. */
static asc_status make_room(bound_search *search) {
  if (search->count < search->capacity) return ASC_OK;
  const size_t capacity = 2 * search->capacity;
  star_cell *cells = realloc(search->cells, capacity * sizeof *cells);
  if (cells) search->cells = cells;
  uint32_t *ranks = realloc(search->ranks, capacity * 2 * search->grid->set->dimensions * sizeof *ranks);
  if (ranks) search->ranks = ranks;
  if (!cells || !ranks) return ASC_OUT_OF_MEMORY;
  search->capacity = capacity;
  return ASC_OK;
}

/* The scale for which the corner max(lo, scale hi) has this volume; 1 where none below has. */
static double scale_to(const bound_search *search, const uint32_t *low, const uint32_t *high, double volume) {
  const uint32_t dimensions = search->grid->set->dimensions;
  double scale = 1.0;
  for (;;) { /* no more rounds than dimensions: in each but the last, lo is reached in one more */
    double product = 1.0;
    uint32_t scaled = 0;
    for (uint32_t d = 0; d < dimensions; d++) {
      const double *values = asc_star_values(search->grid, d);
      const int stays = values[low[d]] >= scale * values[high[d]];
      product *= values[stays ? low[d] : high[d]];
      scaled += !stays;
    }
    if (scaled == 0 || !(product > 0.0)) return scale;
    const double next = pow(volume / product, 1.0 / scaled);
    if (!(next < scale)) return scale;
    scale = next;
  }
}

/* Where a cell is cut: the dimension, and the first rank of the upper part. */
static uint32_t choose_cut(const bound_search *search, const uint32_t *low, const uint32_t *high, double volume,
                           uint32_t *cut) {
  const double scale = scale_to(search, low, high, volume);
  uint32_t widest = 0;
  double least = INFINITY;
  for (uint32_t d = 0; d < search->grid->set->dimensions; d++) {
    if (low[d] == high[d]) continue;
    const double *values = asc_star_values(search->grid, d);
    const double ratio = values[low[d]] / values[high[d]];
    if (!(ratio < least)) continue;
    least = ratio;
    widest = d;
  }
  const double *values = asc_star_values(search->grid, widest);
  uint32_t below = low[widest], above = high[widest]; /* the cut is behind the one, and at most at the other */
  while (above - below > 1) {
    const uint32_t middle = below + (above - below) / 2;
    if (values[middle] < scale * values[high[widest]])
      below = middle;
    else
      above = middle;
  }
  *cut = above;
  return widest;
}

static void swap_places(uint32_t *points, size_t a, size_t b) {
  const uint32_t kept = points[a];
  points[a] = points[b];
  points[b] = kept;
}

/* Moves the points that are in no box of the cell, hi having been lowered along a dimension, behind its end. */
static void drop_outside(bound_search *search, star_cell *cell, uint32_t dimension, uint32_t high) {
  const uint32_t *ranks = asc_star_ranks(search->grid, dimension), limit = high + (uint32_t)search->closed;
  for (size_t i = cell->begin; i < cell->end;)
    if (ranks[search->points[i]] < limit)
      i++;
    else
      swap_places(search->points, i, --cell->end);
}

static int is_inside(const bound_search *search, const uint32_t *low, uint32_t point) {
  for (uint32_t d = 0; d < search->grid->set->dimensions; d++)
    if (asc_star_ranks(search->grid, d)[point] >= low[d] + (uint32_t)search->closed) return 0;
  return 1;
}

/* Moves the points that are in all boxes of the cell, lo having been raised along a dimension, before its beginning. */
static void take_inside(bound_search *search, star_cell *cell, const uint32_t *low) {
  const uint32_t *ranks = asc_star_ranks(search->grid, cell->cut), limit = low[cell->cut] + (uint32_t)search->closed;
  for (size_t i = cell->begin; i < cell->end; i++) {
    if (ranks[search->points[i]] >= limit || !is_inside(search, low, search->points[i])) continue;
    swap_places(search->points, i, cell->begin++);
    cell->inside++;
  }
}

/* Looks at the topmost cell: it is done, or cut into two. */
static asc_status visit(bound_search *search) {
  const asc_star_grid *grid = search->grid;
  const size_t top = search->count - 1;
  const uint32_t dimensions = grid->set->dimensions;
  asc_status status = make_room(search);
  if (status) return status;
  star_cell *cell = search->cells + top;
  uint32_t *low = low_of(search, top), *high = high_of(search, top);
  search->work_left -= (double)(cell->end - cell->begin + 4 * (size_t)dimensions);
  take_inside(search, cell, low);
  const double inside = (double)cell->inside, points = (double)grid->set->count;
  const double within = inside + (double)(cell->end - cell->begin);
  const double low_volume = asc_star_volume(grid, low), high_volume = asc_star_volume(grid, high);
  if (search->closed)
    asc_star_offer(grid, high, 1, within, search->best);
  else
    asc_star_offer(grid, low, 0, inside, search->best);
  const double bound = search->closed ? within / points - low_volume : high_volume - inside / points;
  const double enough = search->best->value + search->gap;
  if (bound <= enough) {
    /* NOLINTNEXTLINE(clang-analyzer-unix.Malloc): search holds what low and high point into; its maker frees it */
    if (bound > search->upper) search->upper = bound;
    search->count--;
    return ASC_OK;
  }
  /* Where the upper part passes: surely where the border is closed, else if the density stays what it was. */
  const double volume = search->closed ? within / points - enough : low_volume + (bound - enough);
  uint32_t cut;
  const uint32_t dimension = choose_cut(search, low, high, volume, &cut);
  cell[1] = cell[0];
  memcpy(low_of(search, top + 1), low, (size_t)2 * dimensions * sizeof *low);
  high_of(search, top + 1)[dimension] = cut - 1;
  drop_outside(search, cell + 1, dimension, cut - 1);
  low[dimension] = cut;
  cell->cut = dimension;
  search->count++;
  return ASC_OK;
}

/* Looks at all cells; tells in `done` whether the work allowed was enough. */
static asc_status look_at_all(bound_search *search, int closed, int *done) {
  const asc_point_set *set = search->grid->set;
  search->closed = closed;
  search->count = 0;
  asc_status status = ASC_OK;
  search->cells[0] = (star_cell){.end = set->count};
  search->count = 1;
  for (size_t i = 0; i < set->count; i++) search->points[i] = (uint32_t)i;
  for (uint32_t d = 0; d < set->dimensions; d++) {
    low_of(search, 0)[d] = 0;
    high_of(search, 0)[d] = asc_star_last(search->grid, d, closed);
    drop_outside(search, search->cells, d, high_of(search, 0)[d]);
  }
  while (status == ASC_OK && search->count > 0 && search->work_left > 0.0) status = visit(search);
  *done = search->count == 0;
  return status;
}

/* Tries one gap after the other; `upper` is what was reached. */
static asc_status narrow(bound_search *search, double wanted, double *upper) {
  /* About four times the work from one to the next, if that is as the gap to the power of minus the dimensions. */
  const double ratio = exp2(-2.0 / search->grid->set->dimensions);
  asc_status status = ASC_OK;
  int done = 1;
  *upper = 1.0;
  search->gap = wanted > FIRST_GAP ? wanted : FIRST_GAP;
  for (;;) {
    search->upper = 0.0;
    for (int closed = 0; closed < 2 && status == ASC_OK && done; closed++) status = look_at_all(search, closed, &done);
    if (status || !done) return status;
    const double found = search->upper > search->best->value ? search->upper : search->best->value;
    if (found < *upper) *upper = found;
    if (*upper - search->best->value <= wanted) return ASC_OK;
    search->gap *= ratio;
    if (search->gap < wanted || search->gap < LEAST_GAP) search->gap = wanted;
  }
}

/* The same as star says of a corner: counted again, in long double. */
static void report(const asc_star_grid *grid, const asc_star_corner *best, double upper, asc_measurement *made) {
  const asc_point_set *set = grid->set;
  long double volume = 1.0L, inside = 0.0L;
  for (uint32_t d = 0; d < set->dimensions; d++) volume *= asc_star_values(grid, d)[best->ranks[d]];
  for (size_t i = 0; i < set->count; i++) {
    int in = 1;
    for (uint32_t d = 0; d < set->dimensions; d++)
      in &= asc_star_ranks(grid, d)[i] < best->ranks[d] + (uint32_t)best->closed;
    inside += in;
  }
  /* One rounding a dimension, one each for the share and the difference, and one for this. */
  const double rounded = upper + (set->dimensions + 3.0) * 0x1p-53;
  made->value = made->lower = (double)fabsl(inside / (long double)set->count - volume);
  made->upper = rounded < 1.0 ? rounded : 1.0;
  made->certainty = ASC_BOUNDS;
  made->closed = (uint32_t)best->closed;
  if (set->dimensions > ASC_WITNESS_MOST) return;
  made->witness_count = set->dimensions;
  for (uint32_t d = 0; d < set->dimensions; d++) made->witness[d] = asc_star_values(grid, d)[best->ranks[d]];
}

static asc_status star_bounds_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                       asc_error *error) {
  if (set->count > MOST_POINTS)
    return asc_fail(error, ASC_UNSUPPORTED, "star-bounds is of up to 2^28 points; these are %zu", set->count);
  asc_star_grid grid;
  asc_status status = asc_star_grid_make(&grid, set);
  if (status) return asc_fail(error, status, "out of memory");
  uint32_t *corner = calloc(set->dimensions, sizeof *corner);
  asc_star_corner best = {.value = -1.0, .ranks = corner};
  bound_search search = {.grid = &grid, .best = &best, .capacity = FIRST_CELLS, .work_left = values[WORK] * 1e6};
  search.points = malloc(set->count * sizeof *search.points);
  search.cells = malloc(FIRST_CELLS * sizeof *search.cells);
  search.ranks = calloc((size_t)2 * set->dimensions, FIRST_CELLS * sizeof *search.ranks);
  if (corner && search.points && search.cells && search.ranks) {
    double upper = 1.0;
    /* Some corner is met, whatever is allowed. */
    asc_star_offer(&grid, corner, 0, 0.0, &best);
    status = asc_star_threshold(&grid, (uint64_t)values[ITERATIONS], &best);
    if (status == ASC_OK) status = narrow(&search, values[GAP], &upper);
    if (status == ASC_OK) report(&grid, &best, upper, made);
  } else
    status = ASC_OUT_OF_MEMORY;
  free(corner);
  free(search.points);
  free(search.cells);
  free(search.ranks);
  asc_star_grid_free(&grid);
  return status ? asc_fail(error, status, "out of memory") : ASC_OK;
}

const asc_measure_interface asc_measure_star_bounds = {
    .name = "star-bounds",
    .title = "bounds of star, in any dimension; the value is the lower one, met at the corner (of eight dimensions at "
             "most)",
    .source = "Thiemard 2001; Gnewuch, Wahlstroem and Winzen 2012",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .least_dimensions = 1,
    .most_dimensions = ASC_ANY_DIMENSION,
    .quick_points = 10000,
    .evaluate = star_bounds_evaluate,
};

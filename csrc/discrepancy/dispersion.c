/* The dispersion: the largest place without a point in the unit square.
 *
 * `of=box`: the area of the largest open axis-parallel box in the square. Naamad, Lee and Hsu 1984, "On the maximum
 * empty rectangle problem": the sides of a largest one lie at points or at the border. A line is swept from the left
 * border, and from each point, to the right; the box above and below the beginning narrows where a point is met, until
 * it is too low to be the largest: O(N^2), and about O(N^2 / log N) where points are even.
 *
 * `of=disc`: the radius of the largest open disc with its centre in the square, which is the greatest distance to the
 * nearest point. It is met at a vertex of the Voronoi cells, cut off at the border (Shamos and Hoey 1975,
 * "Closest-point problems"). A cell is cut out of the square, by one neighbour after the other and the nearest first,
 * for as long as it reaches further than the largest disc so far. */
#include <math.h>
#include <stdlib.h>

#include "measure.h"

#define MOST_POINTS ((size_t)1 << 24)
#define POINTS_PER_CELL 2.0

enum { OF };
enum { BOX, DISC };

static const asc_parameter parameters[] = {
    {"of", ASC_CHOICE, "box|disc", 0.0, 1.0, BOX, "the area of a box, or the radius of a disc"},
};

typedef struct site {
  double x, y;
} site;

static int by_x(const void *a, const void *b) {
  const site *p = a, *q = b;
  return p->x != q->x ? (p->x > q->x) - (p->x < q->x) : (p->y > q->y) - (p->y < q->y);
}

static int by_y(const void *a, const void *b) {
  const site *p = a, *q = b;
  return (p->y > q->y) - (p->y < q->y);
}

/* --- boxes ----------------------------------------------------------------------------------------------------------
 */

typedef struct largest_box {
  double area, lower[2], upper[2];
} largest_box;

static void offer_box(largest_box *best, double x0, double y0, double x1, double y1) {
  const double area = (x1 - x0) * (y1 - y0);
  if (area > best->area) *best = (largest_box){area, {x0, y0}, {x1, y1}};
}

/* The boxes whose left side is at the point `from`, which lies within that side; `next` is the first further right. */
static void sweep_right(largest_box *best, const site *sites, size_t count, site from, size_t next) {
  double low = 0.0, high = 1.0;
  for (size_t i = next; i < count; i++) {
    const site met = sites[i];
    if (met.y <= low || met.y >= high) continue;
    offer_box(best, from.x, low, met.x, high);
    if (met.y == from.y) return;
    if (met.y > from.y)
      high = met.y;
    else
      low = met.y;
    if ((1.0 - from.x) * (high - low) <= best->area) return;
  }
  offer_box(best, from.x, low, 1.0, high);
}

/* The boxes from the left border whose right side is at the point `from`; those before `end` are further left. */
static void sweep_left(largest_box *best, const site *sites, site from, size_t end) {
  double low = 0.0, high = 1.0;
  for (size_t i = end; i-- > 0;) {
    const site met = sites[i];
    if (met.y <= low || met.y >= high) continue;
    if (met.y == from.y) return;
    if (met.y > from.y)
      high = met.y;
    else
      low = met.y;
    if (from.x * (high - low) <= best->area) return;
  }
  offer_box(best, 0.0, low, from.x, high);
}

/* `sites` are sorted along x, and along y at the end. */
static void empty_box(site *sites, size_t count, asc_measurement *made) {
  largest_box best = {.area = 0.0};
  for (size_t first = 0, next = 0; first < count; first = next) {
    while (next < count && sites[next].x == sites[first].x) next++;
    for (size_t i = first; i < next; i++) {
      sweep_right(&best, sites, count, sites[i], next);
      sweep_left(&best, sites, sites[i], first);
    }
  }
  qsort(sites, count, sizeof *sites, by_y);
  for (size_t i = 0; i <= count; i++)
    offer_box(&best, 0.0, i == 0 ? 0.0 : sites[i - 1].y, 1.0, i == count ? 1.0 : sites[i].y);
  asc_measured(made, best.area);
  made->witness_count = 4;
  for (size_t d = 0; d < 2; d++) {
    made->witness[d] = best.lower[d];
    made->witness[d + 2] = best.upper[d];
  }
}

/* --- discs ----------------------------------------------------------------------------------------------------------
 */

typedef struct corner {
  long double x, y;
} corner;

typedef struct disc_search {
  const site *sites; /* cell by cell of a grid, from the lower left on */
  size_t count;
  size_t grid;    /* cells a side */
  size_t *starts; /* of a cell's sites; one more for the end */
  corner *cell;   /* the corners of one site's cell, in order */
  corner *cut;    /* room for it to be cut */
  size_t corners;
  long double reach; /* squared: the farthest corner of the cell from its site */
  long double best;  /* squared */
  corner centre;
} disc_search;

static long double squared(long double x, long double y) { return x * x + y * y; }

static size_t grid_place(const disc_search *search, double value) {
  const size_t place = (size_t)(value * (double)search->grid);
  return place < search->grid ? place : search->grid - 1;
}

/* How far a place is on the side of `other`, seen from between it and `own`. */
static long double over(corner at, site own, site other) {
  const long double dx = (long double)other.x - own.x, dy = (long double)other.y - own.y;
  return (at.x - ((long double)own.x + other.x) / 2.0L) * dx + (at.y - ((long double)own.y + other.y) / 2.0L) * dy;
}

/* Where the side from `kept` to `lost` is cut. Corners move along sides only, so that no error grows from cut to cut.
 */
static corner cut_side(corner kept, corner lost, site own, site other) {
  const long double before = over(kept, own, other), share = before / (before - over(lost, own, other));
  return (corner){kept.x + share * (lost.x - kept.x), kept.y + share * (lost.y - kept.y)};
}

/* Cuts from the cell of `own` what is closer to `other`: the corners next to the one that is furthest over, as far as
 * they are over too. Others that are, are so by rounding. */
static void cut_cell(disc_search *search, site own, site other) {
  const corner *cell = search->cell;
  const size_t corners = search->corners;
  if (squared((long double)other.x - own.x, (long double)other.y - own.y) >= 4.0L * search->reach) return;
  long double most = 0.0L;
  size_t top = corners;
  for (size_t i = 0; i < corners; i++) {
    const long double here = over(cell[i], own, other);
    if (here <= most) continue;
    most = here;
    top = i;
  }
  if (top == corners) return;
  size_t lost = 1, first = top, next = (top + 1) % corners;
  for (; lost < corners && over(cell[next], own, other) > 0.0L; lost++) next = (next + 1) % corners;
  size_t before = (first + corners - 1) % corners;
  for (; lost < corners && over(cell[before], own, other) > 0.0L; lost++) {
    first = before;
    before = (before + corners - 1) % corners;
  }
  corner *cut = search->cut;
  size_t made = 0;
  /* A cell that is lost whole is narrower than rounding, and its corners are its neighbours' too. */
  if (lost < corners) {
    for (size_t i = 0; i < corners - lost; i++) cut[made++] = cell[(next + i) % corners];
    cut[made++] = cut_side(cell[before], cell[first], own, other);
    cut[made++] = cut_side(cell[next], cell[(next + corners - 1) % corners], own, other);
  }
  search->reach = 0.0L;
  for (size_t i = 0; i < made; i++) {
    const long double far = squared(cut[i].x - own.x, cut[i].y - own.y);
    if (far > search->reach) search->reach = far;
  }
  search->cut = search->cell;
  search->cell = cut;
  search->corners = made;
}

/* Cuts by the sites of the grid's cells (first_x..last_x, y); tells whether the site's cell still reaches out. */
static int cut_by_row(disc_search *search, site own, size_t first_x, size_t last_x, size_t y) {
  const size_t *starts = search->starts + y * search->grid;
  for (size_t i = starts[first_x]; i < starts[last_x + 1]; i++) {
    cut_cell(search, own, search->sites[i]);
    if (search->reach <= search->best) return 0;
  }
  return 1;
}

/* Cuts by the grid's cells in rings around the site's own, until the next ring is too far off to cut. */
static void look_around(disc_search *search, site own) {
  const size_t grid = search->grid, x = grid_place(search, own.x), y = grid_place(search, own.y);
  const corner square[] = {{0.0L, 0.0L}, {1.0L, 0.0L}, {1.0L, 1.0L}, {0.0L, 1.0L}};
  search->corners = 4;
  search->reach = 0.0L;
  for (size_t i = 0; i < 4; i++) {
    search->cell[i] = square[i];
    const long double far = squared(square[i].x - own.x, square[i].y - own.y);
    if (far > search->reach) search->reach = far;
  }
  for (size_t ring = 0; ring < grid; ring++) {
    if (search->reach <= search->best) return;
    /* All further sites are that far away at least; less a hair, for a place in the grid is rounded. */
    const long double apart = ((long double)ring - 1.0L) / (long double)grid - 0x1p-50L;
    if (ring > 1 && apart * apart >= 4.0L * search->reach) break;
    const size_t left = x > ring ? x - ring : 0, right = x + ring < grid ? x + ring : grid - 1;
    const size_t low = y > ring ? y - ring : 0, high = y + ring < grid ? y + ring : grid - 1;
    for (size_t row = low; row <= high; row++) {
      if (row + ring == y || row == y + ring) {
        if (!cut_by_row(search, own, left, right, row)) return;
        continue;
      }
      if (x >= ring && !cut_by_row(search, own, x - ring, x - ring, row)) return;
      if (x + ring < grid && !cut_by_row(search, own, x + ring, x + ring, row)) return;
    }
  }
  for (size_t i = 0; i < search->corners; i++) {
    const corner at = search->cell[i];
    const long double far = squared(at.x - own.x, at.y - own.y);
    if (far <= search->best) continue;
    search->best = far;
    search->centre = at;
  }
}

/* Sorts the sites into the grid's cells. */
static void fill_grid(disc_search *search, const site *sites, site *sorted) {
  const size_t cells = search->grid * search->grid;
  for (size_t i = 0; i < search->count; i++)
    search->starts[grid_place(search, sites[i].y) * search->grid + grid_place(search, sites[i].x) + 1]++;
  for (size_t cell = 0; cell < cells; cell++) search->starts[cell + 1] += search->starts[cell];
  for (size_t i = search->count; i-- > 0;) {
    const size_t cell = grid_place(search, sites[i].y) * search->grid + grid_place(search, sites[i].x);
    sorted[--search->starts[cell + 1]] = sites[i];
  }
  /* Each start has moved to the cell before it. */
  for (size_t cell = 0; cell < cells; cell++) search->starts[cell] = search->starts[cell + 1];
  search->starts[cells] = search->count;
  search->sites = sorted;
}

/* The radius is that about the centre as it is given, rounded. */
static double distance_to_nearest(const site *sites, size_t count, const double *centre) {
  long double least = INFINITY;
  for (size_t i = 0; i < count; i++) {
    const long double apart = squared((long double)centre[0] - sites[i].x, (long double)centre[1] - sites[i].y);
    if (apart < least) least = apart;
  }
  return (double)sqrtl(least);
}

static asc_status empty_disc(const site *sites, size_t count, asc_measurement *made, asc_error *error) {
  disc_search search = {.count = count, .grid = (size_t)ceil(sqrt((double)count / POINTS_PER_CELL)), .best = -1.0L};
  site *sorted = calloc(count, sizeof *sorted);
  search.starts = calloc(search.grid * search.grid + 1, sizeof *search.starts);
  /* Each cut adds one corner at most. */
  corner *room = malloc(2 * (count + 4) * sizeof *room);
  asc_status status = ASC_OK;
  if (sorted && search.starts && room) {
    search.cell = room;
    search.cut = room + count + 4;
    fill_grid(&search, sites, sorted);
    for (size_t i = 0; i < count; i++) look_around(&search, sorted[i]);
    made->witness_count = 3;
    made->witness[0] = (double)search.centre.x;
    made->witness[1] = (double)search.centre.y;
    made->witness[2] = distance_to_nearest(sites, count, made->witness);
    asc_measured(made, made->witness[2]);
  } else
    status = asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  free(sorted);
  free(search.starts);
  free(room);
  return status;
}

static asc_status dispersion_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                      asc_error *error) {
  if (set->count > MOST_POINTS)
    return asc_fail(error, ASC_UNSUPPORTED, "dispersion is of up to 2^24 points; these are %zu", set->count);
  site *sites = malloc(set->count * sizeof *sites);
  if (!sites) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < set->count; i++) sites[i] = (site){set->points[2 * i], set->points[2 * i + 1]};
  qsort(sites, set->count, sizeof *sites, by_x);
  asc_status status = ASC_OK;
  if ((int)values[OF] == BOX)
    empty_box(sites, set->count, made);
  else
    status = empty_disc(sites, set->count, made, error);
  free(sites);
  return status;
}

const asc_measure_interface asc_measure_dispersion = {
    .name = "dispersion",
    .title = "largest empty box's area, met at its corners; or largest empty disc's radius, met at centre and radius",
    .source = "Naamad, Lee and Hsu 1984; Shamos and Hoey 1975",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .least_dimensions = 2,
    .most_dimensions = 2,
    .quick_points = 50000,
    .evaluate = dispersion_evaluate,
};

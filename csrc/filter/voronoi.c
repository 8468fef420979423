/* Each cell is the rectangle, cut by the line half-way to each of the site's neighbours in the Delaunay triangulation.
 *
 * Corners are found by cutting, not as centres of circles: those of nearly flat triangles lie far away with few digits,
 * and places on one line have no circles at all. The neighbours come counterclockwise, so a cut mostly begins where the
 * one before ended; a cell of k corners takes time k, or k^2 where many of its corners lie outside. */
#include "voronoi.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct keyed_place {
  asc_place place;
  struct asc_rest rest;
  uint32_t sample;
} keyed_place;

static int by_place(const void *a, const void *b) {
  const keyed_place *left = a, *right = b;
  if (left->place.x != right->place.x) return left->place.x < right->place.x ? -1 : 1;
  if (left->place.y != right->place.y) return left->place.y < right->place.y ? -1 : 1;
  return 0;
}

/* A coordinate on the grid, and what it is from there: no rounding but of the rest (Knuth's two-sum). */
static int64_t step_of(double coordinate, double centre, double step, double *rest) {
  const double moved = coordinate - centre, back = moved - coordinate;
  const double lost = (coordinate - (moved - back)) - (centre + back), steps = moved / step;
  const int64_t place = llround(steps);
  *rest = (steps - (double)place) + lost / step;
  return place;
}

static void find_sites(const keyed_place *sorted, size_t count, asc_voronoi *made) {
  for (size_t i = 0; i < count; i++) {
    if (i == 0 || by_place(&sorted[i - 1], &sorted[i]) != 0) {
      made->places[made->count] = sorted[i].place;
      made->rests[made->count] = sorted[i].rest;
      made->samples[made->count++] = 0;
    }
    /* Of those in one step the least, whatever their order. */
    made->rests[made->count - 1].x = fmin(made->rests[made->count - 1].x, sorted[i].rest.x);
    made->rests[made->count - 1].y = fmin(made->rests[made->count - 1].y, sorted[i].rest.y);
    made->samples[made->count - 1]++;
    made->site[sorted[i].sample] = (uint32_t)(made->count - 1);
  }
}

/* In steps. The rests of two samples so far apart turn the line between them by less than 2^-35. */
#define NEAR 0x1p35

static int any_are_near(const asc_voronoi *made) {
  for (uint32_t edge = 0; edge < made->mesh.edges; edge++) {
    if (made->mesh.origin[edge] == ASC_NONE) continue;
    const struct asc_rest way = asc_voronoi_way(made, made->mesh.origin[edge], asc_edge_end(&made->mesh, edge));
    if (fabs(way.x) < NEAR && fabs(way.y) < NEAR) return 1;
  }
  return 0;
}

/* Of samples within a few steps of each other the neighbours on the grid may not be those where the samples are: cells
 * cut with the one and the other overlap, or leave gaps. Then all are taken where the grid has them. */
static asc_status settle_rests(asc_voronoi *made) {
  if (!any_are_near(made)) return ASC_OK;
  asc_cell cell;
  asc_status status = asc_cell_create(made, &cell);
  if (status) return status;
  double sum = 0.0;
  for (uint32_t site = 0; site < made->count; site++) {
    asc_cell_of(made, site, &cell);
    sum += asc_cell_area(&cell);
  }
  asc_cell_destroy(&cell);
  const double whole = 4.0 * made->width * made->height;
  const double roundings = 1e-12 + 8.0 * DBL_EPSILON * (double)made->count; /* of each cell some, of the whole */
  if (!(fabs(sum - whole) <= roundings * whole)) memset(made->rests, 0, made->count * sizeof *made->rests);
  return ASC_OK;
}

asc_status asc_voronoi_create(const double *points, size_t count, const asc_rectangle *bounds, asc_voronoi *made) {
  *made = (asc_voronoi){0};
  const double half_width = 0.5 * bounds->right - 0.5 * bounds->left;
  const double half_height = 0.5 * bounds->top - 0.5 * bounds->bottom;
  const double x = 0.5 * bounds->left + 0.5 * bounds->right, y = 0.5 * bounds->bottom + 0.5 * bounds->top;
  int exponent; /* half the longer side is at most 2^exponent, that is 2^51 steps */
  const double part = frexp(fmax(half_width, half_height), &exponent);
  if (part == 0.5) exponent--;
  made->step = ldexp(1.0, exponent - 51);
  made->width = half_width / made->step;
  made->height = half_height / made->step;
  made->places = malloc(count * sizeof *made->places);
  made->rests = malloc(count * sizeof *made->rests);
  made->samples = malloc(count * sizeof *made->samples);
  made->site = malloc(count * sizeof *made->site);
  keyed_place *sorted = malloc(count * sizeof *sorted);
  asc_status status = ASC_OUT_OF_MEMORY;
  if (made->places && made->rests && made->samples && made->site && sorted) {
    for (size_t i = 0; i < count; i++) {
      sorted[i].place.x = step_of(points[2 * i], x, made->step, &sorted[i].rest.x);
      sorted[i].place.y = step_of(points[2 * i + 1], y, made->step, &sorted[i].rest.y);
      sorted[i].sample = (uint32_t)i;
    }
    qsort(sorted, count, sizeof *sorted, by_place);
    find_sites(sorted, count, made);
    status = asc_delaunay_create(made->places, made->count, &made->mesh);
    if (status == ASC_OK) status = settle_rests(made);
  }
  free(sorted);
  if (status) asc_voronoi_destroy(made);
  return status;
}

void asc_voronoi_destroy(asc_voronoi *made) {
  free(made->places);
  free(made->rests);
  free(made->samples);
  free(made->site);
  asc_delaunay_destroy(&made->mesh);
  *made = (asc_voronoi){0};
}

asc_status asc_cell_create(const asc_voronoi *diagram, asc_cell *cell) {
  const asc_delaunay *mesh = &diagram->mesh;
  *cell = (asc_cell){.any = ASC_NONE};
  uint32_t *degree = calloc(diagram->count, sizeof *degree), most = 0;
  if (!degree) return ASC_OUT_OF_MEMORY;
  for (uint32_t edge = 0; edge < mesh->edges; edge++)
    if (mesh->origin[edge] != ASC_NONE && ++degree[mesh->origin[edge]] > most) most = degree[mesh->origin[edge]];
  free(degree);
  cell->corners = malloc((4 + 2 * (size_t)most) * sizeof *cell->corners); /* a cut adds two */
  return cell->corners ? ASC_OK : ASC_OUT_OF_MEMORY;
}

void asc_cell_destroy(asc_cell *cell) {
  free(cell->corners);
  *cell = (asc_cell){.any = ASC_NONE};
}

/* The line half-way to a neighbour at (x, y): what is beyond it has x * . + y * . > half. */
typedef struct bisector {
  double x, y, half;
} bisector;

static double beyond(const bisector *line, const asc_corner *corner) {
  return line->x * corner->x + line->y * corner->y - line->half;
}

/* A corner beyond the line, or ASC_NONE; cell->any, where the cut before ended, is tried first. */
static uint32_t corner_beyond(const asc_cell *cell, const bisector *line) {
  uint32_t at = cell->any;
  do {
    if (beyond(line, &cell->corners[at]) > 0.0) return at;
    at = cell->corners[at].next;
  } while (at != cell->any);
  return ASC_NONE;
}

/* Adds the place where the line crosses the side from corner `in` to `out`, which is beyond it. */
static uint32_t add_crossing(asc_cell *cell, const bisector *line, uint32_t in, uint32_t out) {
  const asc_corner *a = &cell->corners[in], *b = &cell->corners[out];
  const double from = -beyond(line, a), to = beyond(line, b), part = from / (from + to);
  cell->corners[cell->used] = (asc_corner){.x = a->x + part * (b->x - a->x), .y = a->y + part * (b->y - a->y)};
  return cell->used++;
}

static void link(asc_cell *cell, uint32_t first, uint32_t second) {
  cell->corners[first].next = second;
  cell->corners[second].before = first;
}

static void cut(asc_cell *cell, const bisector *line) {
  const uint32_t start = corner_beyond(cell, line);
  if (start == ASC_NONE) return;
  const asc_corner *corners = cell->corners;
  uint32_t first = start, last = start;
  while (corners[first].before != start && beyond(line, &corners[corners[first].before]) > 0.0)
    first = corners[first].before;
  if (corners[first].before == start) { /* all of them: only by rounding, as the site itself is not beyond */
    cell->any = ASC_NONE;
    return;
  }
  while (beyond(line, &corners[corners[last].next]) > 0.0) last = corners[last].next;
  const uint32_t kept_before = corners[first].before, kept_after = corners[last].next;
  const uint32_t begin = add_crossing(cell, line, kept_before, first);
  const uint32_t end = add_crossing(cell, line, kept_after, last);
  link(cell, kept_before, begin);
  link(cell, begin, end);
  link(cell, end, kept_after);
  cell->any = end;
}

void asc_cell_of(const asc_voronoi *diagram, uint32_t site, asc_cell *cell) {
  const asc_delaunay *mesh = &diagram->mesh;
  const asc_place own = diagram->places[site];
  const struct asc_rest rest = diagram->rests[site];
  const double left = (-diagram->width - (double)own.x) - rest.x, right = (diagram->width - (double)own.x) - rest.x;
  const double bottom = (-diagram->height - (double)own.y) - rest.y, top = (diagram->height - (double)own.y) - rest.y;
  cell->corners[0] = (asc_corner){left, bottom, 1, 3};
  cell->corners[1] = (asc_corner){right, bottom, 2, 0};
  cell->corners[2] = (asc_corner){right, top, 3, 1};
  cell->corners[3] = (asc_corner){left, top, 0, 2};
  cell->used = 4;
  cell->any = 0;
  const uint32_t first = mesh->first[site];
  for (uint32_t edge = first; edge != ASC_NONE && cell->any != ASC_NONE;) {
    const struct asc_rest way = asc_voronoi_way(diagram, site, asc_edge_end(mesh, edge));
    cut(cell, &(bisector){way.x, way.y, 0.5 * (way.x * way.x + way.y * way.y)});
    edge = mesh->next[edge] == first ? ASC_NONE : mesh->next[edge];
  }
}

double asc_cell_area(const asc_cell *cell) {
  if (cell->any == ASC_NONE) return 0.0;
  const asc_corner *corners = cell->corners;
  double twice = 0.0;
  uint32_t at = cell->any;
  do {
    const asc_corner *a = &corners[at], *b = &corners[a->next];
    twice += a->x * b->y - a->y * b->x;
    at = a->next;
  } while (at != cell->any);
  return fmax(0.5 * twice, 0.0);
}

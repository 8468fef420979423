/* Area weights: each sample stands for its Voronoi cell, and weighs the integral of the filter over it.
 *
 * Source: the lecture, "weight samples by area"; Voronoi 1908. The cell is clipped to the filter's support. The
 * integral of p(x) p(y) over it is by Green's theorem that of P(x) p(y) dy around it, P being the primitive of the
 * profile p. Each side is cut where p is not smooth, and each part integrated by the rule of Gauss and Legendre with 8
 * points: exact for profiles of polynomials, and within 1e-9 of the whole for all. Without a filter it is the cell's
 * area. */
#include <math.h>
#include <stdlib.h>

#include "primitive.h"
#include "voronoi.h"
#include "weighting.h"

#define POINTS 8
static const double rule[POINTS][2] = {
    {-0.960289856497536232, 0.101228536290376259}, {-0.796666477413626740, 0.222381034453374471},
    {-0.525532409916328986, 0.313706645877887287}, {-0.183434642495649805, 0.362683783378361983},
    {0.183434642495649805, 0.362683783378361983},  {0.525532409916328986, 0.313706645877887287},
    {0.796666477413626740, 0.222381034453374471},  {0.960289856497536232, 0.101228536290376259},
};

/* A place in pixels from the centre. */
typedef struct place {
  double x, y;
} place;

/* The terms of an integral of P(x) p(y) dy that are still to be added up: many at a time are quicker. */
#define TERMS 256
typedef struct terms {
  const asc_filter *filter;
  double x[TERMS], y[TERMS], factors[TERMS];
  size_t count;
  double sum;
} terms;

static void add_up(terms *of) {
  const asc_primitive_table *table = asc_filter_table(of->filter);
  double profile[TERMS];
  (void)asc_filter_evaluate(of->filter, of->y, of->count, profile); /* fails for no null pointer */
  for (size_t i = 0; i < of->count; i++) of->sum += of->factors[i] * profile[i] * asc_primitive_at(table, of->x[i]);
  of->count = 0;
}

/* Along a line on which both are smooth. */
static void add_part(terms *of, place a, place b) {
  if (of->count + POINTS > TERMS) add_up(of);
  for (int i = 0; i < POINTS; i++) {
    of->x[of->count] = 0.5 * (a.x + b.x) + 0.5 * (b.x - a.x) * rule[i][0];
    of->y[of->count] = 0.5 * (a.y + b.y) + 0.5 * (b.y - a.y) * rule[i][0];
    of->factors[of->count++] = 0.5 * (b.y - a.y) * rule[i][1];
  }
}

/* How far along from a to b, in (from, 1], the next multiple of `spacing` is met by a coordinate. */
static double next_knot(double a, double b, double spacing, double from) {
  const double way = b - a, at = a + from * way;
  if (way == 0.0) return 1.0;
  const double knot = way > 0.0 ? floor(at / spacing + 1.0) : ceil(at / spacing - 1.0);
  const double met = (knot * spacing - a) / way;
  /* Rounding may find the knot again that it stands on. */
  return met > from + 1e-12 ? fmin(met, 1.0) : fmin(((way > 0.0 ? knot + 1.0 : knot - 1.0) * spacing - a) / way, 1.0);
}

static void add_side(terms *of, place a, place b) {
  if (a.y == b.y) return;
  const double spacing = asc_filter_knot_spacing(of->filter);
  place begin = a;
  for (double from = 0.0; from < 1.0;) {
    const double to = fmin(next_knot(a.x, b.x, spacing, from), next_knot(a.y, b.y, spacing, from));
    const place end = to < 1.0 ? (place){a.x + to * (b.x - a.x), a.y + to * (b.y - a.y)} : b;
    add_part(of, begin, end);
    begin = end;
    from = to;
  }
}

/* A corner in pixels; rounding may have put it a little outside the support. */
static place place_of(const asc_voronoi *diagram, uint32_t site, const asc_corner *corner, double radius) {
  const double x = diagram->step * ((double)diagram->places[site].x + (diagram->rests[site].x + corner->x));
  const double y = diagram->step * ((double)diagram->places[site].y + (diagram->rests[site].y + corner->y));
  return (place){fmax(fmin(x, radius), -radius), fmax(fmin(y, radius), -radius)};
}

static double integral_over(const asc_filter *filter, const asc_voronoi *diagram, uint32_t site, const asc_cell *cell) {
  if (cell->any == ASC_NONE) return 0.0;
  terms of;
  of.filter = filter;
  of.count = 0;
  of.sum = 0.0;
  const double radius = asc_filter_radius(filter);
  uint32_t at = cell->any;
  place begin = place_of(diagram, site, &cell->corners[at], radius);
  do {
    at = cell->corners[at].next;
    const place end = place_of(diagram, site, &cell->corners[at], radius);
    add_side(&of, begin, end);
    begin = end;
  } while (at != cell->any);
  add_up(&of);
  return of.sum;
}

/* Writes each sample's share of its cell: by `filter`, or by area where it is NULL. */
static asc_status shares(const asc_filter *filter, const asc_voronoi *diagram, size_t count, double *weights) {
  asc_cell cell;
  double *of_site = malloc(diagram->count * sizeof *of_site);
  if (!of_site) return ASC_OUT_OF_MEMORY;
  asc_status status = asc_cell_create(diagram, &cell);
  const double whole = 4.0 * diagram->width * diagram->height; /* past which the largest double may be, too */
  if (status == ASC_OK) {
    for (uint32_t site = 0; site < diagram->count; site++) {
      asc_cell_of(diagram, site, &cell);
      of_site[site] = filter ? integral_over(filter, diagram, site, &cell)
                             : fmin(asc_cell_area(&cell), whole) * diagram->step * diagram->step;
    }
    for (size_t i = 0; i < count; i++) weights[i] = of_site[diagram->site[i]] / diagram->samples[diagram->site[i]];
    asc_cell_destroy(&cell);
  }
  free(of_site);
  return status;
}

static asc_status weigh_within(const asc_filter *filter, const double *points, size_t count,
                               const asc_rectangle *bounds, double *weights) {
  asc_voronoi diagram;
  asc_status status = asc_voronoi_create(points, count, bounds, &diagram);
  if (status) return status;
  status = shares(filter, &diagram, count, weights);
  asc_voronoi_destroy(&diagram);
  return status;
}

static asc_status area_weigh(const asc_samples *samples, const double *values, double *weights) {
  (void)values;
  const double radius = samples->radius;
  return weigh_within(samples->filter, samples->points, samples->count,
                      &(asc_rectangle){-radius, -radius, radius, radius}, weights);
}

asc_status asc_voronoi_areas(const double *points, size_t n, const double bounds[4], double *areas, asc_error *error) {
  if (!points || !bounds || !areas || n == 0 || n > ASC_UNEVEN_MOST)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "Voronoi areas are those of 1 to %d points", ASC_UNEVEN_MOST);
  const asc_rectangle within = {bounds[0], bounds[1], bounds[2], bounds[3]};
  const double width = within.right - within.left, height = within.top - within.bottom;
  if (!(width > 0.0 && width * height > 0.0 && isfinite(width * height)))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "bounds are left, bottom, right, top: [%g, %g] x [%g, %g] has no area",
                    within.left, within.right, within.bottom, within.top);
  for (size_t i = 0; i < n; i++) {
    const double x = points[2 * i], y = points[2 * i + 1];
    if (!(x >= within.left && x <= within.right && y >= within.bottom && y <= within.top))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "point %zu at (%g, %g) is not within the bounds", i, x, y);
  }
  asc_status status = weigh_within(NULL, points, n, &within, areas);
  return status ? asc_fail(error, status, "%s", asc_status_text(status)) : ASC_OK;
}

const asc_weighting_interface asc_weighting_area = {
    .name = "area",
    .title = "the filter's integral over the sample's Voronoi cell, clipped to the support",
    .source = "Voronoi 1908; Guibas and Stolfi 1985",
    .radius = 0.5,
    .weigh = area_weigh,
};

/* Inverse density: each sample weighs the filter's value over an estimate of how dense the samples are around it.
 *
 * Source: Loftsgaarden and Quesenberry 1965, "A nonparametric estimate of a multivariate density function": where the
 * k-th nearest of n others is at distance r, the density is about k / n over the area of the disc of radius r. Here
 * that of its part within the filter's support, else samples at the border would count double. Samples at the same
 * place are one among the others, and share its weight. The estimate's variance is 1 / k of its
 * square, and a step of density is smeared over the discs' width: k is a compromise, which weights by area do without.
 *
 * The next nearest is always a neighbour, in the Delaunay triangulation, of one that is nearer: so the search goes
 * along its edges. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "voronoi.h"
#include "weighting.h"

enum { NEIGHBOURS };

typedef struct candidate {
  double square; /* of the distance, in steps squared */
  uint32_t site;
} candidate;

/* Those seen and not yet taken; a site is seen where its mark is that of the search. */
typedef struct search {
  candidate *candidates;
  size_t count;
  uint32_t *marks;
} search;

static void see_neighbours(const asc_voronoi *diagram, uint32_t of, uint32_t centre, search *seen) {
  const asc_delaunay *mesh = &diagram->mesh;
  uint32_t edge = mesh->first[of];
  do {
    const uint32_t site = asc_edge_end(mesh, edge);
    if (seen->marks[site] != centre) {
      const struct asc_rest way = asc_voronoi_way(diagram, centre, site);
      seen->candidates[seen->count++] = (candidate){way.x * way.x + way.y * way.y, site};
      seen->marks[site] = centre;
    }
    edge = mesh->next[edge];
  } while (edge != mesh->first[of]);
}

/* In steps, of a diagram of more than `k` sites. */
static double nearest_distance(const asc_voronoi *diagram, uint32_t centre, size_t k, search *seen) {
  uint32_t from = centre;
  double square = 0.0;
  seen->count = 0;
  seen->marks[centre] = centre;
  for (size_t taken = 0; taken < k; taken++) {
    see_neighbours(diagram, from, centre, seen);
    size_t least = 0;
    for (size_t i = 1; i < seen->count; i++)
      if (seen->candidates[i].square < seen->candidates[least].square) least = i;
    square = seen->candidates[least].square;
    from = seen->candidates[least].site;
    seen->candidates[least] = seen->candidates[--seen->count];
  }
  return sqrt(square);
}

/* The area under the arc of radius r from 0 to x. */
static double under_arc(double r, double x) { return 0.5 * (x * sqrt(r * r - x * x) + r * r * asin(x / r)); }

/* The area of a quarter of a disc about the corner of a rectangle of sides a and b. */
static double quarter_within(double r, double a, double b) {
  if (a * a + b * b <= r * r) return a * b;
  const double width = fmin(a, r), height = fmin(b, r);
  const double flat = sqrt(r * r - height * height); /* so far the arc is above `height` */
  return height * flat + under_arc(r, width) - under_arc(r, flat);
}

static double disc_within(const asc_voronoi *diagram, uint32_t site, double r) {
  const double x = (double)diagram->places[site].x + diagram->rests[site].x;
  const double y = (double)diagram->places[site].y + diagram->rests[site].y;
  /* Rounding may lead half a step outside. */
  const double left = fmax(diagram->width + x, 0.0), right = fmax(diagram->width - x, 0.0);
  const double below = fmax(diagram->height + y, 0.0), above = fmax(diagram->height - y, 0.0);
  return quarter_within(r, left, below) + quarter_within(r, right, below) + quarter_within(r, right, above) +
         quarter_within(r, left, above);
}

static asc_status divide(const asc_voronoi *diagram, size_t count, size_t neighbours, double *weights) {
  const size_t others = diagram->count - 1, k = neighbours < others ? neighbours : others;
  double *areas = malloc(diagram->count * sizeof *areas);
  search seen = {calloc(diagram->count, sizeof *seen.candidates), 0, malloc(diagram->count * sizeof *seen.marks)};
  const int there = areas && seen.candidates && seen.marks;
  if (there) {
    memset(seen.marks, 0xff, diagram->count * sizeof *seen.marks); /* ASC_NONE */
    for (uint32_t site = 0; site < diagram->count; site++)
      areas[site] = k ? disc_within(diagram, site, nearest_distance(diagram, site, k, &seen)) : 1.0;
    for (size_t i = 0; i < count; i++) weights[i] *= areas[diagram->site[i]] / diagram->samples[diagram->site[i]];
  }
  free(areas);
  free(seen.candidates);
  free(seen.marks);
  return there ? ASC_OK : ASC_OUT_OF_MEMORY;
}

static asc_status inverse_density_weigh(const asc_samples *samples, const double *values, double *weights) {
  const double radius = samples->radius;
  asc_voronoi diagram;
  asc_status status = asc_filter_at_samples(samples, weights);
  if (status) return status;
  status =
      asc_voronoi_create(samples->points, samples->count, &(asc_rectangle){-radius, -radius, radius, radius}, &diagram);
  if (status) return status;
  status = divide(&diagram, samples->count, (size_t)values[NEIGHBOURS], weights);
  asc_voronoi_destroy(&diagram);
  return status;
}

static const asc_parameter inverse_density_parameters[] = {
    [NEIGHBOURS] = {"neighbours", ASC_INTEGER, NULL, 1, 32, 3, "k: the density is that within the k-th nearest sample"},
};

const asc_weighting_interface asc_weighting_inverse_density = {
    .name = "inverse-density",
    .title = "the filter's value over the density of samples, estimated by the distance of the k-th nearest",
    .source = "Loftsgaarden and Quesenberry 1965",
    .parameters = inverse_density_parameters,
    .parameter_count = 1,
    .radius = 0.5,
    .weigh = inverse_density_weigh,
};

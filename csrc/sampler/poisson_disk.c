/* Random points no two of which are closer than a radius: dart throwing.
 *
 * Source: Dippe and Wold 1985, "Antialiasing through stochastic sampling"; Cook 1986, "Stochastic sampling in computer
 * graphics". A dart is uniform; it stays if it lies at least a radius r away from all before it. Points are in the
 * order of their placement.
 *
 * `radius` is r as a share of r_max = sqrt(2 / (sqrt(3) N)), the largest distance that N points of the torus can keep,
 * in the hexagonal lattice (Lagae and Dutre 2008, "A comparison of methods for generating Poisson disk distributions").
 * Darts run out near 0.777 r_max: discs thrown at random come to rest at a density of 0.547 (Feder 1980, "Random
 * sequential adsorption"). Hence the default of 0.75; and there are exactly N points by a relaxation: where no free
 * area is left, r is multiplied by 0.95 and the throwing goes on (after McCool and Fiume 1992, "Hierarchical Poisson
 * disk sampling distributions"). The least radius is 0.25, where a point has 28 cells of the grid: points that keep
 * less are all but random.
 *
 * With `toroidal` 1 distances go around the edges of the square; with 0 they do not, and points are denser along its
 * edges, where they have fewer neighbours.
 *
 * What is guaranteed: every two points keep the last r, which is radius r_max where nothing was relaxed. n discs of
 * radius r leave area free as long as n pi r^2 < 1, so nothing is relaxed below sqrt(sqrt(3) / (2 pi)) = 0.525 r_max,
 * and all points keep min(radius, 0.95 * 0.525) r_max.
 *
 * Darts would mostly miss where little area is left free. They are therefore thrown into a list of squares that hold
 * all that is free (gaps.h), which leaves the distribution of those that stay as it is. */
#include <math.h>
#include <stdlib.h>

#include "gaps.h"
#include "pattern.h"
#include "planar.h"
#include "stream.h"

#define RELAXATION 0.95
#define MOST_POINTS ((uint64_t)1 << 24) /* made whole in memory, at 300 bytes a point */

typedef struct poisson_disk_state {
  uint64_t samples, seed;
  double radius; /* distance */
  int toroidal;
} poisson_disk_state;

/* The points placed so far. */
typedef struct darts {
  asc_stream stream;
  uint32_t placed, samples;
  double (*points)[2];
} darts;

static asc_status poisson_disk_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->samples > MOST_POINTS)
    return asc_fail(error, ASC_UNSUPPORTED, "poisson-disk has at most 2^24 points: a pattern is made whole in memory");
  poisson_disk_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "poisson-disk: out of memory");
  const double densest = sqrt(2.0 / (sqrt(3.0) * (double)config->samples));
  *state = (poisson_disk_state){config->samples, config->seed, config->values[0] * densest, (int)config->values[1]};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* One round of darts, as many as there are squares; how many stayed. A square with a point is inside its disc. */
static uint32_t throw_round(darts *thrown, asc_gaps *gaps) {
  const uint32_t before = thrown->placed;
  for (size_t left = gaps->count; left > 0 && gaps->count > 0 && thrown->placed < thrown->samples; left--) {
    double *point = thrown->points[thrown->placed];
    const size_t k = asc_gaps_draw(gaps, &thrown->stream, point);
    if (asc_gaps_nearest(gaps, k, point, gaps->squared_radius) <= gaps->squared_radius) continue;
    thrown->placed++;
    asc_gaps_add(gaps, point);
    asc_gaps_drop(gaps, k);
  }
  return thrown->placed - before;
}

static asc_status poisson_disk_plane(const void *opaque, asc_key key, uint32_t pair, double (*points)[2]) {
  const poisson_disk_state *state = opaque;
  darts thrown = {.samples = (uint32_t)state->samples, .points = points};
  asc_stream_begin(&thrown.stream, key, pair);
  double radius = state->radius;
  while (thrown.placed < thrown.samples) {
    asc_gaps gaps;
    const asc_status status = asc_gaps_begin(&gaps, radius, state->toroidal, (const double(*)[2])points, thrown.placed);
    if (status) return status;
    for (int going = 1; going && thrown.placed < thrown.samples && gaps.count > 0;) {
      const uint32_t stayed = throw_round(&thrown, &gaps);
      going = asc_gaps_quarter(&gaps) || stayed > 0;
    }
    asc_gaps_end(&gaps);
    radius *= RELAXATION;
  }
  return ASC_OK;
}

static asc_status poisson_disk_fill(const void *opaque, const asc_range *range, double *points) {
  const poisson_disk_state *state = opaque;
  return asc_planar_fill(state, state->samples, state->seed, poisson_disk_plane, range, points);
}

static const asc_parameter poisson_disk_parameters[] = {
    {"radius", ASC_REAL, NULL, 0.25, 1.0, 0.75, "least distance, as a share of the densest packing's"},
    {"toroidal", ASC_INTEGER, NULL, 0.0, 1.0, 1.0, "1: distances go around the edges"},
};

const asc_sampler_interface asc_sampler_poisson_disk = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "poisson-disk",
    .title = "random points that keep their distance",
    .source = "Dippe and Wold 1985; Cook 1986",
    .parameters = poisson_disk_parameters,
    .parameter_count = 2,
    .create = poisson_disk_create,
    .destroy = free,
    .fill = poisson_disk_fill,
};

/* Random edges a x + b y + c = 0 by Monte Carlo, and the two measures that are means and maxima over them.
 *
 * Mitchell 1992, "Ray tracing and irregularities of distribution", measures by random edges without saying how they are
 * drawn; Kendall and Moran 1963, "Geometrical probability", chapter 3, have the four ways that are meant by it. Edge i
 * of a seed is a hash of (seed, i), so it does not depend on how many are drawn. */
#include "edges.h"

#include <math.h>
#include <stdlib.h>

#include "halfplane_area.h"
#include "hash.h"
#include "vectorise.h"

#define RUN 1024 /* points that stay in the cache while the edges of a block are counted */

/* The edge u = slope * v + offset, |slope| <= 1: u is x and v is y, or the other way round where it is flat. */
typedef struct edge {
  double slope, offset;
  int flat;
} edge;

static edge edge_of(double a, double b, double c) {
  const int flat = fabs(a) < fabs(b);
  const double larger = flat ? b : a, smaller = flat ? a : b;
  if (larger == 0.0) return (edge){0.0, 0.0, 0}; /* through two equal points: cuts nothing */
  return (edge){-smaller / larger, -c / larger, flat};
}

static edge through(const double p[2], const double q[2]) {
  const double a = q[1] - p[1], b = p[0] - q[0];
  return edge_of(a, b, -(a * p[0] + b * p[1]));
}

/* The edge with the normal (a, b), `share` of the way through the square's width in that direction. */
static edge across(double a, double b, double share) {
  const double width = fabs(a) + fabs(b);
  return edge_of(a, b, -(a + b) / 2.0 - (share - 0.5) * width);
}

/* The angle from the x axis, in [0, pi/2), has the density (cos + sin) / 2, so sin(angle - pi/4) sqrt 2 is uniform in
 * [-1, 1). The other half of all directions is its mirror image. */
static edge isotropic(double share_of_angle, double share_of_width, uint32_t mirrored) {
  const double sine = (2.0 * share_of_angle - 1.0) * sqrt(0.5), cosine = sqrt(1.0 - sine * sine);
  const double a = (cosine - sine) * sqrt(0.5), b = (cosine + sine) * sqrt(0.5);
  return across(a, mirrored ? -b : b, share_of_width);
}

/* The border's point at `along` of its length 4, from the origin by (1, 0). */
static void border_point(double along, double point[2]) {
  const double side = floor(along), rest = along - side;
  const double of_side[4][2] = {{rest, 0.0}, {1.0, rest}, {1.0 - rest, 1.0}, {0.0, 1.0 - rest}};
  const int index = (int)side % 4;
  point[0] = of_side[index][0];
  point[1] = of_side[index][1];
}

static edge chord(double from, double to) {
  double p[2], q[2];
  border_point(from, p);
  border_point(to, q);
  return through(p, q);
}

/* The edges first, first + 1, ... of a seed. */
static void draw(asc_edges edges, asc_key key, uint64_t first, edge drawn[ASC_LANES]) {
  asc_lanes bits, more = {{{0}}};
  asc_hash_lanes(key, first, 0, ASC_PURPOSE_EDGE, &bits);
  if (edges == ASC_EDGES_TWO_POINTS) asc_hash_lanes(key, first, 1, ASC_PURPOSE_EDGE, &more);
  for (size_t i = 0; i < ASC_LANES; i++) {
    const double p[2] = {asc_unit53(bits.word[0][i], bits.word[1][i]), asc_unit53(bits.word[2][i], bits.word[3][i])};
    const double q[2] = {asc_unit53(more.word[0][i], more.word[1][i]), asc_unit53(more.word[2][i], more.word[3][i])};
    switch (edges) {
    case ASC_EDGES_ISOTROPIC: /* the last bit of word 1 is not in p */
      drawn[i] = isotropic(p[0], p[1], bits.word[1][i] & 1u);
      break;
    case ASC_EDGES_ANGLE_OFFSET: drawn[i] = across(cos(p[0] * acos(-1.0)), sin(p[0] * acos(-1.0)), p[1]); break;
    case ASC_EDGES_CHORD: /* its end is uniform on the other three sides */
      drawn[i] = chord(4.0 * p[0], floor(4.0 * p[0]) + 1.0 + 3.0 * p[1]);
      break;
    case ASC_EDGES_TWO_POINTS: drawn[i] = through(p, q); break;
    }
  }
}

/* How many points have u >= slope * v + offset. */
ASC_VECTORISE
static uint64_t count_beyond(const double *u, const double *v, size_t count, double slope, double offset) {
  uint64_t beyond = 0;
  for (size_t j = 0; j < count; j++) beyond += u[j] >= slope * v[j] + offset;
  return beyond;
}

/* Mean and sum of squared differences from it, value by value (Welford 1962). */
typedef struct moments {
  double mean, spread;
} moments;

static void add_value(moments *so_far, double value, double count) {
  const double difference = value - so_far->mean;
  so_far->mean += difference / count;
  so_far->spread += difference * (value - so_far->mean);
}

static double standard_error(const moments *all, double count) {
  return count < 2.0 ? INFINITY : sqrt(all->spread / (count - 1.0) / count);
}

asc_status asc_edges_measure(const asc_point_set *set, asc_edges edges, uint64_t draws, asc_edge_statistics *made,
                             asc_error *error) {
  const size_t n = set->count;
  if (n > SIZE_MAX / 2 / sizeof(double)) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double *xs = malloc(2 * n * sizeof *xs);
  if (!xs) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double *ys = xs + n;
  for (size_t i = 0; i < n; i++) {
    xs[i] = set->points[2 * i];
    ys[i] = set->points[2 * i + 1];
  }
  const asc_key key = asc_stream_key(set->seed, 0, 0);
  moments values = {0}, squares = {0};
  *made = (asc_edge_statistics){.most = -1.0};
  for (uint64_t first = 0; first < draws; first += ASC_LANES) {
    edge drawn[ASC_LANES];
    uint64_t counts[ASC_LANES] = {0};
    draw(edges, key, first, drawn);
    const size_t drawn_count = draws - first < ASC_LANES ? (size_t)(draws - first) : ASC_LANES;
    for (size_t j = 0; j < n; j += RUN)
      for (size_t i = 0; i < drawn_count; i++)
        counts[i] += count_beyond((drawn[i].flat ? ys : xs) + j, (drawn[i].flat ? xs : ys) + j,
                                  n - j < RUN ? n - j : RUN, drawn[i].slope, drawn[i].offset);
    for (size_t i = 0; i < drawn_count; i++) {
      const double a = drawn[i].flat ? -drawn[i].slope : 1.0, b = drawn[i].flat ? 1.0 : -drawn[i].slope;
      const double c = -drawn[i].offset, number = (double)(first + i + 1);
      const double value = fabs((double)counts[i] / (double)n - asc_halfplane_area(a, b, c));
      add_value(&values, value, number);
      add_value(&squares, value * value, number);
      if (!(value > made->most)) continue;
      made->most = value;
      made->most_at[0] = a, made->most_at[1] = b, made->most_at[2] = c;
    }
  }
  free(xs);
  made->mean = values.mean;
  made->mean_error = standard_error(&values, (double)draws);
  made->square = squares.mean;
  made->square_error = standard_error(&squares, (double)draws);
  return ASC_OK;
}

static asc_status edge_mean_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                     asc_error *error) {
  asc_edge_statistics statistics = {0};
  const asc_status status = asc_edges_measure(set, (asc_edges)values[0], (uint64_t)values[1], &statistics, error);
  if (status) return status;
  asc_measured(made, statistics.mean);
  made->standard_error = statistics.mean_error;
  made->certainty = ASC_ESTIMATED;
  return ASC_OK;
}

/* A maximum over some edges says of all of them that it is no less. */
static asc_status edge_max_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,
                                    asc_error *error) {
  asc_edge_statistics statistics = {0};
  const asc_status status = asc_edges_measure(set, (asc_edges)values[0], (uint64_t)values[1], &statistics, error);
  if (status) return status;
  made->value = made->lower = statistics.most;
  made->upper = 1.0;
  made->certainty = ASC_BOUNDS;
  made->closed = 1;
  made->witness_count = 3;
  for (size_t i = 0; i < 3; i++) made->witness[i] = statistics.most_at[i];
  return ASC_OK;
}

static const asc_parameter mean_parameters[] = {
    ASC_EDGES_PARAMETER,
    {"draws", ASC_INTEGER, NULL, 2, ASC_MOST_DRAWS, ASC_USUAL_DRAWS, "how many edges are drawn"},
};

static const asc_parameter max_parameters[] = {
    ASC_EDGES_PARAMETER,
    {"draws", ASC_INTEGER, NULL, 1, ASC_MOST_DRAWS, ASC_USUAL_DRAWS, "how many edges are drawn"},
};

const asc_measure_interface asc_measure_edge_mean = {
    .name = "edge-mean",
    .title = "mean |n/N - area| over random edges that are drawn",
    .source = "Mitchell 1992; Kendall and Moran 1963",
    .parameters = mean_parameters,
    .parameter_count = sizeof mean_parameters / sizeof *mean_parameters,
    .least_dimensions = 2,
    .most_dimensions = 2,
    .quick_points = 8000,
    .evaluate = edge_mean_evaluate,
};

const asc_measure_interface asc_measure_edge_max = {
    .name = "edge-max",
    .title = "largest |n/N - area| over random edges that are drawn, below half-plane's; met at the edge a, b, c",
    .source = "Mitchell 1992; Kendall and Moran 1963",
    .parameters = max_parameters,
    .parameter_count = sizeof max_parameters / sizeof *max_parameters,
    .least_dimensions = 2,
    .most_dimensions = 2,
    .quick_points = 8000,
    .evaluate = edge_max_evaluate,
};

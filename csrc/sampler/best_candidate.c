/* Each point the best of many candidates: the one farthest from all points before it, on the torus.
 *
 * Source: Mitchell 1991, "Spectrally optimal sampling for distribution ray tracing". With i points there, m i
 * candidates are thrown, so that points keep apart equally well at every density. m is the parameter `candidates`; its
 * default of 10 is ours.
 *
 * The pattern is a sequence: point i depends on those before it alone, and every first n points are well spread. In
 * more than two dimensions each pair (0,1), (2,3), ... has a sequence of its own, independent of the others; they are
 * not shuffled against each other, so that all dimensions together stay a sequence.
 *
 * All m i candidates are looked at for the first points only. Later the winner is farther from all points than some
 * distance t, and a list of squares (gaps.h) holds every place that is. How many of the candidates fall into them is
 * binomial; just these are drawn, and where one is farther than t the others cannot matter. Where none is, all
 * candidates are within t of a point, each uniform there, and t is lowered: they are drawn again into the squares of
 * the lower t, each that is farther than the old one once more. The points have the distribution of the definition. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "gaps.h"
#include "pattern.h"

#define END ((uint64_t)1 << 17) /* of the indices: the last needs all points before it, 10 s in all */
#define ALL_CANDIDATES 20000    /* most distances by which one point is found the plain way */
#define LOWER 0.96              /* t, each time */
#define FEW_CANDIDATES 8.0      /* expected in the squares: few enough to stop quartering them */
#define MOST_EXPECTED 64.0      /* of one binomial draw, so that the probability of none is no underflow */

typedef struct best_candidate_state {
  uint64_t seed;
  uint32_t candidates;
} best_candidate_state;

/* The points so far. With `listed`, `gaps` has what is farther than its radius t from all of them. */
typedef struct field {
  asc_stream stream;
  double (*points)[2];
  uint32_t count, candidates;
  double closest; /* of all winners, their squared distance when they won */
  int listed;
  asc_gaps gaps;
} field;

static asc_status best_candidate_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->samples > END)
    return asc_fail(error, ASC_UNSUPPORTED, "best-candidate ends at 2^17 points: each needs all before it");
  best_candidate_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "best-candidate: out of memory");
  *state = (best_candidate_state){config->seed, (uint32_t)config->values[0]};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED | ASC_TRAIT_SEQUENCE, END};
  return ASC_OK;
}

/* Distance on the circle of circumference 1. */
static double around(double a, double b) {
  const double distance = fabs(a - b);
  return distance < 0.5 ? distance : 1.0 - distance;
}

/* The squared distance to the nearest of all points; any that is not above `enough` where there is one. */
static double nearest_of_all(const field *made, const double place[2], double enough) {
  double least = 1.0;
  for (uint32_t i = 0; i < made->count && least > enough; i++) {
    const double dx = around(made->points[i][0], place[0]), dy = around(made->points[i][1], place[1]);
    const double squared = dx * dx + dy * dy;
    least = squared < least ? squared : least;
  }
  return least;
}

static uint64_t candidates_of(const field *made) { return (uint64_t)made->candidates * made->count; }

/* How many of n fall where each does with probability p, n p small: by inversion, with additions, multiplications and
 * divisions alone, whose bits are the same everywhere. */
static uint64_t draw_few(asc_stream *stream, uint64_t n, double p) {
  double probability = 1.0, power = 1.0 - p;
  for (uint64_t rest = n; rest; rest >>= 1) {
    if (rest & 1u) probability *= power;
    power *= power;
  }
  const uint32_t high = asc_stream_bits(stream), low = asc_stream_bits(stream);
  double above = asc_unit53(high, low) - probability;
  uint64_t k = 0;
  for (; above >= 0.0 && k < n; k++) {
    probability *= (double)(n - k) / (double)(k + 1) * (p / (1.0 - p));
    above -= probability;
  }
  return k;
}

/* The same for any n p: a sum of draws of which each expects few. */
static uint64_t draw_binomial(asc_stream *stream, uint64_t n, double p) {
  if (p >= 1.0) return n;
  const double most = MOST_EXPECTED / p;
  const uint64_t part = most < (double)n ? (uint64_t)most + 1 : n;
  uint64_t drawn = 0;
  for (; n > part; n -= part) drawn += draw_few(stream, part, p);
  return drawn + draw_few(stream, n, p);
}

/* The share of the torus that the squares of the list have. */
static double share(const asc_gaps *gaps) {
  const double along = (double)((uint64_t)gaps->side << gaps->level);
  return (double)gaps->count / (along * along);
}

/* The list for a distance t; squares are quartered until few candidates miss, or quartering no longer helps. */
static asc_status list_gaps(field *made, double distance) {
  if (made->listed) asc_gaps_end(&made->gaps);
  made->listed = 0;
  const asc_status status = asc_gaps_begin(&made->gaps, distance, 1, (const double(*)[2])made->points, made->count);
  if (status) return status;
  made->listed = 1;
  for (double before = 4.0; share(&made->gaps) < 0.75 * before;) {
    before = share(&made->gaps);
    if (before * (double)candidates_of(made) < FEW_CANDIDATES || !asc_gaps_quarter(&made->gaps)) break;
  }
  return ASC_OK;
}

/* The squared distance of a place in square k from the nearest point: exact where it is above `enough`. */
static double nearest(const field *made, size_t k, const double place[2], double enough) {
  const asc_gaps *gaps = &made->gaps;
  const double found = asc_gaps_nearest(gaps, k, place, enough), seen = (double)gaps->reach / gaps->side;
  return found <= seen * seen ? found : nearest_of_all(made, place, enough);
}

/* Draws the candidates that fall into the list, of `left`; those farther than `excluded` (squared) once more. The best
 * goes to `place` if it is farther than t; 0 if there is none. */
static int draw_candidates(field *made, uint64_t left, double excluded, double place[2]) {
  asc_gaps *gaps = &made->gaps;
  double best = gaps->squared_radius;
  while (left > 0 && gaps->count > 0) {
    uint64_t here = draw_binomial(&made->stream, left, share(gaps));
    left = 0;
    for (; here > 0 && gaps->count > 0; here--) {
      double candidate[2];
      const size_t k = asc_gaps_draw(gaps, &made->stream, candidate);
      const double squared = nearest(made, k, candidate, best);
      if (squared > excluded) {
        left++;
      } else if (squared > best) {
        best = squared;
        memcpy(place, candidate, sizeof candidate);
      }
    }
  }
  return best > gaps->squared_radius;
}

/* All candidates, one by one. */
static void draw_all(field *made, double place[2]) {
  double best = -1.0;
  for (uint64_t left = candidates_of(made); left > 0; left--) {
    const double candidate[2] = {asc_stream_unit(&made->stream), asc_stream_unit(&made->stream)};
    const double squared = nearest_of_all(made, candidate, best);
    if (squared <= best) continue;
    best = squared;
    memcpy(place, candidate, sizeof candidate);
  }
  made->closest = best < made->closest ? best : made->closest;
}

/* Candidates among the gaps. Every winner is farther than t from the points before it, and t only gets lower, so no two
 * points are closer than t, as gaps.h asks. */
static asc_status draw_in_gaps(field *made, double place[2]) {
  double excluded = 1.0;
  if (!made->listed) {
    const asc_status status = list_gaps(made, LOWER * sqrt(made->closest));
    if (status) return status;
  }
  while (!draw_candidates(made, candidates_of(made), excluded, place)) {
    excluded = made->gaps.squared_radius;
    const asc_status status = list_gaps(made, LOWER * made->gaps.radius);
    if (status) return status;
  }
  asc_gaps_add(&made->gaps, place);
  return ASC_OK;
}

/* The first `samples` points of one pair of dimensions. */
static asc_status make_sequence(const best_candidate_state *state, asc_key key, uint32_t pair, uint32_t samples,
                                double (*points)[2]) {
  field made = {.points = points, .candidates = state->candidates, .closest = 1.0};
  asc_stream_begin(&made.stream, key, pair);
  points[0][0] = asc_stream_unit(&made.stream);
  points[0][1] = asc_stream_unit(&made.stream);
  asc_status status = ASC_OK;
  for (made.count = 1; status == ASC_OK && made.count < samples; made.count++) {
    if (candidates_of(&made) * made.count <= ALL_CANDIDATES)
      draw_all(&made, points[made.count]);
    else
      status = draw_in_gaps(&made, points[made.count]);
  }
  if (made.listed) asc_gaps_end(&made.gaps);
  return status;
}

static asc_status best_candidate_fill(const void *opaque, const asc_range *range, double *points) {
  const best_candidate_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  const uint32_t samples = (uint32_t)(range->first_sample + range->sample_count);
  double(*whole)[2] = malloc(samples * sizeof *whole);
  if (!whole) return ASC_OUT_OF_MEMORY;
  asc_status status = ASC_OK;
  for (uint32_t pair = begin / 2; pair <= (end - 1) / 2 && status == ASC_OK; pair++) {
    status = make_sequence(state, key, pair, samples, whole);
    if (status) break;
    for (uint32_t d = pair * 2 < begin ? begin : pair * 2; d < end && d / 2 == pair; d++)
      for (size_t i = 0; i < range->sample_count; i++)
        points[i * range->dimension_count + (d - begin)] = whole[range->first_sample + i][d % 2];
  }
  free(whole);
  return status;
}

static const asc_parameter best_candidate_parameters[] = {
    {"candidates", ASC_INTEGER, NULL, 1.0, 1000.0, 10.0, "candidates for a point, as a multiple of the points there"},
};

const asc_sampler_interface asc_sampler_best_candidate = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "best-candidate",
    .title = "each point the farthest of many from those before it",
    .source = "Mitchell 1991",
    .parameters = best_candidate_parameters,
    .parameter_count = 1,
    .create = best_candidate_create,
    .destroy = free,
    .fill = best_candidate_fill,
};

/* A set of points optimised to have little power at low frequencies: blue noise.
 *
 * Source: Ahmed, Ren, Wonka 2022, "Gaussian blue noise": points that repel each other by a Gaussian kernel of a width
 * in proportion to their spacing, sum over all pairs of exp(-d^2 / (2 s^2)) on the torus, descend its gradient. The
 * transform of a Gaussian is one: the sum weighs the power at frequency f with exp(-2 pi^2 s^2 f^2), so descent empties
 * the low frequencies first and leaves the high ones in disorder. Here s is 0.7 / sqrt(N), 100 steps with momentum
 * (Polyak 1964) lead down from a Poisson disk pattern.
 *
 * One set is made for (N, seed), at creation. Each pair of dimensions (0,1), (2,3), ... of each pixel has it in one of
 * the eight symmetries of the square and moved by a random vector, modulo 1; beyond the first pair, in a random order
 * of its own. Any point of any pixel is then had without the others. No libm function that rounds differently from
 * machine to machine is used: sums are taken in a fixed order, and the exponential is a polynomial. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "pattern.h"
#include "permutation.h"
#include "vectorise.h"

#define MOST_POINTS 16384 /* creation takes about 30 microseconds a point */
#define WIDTH 0.7         /* s, in units of 1 / sqrt(N), as all lengths here */
#define REACH 4.0         /* of the kernel: 8e-8 of its height */
#define STEPS 100
#define STEPS_A_LIST 25 /* neighbours are found again after so many */
#define RATE 0.05
#define MOMENTUM 0.9
#define LANES 8 /* sums in a fixed order that the compiler can vectorise */

extern const asc_sampler_interface asc_sampler_poisson_disk;

typedef struct blue_noise_state {
  uint64_t samples, seed;
  double points[][2];
} blue_noise_state;

/* A neighbour: another point, seen in a period of the torus. */
typedef struct neighbours {
  uint32_t *point;
  float *period[2];
  size_t count, capacity;
} neighbours;

/* The descent. Lengths are in units of 1 / sqrt(N), so the torus has a period of sqrt(N). */
typedef struct descent {
  uint32_t count;
  double period, *place[2], *velocity[2];
  uint32_t side, *first, *next; /* a grid of lists: indices plus one, 0 the end */
  size_t *begin;                /* of each point's neighbours */
  neighbours near;
} descent;

/* exp(-s) within 1e-9 for s up to 20, by multiplications: a polynomial of s / 32, squared five times. */
static inline double decay(double s) {
  const double t = s * (1.0 / 32.0);
  double p = 1.0 - t * (1.0 / 8.0);
  p = 1.0 - t * (1.0 / 7.0) * p;
  p = 1.0 - t * (1.0 / 6.0) * p;
  p = 1.0 - t * (1.0 / 5.0) * p;
  p = 1.0 - t * (1.0 / 4.0) * p;
  p = 1.0 - t * (1.0 / 3.0) * p;
  p = 1.0 - t * (1.0 / 2.0) * p;
  p = 1.0 - t * p;
  p *= p;
  p *= p;
  p *= p;
  p *= p;
  return p * p;
}

/* The push of its neighbours on each point, on top of its velocity. */
ASC_VECTORISE
static void accelerate(descent *made) {
  const double *x = made->place[0], *y = made->place[1];
  const uint32_t *point = made->near.point;
  const float *period_x = made->near.period[0], *period_y = made->near.period[1];
  for (uint32_t a = 0; a < made->count; a++) {
    double push_x[LANES] = {0.0}, push_y[LANES] = {0.0};
    for (size_t k = made->begin[a]; k < made->begin[a + 1]; k += LANES)
      for (size_t lane = 0; lane < LANES; lane++) {
        const uint32_t b = point[k + lane];
        const double dx = x[a] - x[b] - (double)period_x[k + lane], dy = y[a] - y[b] - (double)period_y[k + lane];
        const double weight = decay((dx * dx + dy * dy) * (0.5 / (WIDTH * WIDTH)));
        push_x[lane] += weight * dx;
        push_y[lane] += weight * dy;
      }
    for (size_t lane = 1; lane < LANES; lane++) {
      push_x[0] += push_x[lane];
      push_y[0] += push_y[lane];
    }
    made->velocity[0][a] = MOMENTUM * made->velocity[0][a] + RATE / (WIDTH * WIDTH) * push_x[0];
    made->velocity[1][a] = MOMENTUM * made->velocity[1][a] + RATE / (WIDTH * WIDTH) * push_y[0];
  }
}

static int grow(neighbours *near) {
  const size_t capacity = 2 * near->capacity;
  uint32_t *point = realloc(near->point, capacity * sizeof *point);
  if (point) near->point = point;
  int grown = point != NULL;
  for (int axis = 0; axis < 2; axis++) {
    float *period = realloc(near->period[axis], capacity * sizeof *period);
    if (period) near->period[axis] = period;
    grown &= period != NULL;
  }
  if (grown) near->capacity = capacity;
  return grown;
}

static void append(neighbours *near, uint32_t point, double period_x, double period_y) {
  near->point[near->count] = point;
  near->period[0][near->count] = (float)period_x;
  near->period[1][near->count] = (float)period_y;
  near->count++;
}

static uint32_t cell_of(const descent *made, double x) {
  const uint32_t cell = (uint32_t)(x / made->period * made->side);
  return cell < made->side ? cell : made->side - 1;
}

/* Brings all points back into the period, and lists them in their cells. */
static void list_places(descent *made) {
  memset(made->first, 0, (size_t)made->side * made->side * sizeof *made->first);
  for (uint32_t a = 0; a < made->count; a++) {
    for (int axis = 0; axis < 2; axis++) {
      double *x = &made->place[axis][a];
      *x -= made->period * floor(*x / made->period);
    }
    uint32_t *first =
        &made->first[(size_t)cell_of(made, made->place[1][a]) * made->side + cell_of(made, made->place[0][a])];
    made->next[a] = *first;
    *first = a + 1;
  }
}

/* Appends the neighbours of point a in one cell, seen in the period (u, v). 0 where memory ran out. */
static int find_in_cell(descent *made, uint32_t a, uint32_t cell, double u, double v) {
  for (uint32_t b = made->first[cell]; b; b = made->next[b - 1]) {
    const double dx = made->place[0][b - 1] + u - made->place[0][a], dy = made->place[1][b - 1] + v - made->place[1][a];
    if (b - 1 == a || dx * dx + dy * dy >= REACH * REACH) continue; /* its own images push a point from all sides */
    if (made->near.count + LANES > made->near.capacity && !grow(&made->near)) return 0;
    append(&made->near, b - 1, u, v);
  }
  return 1;
}

static asc_status find_neighbours(descent *made) {
  const int64_t side = made->side, reach = (int64_t)ceil(REACH * (double)side / made->period);
  list_places(made);
  made->near.count = 0;
  for (uint32_t a = 0; a < made->count; a++) {
    const int64_t column = cell_of(made, made->place[0][a]), row = cell_of(made, made->place[1][a]);
    made->begin[a] = made->near.count;
    for (int64_t y = row - reach; y <= row + reach; y++)
      for (int64_t x = column - reach; x <= column + reach; x++) {
        const double u = floor((double)x / (double)side), v = floor((double)y / (double)side);
        const int64_t in_x = x - side * (int64_t)u, in_y = y - side * (int64_t)v;
        if (!find_in_cell(made, a, (uint32_t)(in_y * side + in_x), u * made->period, v * made->period))
          return ASC_OUT_OF_MEMORY;
      }
    /* Up to a full run of lanes with the point itself, which does not push. */
    while ((made->near.count - made->begin[a]) % LANES) append(&made->near, a, 0.0, 0.0);
  }
  made->begin[made->count] = made->near.count;
  return ASC_OK;
}

static asc_status descend(descent *made) {
  for (int step = 0; step < STEPS; step++) {
    const asc_status status = step % STEPS_A_LIST == 0 ? find_neighbours(made) : ASC_OK;
    if (status) return status;
    accelerate(made);
    for (int axis = 0; axis < 2; axis++)
      for (uint32_t a = 0; a < made->count; a++) made->place[axis][a] += made->velocity[axis][a];
  }
  return ASC_OK;
}

static void end_descent(descent *made) {
  for (int axis = 0; axis < 2; axis++) {
    free(made->place[axis]);
    free(made->velocity[axis]);
    free(made->near.period[axis]);
  }
  free(made->first);
  free(made->next);
  free(made->begin);
  free(made->near.point);
}

static asc_status begin_descent(descent *made, uint32_t count) {
  const uint32_t side = (uint32_t)sqrt((double)count);
  *made = (descent){.count = count, .period = sqrt((double)count), .side = side};
  made->near.capacity = (size_t)64 * count + LANES;
  int found = 1;
  for (int axis = 0; axis < 2; axis++) {
    made->place[axis] = malloc(count * sizeof(double));
    made->velocity[axis] = calloc(count, sizeof(double));
    made->near.period[axis] = malloc(made->near.capacity * sizeof(float));
    found &= made->place[axis] && made->velocity[axis] && made->near.period[axis];
  }
  made->first = malloc((size_t)side * side * sizeof *made->first);
  made->next = malloc(count * sizeof *made->next);
  made->begin = malloc((count + 1) * sizeof *made->begin);
  made->near.point = malloc(made->near.capacity * sizeof *made->near.point);
  return found && made->first && made->next && made->begin && made->near.point ? ASC_OK : ASC_OUT_OF_MEMORY;
}

/* The pattern that the descent starts from. */
static asc_status start(uint32_t count, uint64_t seed, double (*points)[2]) {
  const double radius_and_toroidal[] = {0.75, 1.0};
  const asc_sampler_config config = {sizeof config, count, 2, seed, radius_and_toroidal};
  const asc_range range = {0, 0, 0, count, 0, 2};
  asc_sampler_state made;
  asc_status status = asc_sampler_poisson_disk.create(&config, &made, NULL);
  if (status) return status;
  status = asc_sampler_poisson_disk.fill(made.state, &range, &points[0][0]);
  asc_sampler_poisson_disk.destroy(made.state);
  return status;
}

static asc_status optimise(uint32_t count, uint64_t seed, double (*points)[2]) {
  asc_status status = start(count, seed, points);
  if (status) return status;
  descent made;
  status = begin_descent(&made, count);
  for (uint32_t a = 0; a < count && status == ASC_OK; a++)
    for (int axis = 0; axis < 2; axis++) made.place[axis][a] = points[a][axis] * made.period;
  if (status == ASC_OK) status = descend(&made);
  for (uint32_t a = 0; a < count && status == ASC_OK; a++)
    for (int axis = 0; axis < 2; axis++) {
      const double x = made.place[axis][a] / made.period;
      points[a][axis] = x - floor(x);
    }
  end_descent(&made);
  return status;
}

static asc_status blue_noise_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->samples > MOST_POINTS)
    return asc_fail(error, ASC_UNSUPPORTED, "blue-noise has at most %d points, optimised when it is made: for more, %s",
                    MOST_POINTS, "poisson-disk");
  blue_noise_state *state = malloc(sizeof *state + (size_t)config->samples * sizeof *state->points);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "blue-noise: out of memory");
  state->samples = config->samples;
  state->seed = config->seed;
  const asc_status status = optimise((uint32_t)config->samples, config->seed, state->points);
  if (status) {
    free(state);
    return asc_fail(error, status, "blue-noise: out of memory");
  }
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* One of the eight symmetries of the square: its three bits exchange the axes and turn each around. */
static double reflected(const double point[2], uint32_t symmetry, uint32_t axis) {
  const double x = point[axis ^ (symmetry & 1u)];
  return (symmetry >> (axis + 1)) & 1u ? 1.0 - x : x;
}

static asc_status blue_noise_fill(const void *opaque, const asc_range *range, double *points) {
  const blue_noise_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  for (uint32_t d = 0; d < range->dimension_count; d++) {
    const uint32_t dimension = range->first_dimension + d, pair = dimension / 2;
    const double shift = asc_rotation(key, dimension);
    const uint32_t symmetry = asc_hash(key, 0, pair, ASC_PURPOSE_SCRAMBLE).word[0];
    asc_permutation order;
    if (pair > 0) asc_permutation_make(&order, state->samples, key, pair);
    for (size_t i = 0; i < range->sample_count; i++) {
      const uint64_t sample = range->first_sample + i;
      const double *point = state->points[pair > 0 ? asc_permutation_at(&order, sample) : sample];
      points[i * range->dimension_count + d] = asc_rotate(reflected(point, symmetry, dimension % 2), shift);
    }
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_blue_noise = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "blue-noise",
    .title = "points optimised to have no power at low frequencies",
    .source = "Ahmed, Ren, Wonka 2022",
    .create = blue_noise_create,
    .destroy = free,
    .fill = blue_noise_fill,
};

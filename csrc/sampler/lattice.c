/* Lattices of rank 1: frac(i z_j / N) for i = 0 ... N - 1.
 *
 * One dimension: z = (1). Two: the Fibonacci lattice, z = (1, F_(k-1)), N = F_k (Bakhvalov 1959; Zaremba 1966, "Good
 * lattice points, discrepancy, and numerical integration").
 *
 * Three and more: z is made component by component (Sloan and Reztsov 2002, "Component-by-component construction of
 * good lattice rules"): z_1 = 1, and each z_j is the candidate with the least P = sum over i of the product over l <= j
 * of (1 + g_l 2 pi^2 B_2(frac(i z_l / N))), B_2(x) = x^2 - x + 1/6: P / N - 1 is the squared worst-case error in the
 * weighted Korobov space of smoothness 2 (the setting of Nuyens and Cools 2006, "Fast algorithms for
 * component-by-component construction of rank-1 lattice rules"), here with weights g_l = 1/l^2.
 *
 * Candidates are units modulo N up to N/2 (N - z has the same P): all of them for N up to 513; above, 256 for each of
 * the first 8 dimensions and 16 for those after, spaced by the golden ratio. (P / N - 1 was then 0 to 12 % above the
 * full search's, for 1021 to 4099 points in up to 8 dimensions.) That costs candidates x N/2 steps a dimension at
 * creation: 0.1 s at 2^20 points. */
#include <stdlib.h>

#include "lanes.h"
#include "vectorise.h"
#include "wide.h"

#define MOST_POINTS (1u << 20) /* in three and more dimensions */
#define MOST_DIMENSIONS 1024

typedef struct lattice_state {
  uint64_t samples;
  uint64_t generator[];
} lattice_state;

static asc_status make_fibonacci(lattice_state *state, asc_error *error) {
  uint64_t last = 1, number = 1; /* F_1, F_2 */
  while (number < state->samples) {
    const uint64_t next = last + number;
    last = number;
    number = next;
  }
  if (number != state->samples)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "lattice in two dimensions is Fibonacci's; %llu is no Fibonacci number: choose %llu or %llu",
                    (unsigned long long)state->samples, (unsigned long long)last, (unsigned long long)number);
  state->generator[0] = 1;
  state->generator[1] = last;
  return ASC_OK;
}

static uint64_t greatest_common_divisor(uint64_t a, uint64_t b) {
  while (b) {
    const uint64_t rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/* What the search keeps. By symmetry it sums over 0 <= i <= N/2: `weight[i]` is the product over the components so far,
 * times 2 where i stands for N - i too, and 0 past N/2. */
typedef struct search {
  uint32_t samples, padded; /* the length of `weight`, a multiple of ASC_LANES */
  double *weight;
} search;

/* The sum over i of weight[i] B_2(frac(i z / N)), up to what does not depend on z: (x^2 - x). In ASC_LANES sums, added
 * in one order, for the same bits on each instruction set. */
ASC_VECTORISE
static double criterion(const search *found, uint32_t z) {
  const uint32_t samples = found->samples;
  const uint32_t step = (uint32_t)((uint64_t)z * ASC_LANES % samples);
  const double inverse = 1.0 / samples;
  uint32_t rest[ASC_LANES];
  double sums[ASC_LANES] = {0.0};
  for (uint32_t i = 0; i < ASC_LANES; i++) rest[i] = (uint32_t)((uint64_t)z * i % samples);
  for (uint32_t begin = 0; begin < found->padded; begin += ASC_LANES) {
    const double *weight = found->weight + begin;
    for (int i = 0; i < ASC_LANES; i++) {
      const double x = (double)(int32_t)rest[i] * inverse;
      sums[i] += weight[i] * (x * x - x);
      const uint32_t next = rest[i] + step;
      rest[i] = next >= samples ? next - samples : next;
    }
  }
  double sum = 0.0;
  for (int i = 0; i < ASC_LANES; i++) sum += sums[i];
  return sum;
}

/* Multiplies the weights by the factor of component `dimension`, counted from 0. */
static void append(search *found, uint32_t z, uint32_t dimension) {
  const double factor = 2.0 * 9.869604401089358 / ((dimension + 1.0) * (dimension + 1.0)); /* 2 pi^2 g */
  for (uint64_t i = 0; i <= found->samples / 2; i++) {
    const double x = (double)(i * z % found->samples) / found->samples;
    found->weight[i] *= 1.0 + factor * (x * x - x + 1.0 / 6.0);
  }
}

static uint32_t best_component(const search *found, uint32_t dimension) {
  const uint32_t half = found->samples / 2 > 0 ? found->samples / 2 : 1;
  const uint32_t wanted = dimension < 8 ? 256 : 16;
  const uint32_t count = half < wanted ? half : wanted;
  uint32_t best = 1;
  double least = 0.0;
  int any = 0;
  for (uint32_t k = 0; k < count; k++) {
    /* All, or the unit at or below frac(k / golden ratio) of the way. */
    uint32_t z = count == half ? k + 1 : 1 + (uint32_t)((uint64_t)(uint32_t)(k * 0x9e3779b9u) * half >> 32);
    if (count == half && greatest_common_divisor(z, found->samples) != 1) continue;
    while (greatest_common_divisor(z, found->samples) != 1) z--;
    const double value = criterion(found, z);
    if (any && value >= least) continue;
    any = 1;
    least = value;
    best = z;
  }
  return best;
}

static asc_status construct(lattice_state *state, uint32_t dimensions, asc_error *error) {
  const uint32_t samples = (uint32_t)state->samples;
  search found = {samples, (samples / 2 + ASC_LANES) / ASC_LANES * ASC_LANES, NULL};
  found.weight = calloc(found.padded, sizeof *found.weight);
  if (!found.weight) return asc_fail(error, ASC_OUT_OF_MEMORY, "lattice: out of memory");
  for (uint32_t i = 0; i <= samples / 2; i++) found.weight[i] = i == 0 || 2 * i == samples ? 1.0 : 2.0;
  for (uint32_t d = 0; d < dimensions; d++) {
    const uint32_t z = d == 0 ? 1 : best_component(&found, d);
    state->generator[d] = z;
    append(&found, z, d);
  }
  free(found.weight);
  return ASC_OK;
}

static asc_status lattice_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions > MOST_DIMENSIONS)
    return asc_fail(error, ASC_UNSUPPORTED, "lattice has at most %d dimensions", MOST_DIMENSIONS);
  if (config->dimensions > 2 && config->samples > MOST_POINTS)
    return asc_fail(error, ASC_UNSUPPORTED, "lattice in three or more dimensions has at most 2^20 points");
  lattice_state *state = malloc(sizeof *state + config->dimensions * sizeof *state->generator);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "lattice: out of memory");
  state->samples = config->samples;
  state->generator[0] = 1;
  asc_status status = ASC_OK;
  if (config->dimensions == 2) status = make_fibonacci(state, error);
  if (config->dimensions > 2) status = construct(state, config->dimensions, error);
  if (status) {
    free(state);
    return status;
  }
  *made = (asc_sampler_state){state, 0, config->samples};
  return ASC_OK;
}

/* frac(i z / N) is (i z mod N) / N, rounded once. */
static asc_status lattice_fill(const void *opaque, const asc_range *range, double *points) {
  const lattice_state *state = opaque;
  const uint64_t samples = state->samples;
  for (uint32_t d = 0; d < range->dimension_count; d++) {
    const uint64_t z = state->generator[range->first_dimension + d];
    uint64_t rest = (uint64_t)((asc_wide)range->first_sample * z % samples);
    for (size_t i = 0; i < range->sample_count; i++) {
      points[i * range->dimension_count + d] = (double)rest / (double)samples;
      rest += z;
      if (rest >= samples) rest -= samples;
    }
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_lattice = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "lattice",
    .title = "a lattice of rank 1: Fibonacci's, or made component by component",
    .source = "Bakhvalov 1959; Sloan and Reztsov 2002",
    .create = lattice_create,
    .destroy = free,
    .fill = lattice_fill,
};

/* Halton's sequence: (phi_2(i), phi_3(i), phi_5(i), ...), phi_b the radical inverse in base b, index 0 kept.
 *
 * Source: Halton 1960, "On the efficiency of certain quasi-random sequences of points in evaluating multi-dimensional
 * integrals". scramble=shift moves each dimension of each pixel by a random amount modulo 1 (Cranley and Patterson
 * 1976). */
#include <stdlib.h>

#include "pattern.h"

#define MAX_DIMENSIONS 1024
#define LARGEST_CHUNK 1024

enum { SCRAMBLE_NONE, SCRAMBLE_SHIFT };

/* Digits are reversed a chunk at a time: `chunk` is the largest power of `base` up to LARGEST_CHUNK, or the base itself
 * where that is larger, `reversed` the table of a chunk's reversals (NULL: a chunk is one digit). */
typedef struct axis {
  uint32_t base, chunk;
  uint16_t *reversed;
} axis;

typedef struct halton_state {
  uint64_t seed;
  int scramble;
  uint32_t dimensions;
  axis axes[];
} halton_state;

static void halton_destroy(void *opaque) {
  halton_state *state = opaque;
  if (!state) return;
  for (uint32_t d = 0; d < state->dimensions; d++) free(state->axes[d].reversed);
  free(state);
}

static uint32_t prime_after(uint32_t n) {
  for (uint32_t candidate = n + 1;; candidate++) {
    uint32_t divisor = 2;
    while (divisor * divisor <= candidate && candidate % divisor) divisor++;
    if (divisor * divisor > candidate) return candidate;
  }
}

static asc_status make_axis(axis *made, uint32_t base) {
  *made = (axis){base, base, NULL};
  while (made->chunk <= LARGEST_CHUNK / base) made->chunk *= base;
  if (made->chunk == base) return ASC_OK;
  made->reversed = malloc(made->chunk * sizeof *made->reversed);
  if (!made->reversed) return ASC_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < made->chunk; i++) {
    uint32_t reversed = 0, rest = i;
    for (uint32_t scale = made->chunk; scale > 1; scale /= base, rest /= base) reversed = reversed * base + rest % base;
    made->reversed[i] = (uint16_t)reversed;
  }
  return ASC_OK;
}

static asc_status halton_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions > MAX_DIMENSIONS)
    return asc_fail(error, ASC_UNSUPPORTED, "halton has at most %d dimensions", MAX_DIMENSIONS);
  halton_state *state = calloc(1, sizeof *state + config->dimensions * sizeof(axis));
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "halton: out of memory");
  state->seed = config->seed;
  state->scramble = (int)config->values[0];
  state->dimensions = config->dimensions;
  for (uint32_t d = 0, base = 1; d < config->dimensions; d++) {
    base = prime_after(base);
    if (make_axis(&state->axes[d], base)) {
      halton_destroy(state);
      return asc_fail(error, ASC_OUT_OF_MEMORY, "halton: out of memory");
    }
  }
  const uint32_t randomised = state->scramble == SCRAMBLE_NONE ? 0 : ASC_TRAIT_RANDOMISED;
  *made = (asc_sampler_state){state, ASC_TRAIT_SEQUENCE | randomised, ASC_SEQUENCE_END};
  return ASC_OK;
}

/* The radical inverse, within 2 ulp: the chunks in Horner's order, least significant of the result first, so that each
 * rounding is divided away by those that follow. */
static double radical_inverse(const axis *along, uint64_t index) {
  uint64_t chunks[54];
  int count = 0;
  do {
    const uint64_t digits = index % along->chunk;
    chunks[count++] = along->reversed ? along->reversed[digits] : digits;
    index /= along->chunk;
  } while (index);
  double value = 0.0;
  while (count) value = (value + (double)chunks[--count]) / along->chunk;
  return value;
}

static asc_status halton_fill(const void *opaque, const asc_range *range, double *points) {
  const halton_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  for (uint32_t d = 0; d < range->dimension_count; d++) {
    const uint32_t dimension = range->first_dimension + d;
    const double shift = state->scramble == SCRAMBLE_SHIFT ? asc_rotation(key, dimension) : 0.0;
    for (size_t i = 0; i < range->sample_count; i++)
      points[i * range->dimension_count + d] =
          asc_rotate(radical_inverse(&state->axes[dimension], range->first_sample + i), shift);
  }
  return ASC_OK;
}

static const asc_parameter halton_parameters[] = {
    {"scramble", ASC_CHOICE, "none|shift", 0, 0, SCRAMBLE_NONE, "none, or a random shift of each pixel modulo 1"},
};

const asc_sampler_interface asc_sampler_halton = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "halton",
    .title = "Halton's sequence, radical inverses in the primes",
    .source = "Halton 1960",
    .parameters = halton_parameters,
    .parameter_count = 1,
    .create = halton_create,
    .destroy = halton_destroy,
    .fill = halton_fill,
};

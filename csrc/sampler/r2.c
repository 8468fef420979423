/* Roberts's sequence: frac(1/2 + i alpha), alpha_j = g^-j for j = 1 ... d, g > 1 the generalised golden ratio of d
 * dimensions, g^(d+1) = g + 1. Of one dimension it is the golden ratio (sometimes called R1), of two the plastic
 * number. The points depend on the number of dimensions of the sampler.
 *
 * Source: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences"; the numbers g are those of Krcadinac
 * 2006, "A new generalization of the golden ratio".
 *
 * Near 2^53 a product in double has no fraction left, so alpha is held in 128 binary digits, and i alpha is taken
 * modulo 1 as integers modulo 2^128. With h = 1/g, h^d (1 + h) = 1; bisection finds h to 128 digits, up to what the
 * powers lose: less than 9 d 2^-128 in alpha (each product loses up to 3 * 2^-128). So for i below 2^53 a value is off
 * by less than d 2^-71, and by less than 2^-53 for being cut to 53 digits. */
#include <stdlib.h>

#include "pattern.h"
#include "wide.h"

#define MOST_DIMENSIONS (1u << 18) /* there the two errors are alike */

typedef struct r2_state {
  uint32_t dimensions;
  asc_wide alpha[];
} r2_state;

/* a b for fractions of 128 binary digits, cut: at most 3 * 2^-128 too small. */
static asc_wide product(asc_wide a, asc_wide b) {
  const uint64_t a_high = (uint64_t)(a >> 64), a_low = (uint64_t)a, b_high = (uint64_t)(b >> 64), b_low = (uint64_t)b;
  return (asc_wide)a_high * b_high + (((asc_wide)a_high * b_low) >> 64) + (((asc_wide)a_low * b_high) >> 64);
}

/* base^exponent for exponent >= 1. */
static asc_wide power(asc_wide base, uint32_t exponent) {
  asc_wide result = base;
  uint32_t bit = 1;
  while (bit <= exponent / 2) bit *= 2;
  for (bit /= 2; bit; bit /= 2) {
    result = product(result, result);
    if (exponent & bit) result = product(result, base);
  }
  return result;
}

/* The h in (0, 1) with h^d (1 + h) = 1. */
static asc_wide inverse_ratio(uint32_t dimensions) {
  asc_wide h = 0;
  for (asc_wide bit = (asc_wide)1 << 127; bit; bit >>= 1) {
    const asc_wide candidate = h | bit, left = power(candidate, dimensions);
    if (left <= ~product(left, candidate)) h = candidate; /* left + left candidate <= 1 */
  }
  return h;
}

static asc_status r2_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions > MOST_DIMENSIONS) return asc_fail(error, ASC_UNSUPPORTED, "r2 has at most 2^18 dimensions");
  r2_state *state = malloc(sizeof *state + config->dimensions * sizeof(asc_wide));
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "r2: out of memory");
  state->dimensions = config->dimensions;
  const asc_wide h = inverse_ratio(config->dimensions);
  state->alpha[0] = h;
  for (uint32_t d = 1; d < config->dimensions; d++) state->alpha[d] = product(state->alpha[d - 1], h);
  *made = (asc_sampler_state){state, ASC_TRAIT_SEQUENCE, ASC_SEQUENCE_END};
  return ASC_OK;
}

static asc_status r2_fill(const void *opaque, const asc_range *range, double *points) {
  const r2_state *state = opaque;
  for (uint32_t d = 0; d < range->dimension_count; d++) {
    const asc_wide alpha = state->alpha[range->first_dimension + d];
    asc_wide value = ((asc_wide)1 << 127) + range->first_sample * alpha;
    for (size_t i = 0; i < range->sample_count; i++, value += alpha)
      points[i * range->dimension_count + d] = (double)(uint64_t)(value >> 75) * 0x1p-53;
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_r2 = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "r2",
    .title = "Roberts's sequence of the generalised golden ratio",
    .source = "Roberts 2018",
    .create = r2_create,
    .destroy = free,
    .fill = r2_fill,
};

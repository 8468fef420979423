/* A sampler that keeps to every contract, for the tests to break in one place each: random points, hashed. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "aliascope/plugin.h"

typedef struct mine {
  uint64_t seed, samples;
  double power;
} mine;

/* PLACE: globals */

static uint64_t mixed(uint64_t x) { /* the finaliser of SplitMix64: Steele, Lea, Flood 2014 */
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

static asc_status create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->samples % 13 == 0 || config->dimensions > 8 || config->samples > 100000) {
    if (error) strcpy(error->text, "mine has no multiples of 13 points, at most 100000, in up to 8 dimensions");
    return ASC_UNSUPPORTED;
  }
  mine *state = malloc(sizeof *state);
  if (!state) return ASC_OUT_OF_MEMORY;
  state->seed = config->seed;
  state->samples = config->samples;
  state->power = config->values[0];
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED | ASC_TRAIT_SEQUENCE, 200000};
  return ASC_OK;
}

static asc_status fill(const void *opaque, const asc_range *range, double *points) {
  const mine *state = opaque;
  const uint64_t pixel = (uint64_t)(uint32_t)range->pixel_x << 32 | (uint32_t)range->pixel_y;
  const uint64_t key = mixed(mixed(state->seed) ^ pixel);
  for (size_t i = 0; i < range->sample_count; i++)
    for (uint32_t d = 0; d < range->dimension_count; d++) {
      const uint64_t sample = range->first_sample + i;
      const uint32_t dimension = range->first_dimension + d;
      double value = (double)(mixed(mixed(key + sample) + dimension) >> 11) * 0x1p-53;
      /* PLACE: value */
      points[i * range->dimension_count + d] = value;
    }
  /* PLACE: filled */
  return ASC_OK;
}

static asc_status weights(const void *opaque, uint64_t first, size_t count, double *weights) {
  const mine *state = opaque;
  for (size_t i = 0; i < count; i++) weights[i] = 1.0 / (double)state->samples;
  (void)first; /* PLACE: weights */
  return ASC_OK;
}

static const asc_parameter parameters[] = {
    {"power", ASC_REAL, NULL, 0.5, 2.0, 1.0, "nothing comes of it"},
};

static const asc_sampler_interface table = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "mine",
    .title = "random points",
    .source = "nowhere",
    .parameters = parameters,
    .parameter_count = 1,
    .create = create,
    .destroy = free,
    .fill = fill,
    .weights = weights,
};

ASC_PLUGIN_EXPORT const void *asc_plugin_interface(uint32_t abi_version, const char *id);

const void *asc_plugin_interface(uint32_t abi_version, const char *id) {
  return abi_version == ASC_ABI_VERSION && strcmp(id, ASC_SAMPLER_INTERFACE_ID) == 0 ? &table : NULL;
}

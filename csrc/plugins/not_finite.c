/* A sampler whose numbers are none, on purpose: random points, of which some have a coordinate, or a weight, that is
 * NaN or infinite. `aliascope stability` hands it to whatever takes samples, to see each of them say which sample it
 * was.
 *
 *     aliascope --trust-plugin ./not_finite.so points not-finite:value=inf -n 16 */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "aliascope/plugin.h"

enum { VALUE, OF, FIRST, COUNT, PARAMETERS };
enum { OF_POINTS, OF_WEIGHTS };

#define DIMENSION 1 /* the one that is none */

typedef struct not_finite_state {
  double value;
  int weights;
  uint64_t seed, samples, first, past; /* of the samples that are concerned */
} not_finite_state;

static uint64_t mixed(uint64_t x) { /* the finaliser of SplitMix64: Steele, Lea, Flood 2014 */
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

static int concerned(const not_finite_state *state, uint64_t sample) {
  return sample >= state->first && sample < state->past;
}

static asc_status create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  (void)error;
  not_finite_state *state = malloc(sizeof *state);
  if (!state) return ASC_OUT_OF_MEMORY;
  const uint64_t first = (uint64_t)config->values[FIRST];
  static const double values[] = {NAN, INFINITY, -INFINITY};
  *state = (not_finite_state){.value = values[(int)config->values[VALUE]],
                              .weights = (int)config->values[OF] == OF_WEIGHTS,
                              .seed = config->seed,
                              .samples = config->samples,
                              .first = first,
                              .past = first + (uint64_t)config->values[COUNT]};
  const uint32_t traits = ASC_TRAIT_RANDOMISED | (state->weights ? ASC_TRAIT_WEIGHTED : ASC_TRAIT_SEQUENCE);
  *made = (asc_sampler_state){state, traits, state->weights ? config->samples : (uint64_t)1 << 32};
  return ASC_OK;
}

static asc_status fill(const void *opaque, const asc_range *range, double *points) {
  const not_finite_state *state = opaque;
  const uint64_t pixel = (uint64_t)(uint32_t)range->pixel_x << 32 | (uint32_t)range->pixel_y;
  const uint64_t key = mixed(mixed(state->seed) ^ pixel);
  for (size_t i = 0; i < range->sample_count; i++)
    for (uint32_t d = 0; d < range->dimension_count; d++) {
      const uint64_t sample = range->first_sample + i, dimension = (uint64_t)range->first_dimension + d;
      const double value = (double)(mixed(mixed(key + sample) + dimension) >> 11) * 0x1p-53;
      *points++ = !state->weights && dimension == DIMENSION && concerned(state, sample) ? state->value : value;
    }
  return ASC_OK;
}

static asc_status weigh(const void *opaque, uint64_t first, size_t count, double *weights) {
  const not_finite_state *state = opaque;
  for (size_t i = 0; i < count; i++)
    weights[i] = state->weights && concerned(state, first + i) ? state->value : 1.0 / (double)state->samples;
  return ASC_OK;
}

static const asc_parameter parameters[PARAMETERS] = {
    {"value", ASC_CHOICE, "nan|inf|negative", 0, 2, 0, "in place of a number; negative: minus infinity"},
    {"of", ASC_CHOICE, "points|weights", 0, 1, OF_POINTS, "what of a sample is none: its coordinate 1, or its weight"},
    {"first", ASC_INTEGER, NULL, 0, 9007199254740992.0, 0, "the first of such samples of each pixel"},
    {"count", ASC_INTEGER, NULL, 0, 9007199254740992.0, 1, "how many there are"},
};

static const asc_sampler_interface not_finite = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "not-finite",
    .title = "a defect: samples that are no numbers",
    .source = "on purpose",
    .parameters = parameters,
    .parameter_count = PARAMETERS,
    .create = create,
    .destroy = free,
    .fill = fill,
    .weights = weigh,
};

ASC_PLUGIN_EXPORT const void *asc_plugin_interface(uint32_t abi_version, const char *id);

const void *asc_plugin_interface(uint32_t abi_version, const char *id) {
  return abi_version == ASC_ABI_VERSION && strcmp(id, ASC_SAMPLER_INTERFACE_ID) == 0 ? &not_finite : NULL;
}

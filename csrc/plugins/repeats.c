/* A sampler with a defect on purpose: a pattern of the library whose dimension 1 repeats dimension 0, as a wrong index
 * would make it. The regression harness is shown it, to see it caught (`make power`).
 *
 *     cc -shared -fPIC -O2 repeats.c -o repeats.so $(pkg-config --cflags --libs aliascope)
 *     aliascope --trust-plugin ./repeats.so points repeats:of=halton -n 16
 *
 * It calls the library, which kronecker.c does not, so it is linked with it. */
#include <stdlib.h>
#include <string.h>

#include "aliascope/plugin.h"

#define CHOICES "random|regular|jittered|halton|sobol|owen"

/* The specs of CHOICES, in their order. */
static const char *const specs[] = {"random", "regular", "jittered", "halton", "sobol", "sobol:scramble=owen"};

static void destroy(void *state) { asc_sampler_destroy(state); }

static asc_status create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  asc_sampler_desc desc = {.struct_size = sizeof desc, .spec = specs[(size_t)config->values[0]]};
  desc.samples = config->samples;
  desc.dimensions = config->dimensions;
  desc.seed = config->seed;
  asc_sampler *sampler = NULL;
  const asc_status status = asc_sampler_create(&desc, &sampler, error);
  if (status != ASC_OK) return status;
  const uint32_t traits = asc_sampler_traits(sampler);
  /* 2^32 is the end of the nets among them, and no sequence is asked for more here. */
  const uint64_t end = traits & ASC_TRAIT_SEQUENCE ? (uint64_t)1 << 32 : config->samples;
  *made = (asc_sampler_state){sampler, traits, end};
  return ASC_OK;
}

static asc_status fill(const void *opaque, const asc_range *range, double *points) {
  const asc_sampler *sampler = opaque;
  const asc_status status = asc_sampler_fill(sampler, range, points);
  const uint32_t first = range->first_dimension, count = range->dimension_count;
  if (status != ASC_OK || first > 1 || first + count < 2) return status; /* dimension 1 is not asked for */
  for (size_t i = 0; i < range->sample_count; i++) {
    const asc_range one = {range->pixel_x, range->pixel_y, range->first_sample + i, 1, 0, 1};
    double *repeated = points + i * count + (1 - first);
    const asc_status again = asc_sampler_fill(sampler, &one, repeated);
    if (again != ASC_OK) return again;
  }
  return ASC_OK;
}

static const asc_parameter parameters[] = {
    {"of", ASC_CHOICE, CHOICES, 0.0, 5.0, 5.0, "the pattern"},
};

static const asc_sampler_interface repeats = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "repeats",
    .title = "a defect: dimension 1 repeats dimension 0",
    .source = "on purpose",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .create = create,
    .destroy = destroy,
    .fill = fill,
};

ASC_PLUGIN_EXPORT const void *asc_plugin_interface(uint32_t abi_version, const char *id);

const void *asc_plugin_interface(uint32_t abi_version, const char *id) {
  return abi_version == ASC_ABI_VERSION && strcmp(id, ASC_SAMPLER_INTERFACE_ID) == 0 ? &repeats : NULL;
}

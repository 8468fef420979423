/* An example of a sampler as a plugin: copy this file, and put your pattern in its place. After `make install`,
 *
 *     cc -shared -fPIC -O2 kronecker.c -o kronecker.so $(pkg-config --cflags aliascope) -lm
 *     aliascope plugin check ./kronecker.so
 *
 * compile it and check that it keeps to every contract of plugin.h, which says what each function below is given and
 * owes; where pkg-config finds no aliascope, export PKG_CONFIG_PATH=PREFIX/lib/pkgconfig. Only headers are needed: the
 * library is there when the plugin is loaded. From then on every command takes it:
 *
 *     aliascope --trust-plugin ./kronecker.so points kronecker:shift=0.25 -n 16
 *     aliascope compare --trust-plugin ./kronecker.so
 *
 * The pattern: Kronecker's sequence, (frac(shift + i sqrt 2), frac(shift + i sqrt 3), frac(shift + i sqrt 5), ...),
 * which Weyl (1916) showed to be uniformly distributed and Richtmyer (1951) used for integrals. Its one parameter is
 * the shift of all coordinates. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "aliascope/plugin.h"

#define MOST_DIMENSIONS 16

static const double primes[MOST_DIMENSIONS] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};

typedef struct kronecker_state {
  double shift;
} kronecker_state;

/* Called once for each sampler that is made. Everything in `config` is resolved and within the ranges of the parameter
 * table below. What can't be had is ASC_UNSUPPORTED, with the reason in `error`, which may be NULL. */
static asc_status create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions > MOST_DIMENSIONS) {
    if (error) *error = (asc_error){"kronecker has at most 16 dimensions"};
    return ASC_UNSUPPORTED;
  }
  kronecker_state *state = malloc(sizeof *state);
  if (!state) return ASC_OUT_OF_MEMORY;
  state->shift = config->values[0];
  /* Not randomised: seed and pixel do not matter. A sequence: the first n points do not depend on N. Past 2^32 the
   * product with the index would lose the digits of the fraction. */
  *made = (asc_sampler_state){state, ASC_TRAIT_SEQUENCE, (uint64_t)1 << 32};
  return ASC_OK;
}

/* Called from many threads at once: only reads `opaque`. The range is valid. */
static asc_status fill(const void *opaque, const asc_range *range, double *points) {
  const kronecker_state *state = opaque;
  for (size_t i = 0; i < range->sample_count; i++) {
    const double index = (double)(range->first_sample + i);
    for (uint32_t d = 0; d < range->dimension_count; d++) {
      const double value = state->shift + fmod(index * sqrt(primes[range->first_dimension + d]), 1.0);
      *points++ = value >= 1.0 ? value - 1.0 : value;
    }
  }
  return ASC_OK;
}

static const asc_parameter parameters[] = {
    {"shift", ASC_REAL, NULL, 0.0, 0.999999, 0.5, "added to every coordinate, modulo 1"},
};

static const asc_sampler_interface kronecker = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "kronecker",
    .title = "Kronecker's sequence of square roots",
    .source = "Weyl 1916; Richtmyer 1951",
    .parameters = parameters,
    .parameter_count = 1,
    .create = create,
    .destroy = free,
    .fill = fill,
};

/* The one function that is exported: the table for an interface that this plugin has, or NULL. */
ASC_PLUGIN_EXPORT const void *asc_plugin_interface(uint32_t abi_version, const char *id);

const void *asc_plugin_interface(uint32_t abi_version, const char *id) {
  return abi_version == ASC_ABI_VERSION && strcmp(id, ASC_SAMPLER_INTERFACE_ID) == 0 ? &kronecker : NULL;
}

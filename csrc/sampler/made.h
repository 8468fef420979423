/* What a sampler is inside: registry.c makes the ones that are registered, arrangement.c those that are made of them.
 */
#ifndef ASC_MADE_H
#define ASC_MADE_H

#include "aliascope/plugin.h"
#include "spec.h"

struct asc_sampler {
  const asc_sampler_interface *interface;
  asc_sampler_state made;
  asc_sampler_desc resolved;
  char spec[ASC_SPEC_LENGTH];
};

/* The same sampler with another seed, arranged as it is. */
asc_status asc_sampler_reseed(const asc_sampler *sampler, uint64_t seed, asc_sampler **made, asc_error *error);

/* Registers the table of a plugin. ASC_PLUGIN where it is not usable, or the name is taken. */
asc_status asc_register(const asc_sampler_interface *table, const char *path, asc_error *error);

/* Loads a plugin and checks its table, without registering it. */
asc_status asc_plugin_open(const char *path, const asc_sampler_interface **table, asc_error *error);

/* asc_sampler_fill_area, of a plugin's own functions. */
asc_status asc_fill_area_of(const asc_sampler_interface *interface, const void *state, const asc_range *range,
                            uint32_t columns, size_t first, size_t pixels, double *points);

#endif

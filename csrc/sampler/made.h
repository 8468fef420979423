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

#endif

/* What creation refuses, and how it says so. Include after cmocka.h. */
#ifndef REFUSED_H
#define REFUSED_H

#include <string.h>

#include "aliascope/sampler.h"

static inline void assert_refused(const char *spec, uint64_t samples, uint32_t dimensions, asc_status status,
                                  const char *text) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, 0};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  assert_int_equal(asc_sampler_create(&desc, &sampler, &error), status);
  assert_null(sampler);
  if (!strstr(error.text, text)) fail_msg("%s: %s", spec, error.text);
}

#endif

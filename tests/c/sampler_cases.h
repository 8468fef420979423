/* Every sampler that is registered, in every form, for the tests of what holds of all: a line each. N is a count that
 * the pattern has in `dimensions` dimensions, at least 16 and at most 100. */
#ifndef SAMPLER_CASES_H
#define SAMPLER_CASES_H

#include <stdint.h>

typedef struct sampler_case {
  const char *spec;
  uint32_t samples, dimensions;
  const char *biased; /* why the pattern is not uniform by its definition, else NULL */
} sampler_case;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers" /* most rows end before `biased` */
static const sampler_case cases[] = {
    {"random", 64, 3},
    {"regular", 64, 3},
    {"jittered", 64, 3},
    {"halton", 64, 3},
    {"halton:scramble=shift", 64, 3},
    {"sobol", 64, 3},
    {"sobol:scramble=shift", 64, 3},
    {"sobol:scramble=digit", 64, 3},
    {"sobol:scramble=owen", 64, 3},
    {"poisson-disk", 64, 3},
    {"poisson-disk:toroidal=0", 64, 3, "points near an edge have fewer neighbours to keep away from: more lie there"},
    {"best-candidate", 16, 3},
    {"blue-noise", 16, 3},
    /* end of the list */
};
#pragma GCC diagnostic pop
#define CASES (sizeof cases / sizeof *cases)
#define MOST_VALUES (100 * 8) /* samples x dimensions of a case */

#endif

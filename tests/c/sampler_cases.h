/* Every sampler that is registered, in every form, for the tests of what holds of all: a line each. N is a count that
 * the pattern has in `dimensions` dimensions, at least 16 and at most 100. */
#ifndef SAMPLER_CASES_H
#define SAMPLER_CASES_H

#include <stdint.h>

typedef struct sampler_case {
  const char *spec;
  uint32_t samples, dimensions;
} sampler_case;

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
    {"sgi-8x8", 8, 2}, /* the most it has */
    {"standard-msaa", 16, 2},
    {"gauss-legendre", 64, 3},
    {"clenshaw-curtis", 64, 3},
    {"cook", 16, 3},
    {"cook:centred=1", 16, 3},
    {"pan-diagonal", 64, 3},
    {"pan-diagonal:centred=1", 81, 3},
    {"mitchell-spacetime", 16, 3},
    {"mitchell-spacetime:centred=1", 64, 3},
    {"zaremba", 64, 2},
    {"zaremba:digits=finite", 64, 2},
    {"larcher-pillichshammer", 64, 2},
    {"pmj02", 64, 3},
    {"r2", 64, 3},
    {"lattice", 55, 2},
    {"lattice", 64, 3},
    /* end of the list */
};
#define CASES (sizeof cases / sizeof *cases)
#define MOST_VALUES (100 * 8) /* samples x dimensions of a case */

#endif

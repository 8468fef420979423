/* Every sampler that is registered, in every form, for the tests of what holds of all: a line each. N is a count that
 * the pattern has in `dimensions` dimensions, at least 16 and at most 100. The fields after these may be left out. */
#ifndef SAMPLER_CASES_H
#define SAMPLER_CASES_H

#include <stdint.h>

typedef struct sampler_case {
  const char *spec;
  uint32_t samples, dimensions;
  uint32_t most; /* for patterns too slow to be made of 2^20 points in a test: of how many instead; 0: 2^20 */
  int biased;    /* 1: randomised, but on a lattice, so with a bias that its definition has */
} sampler_case;

#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
static const sampler_case cases[] = {
    {"random", 64, 3},
    {"regular", 64, 3},
    {"jittered", 64, 3},
    {"halton", 64, 3},
    {"halton:scramble=shift", 64, 3},
    {"halton:scramble=digit", 64, 3},
    {"halton:scramble=owen", 64, 3},
    {"sobol", 64, 3},
    {"sobol:scramble=shift", 64, 3},
    {"sobol:scramble=digit", 64, 3},
    {"sobol:scramble=owen", 64, 3},
    {"hammersley", 64, 3},
    {"hammersley:scramble=shift", 64, 3},
    {"hammersley:scramble=digit", 64, 3},
    {"hammersley:scramble=owen", 64, 3},
    {"n-rooks", 64, 3},
    {"n-rooks", 80, 5}, /* above 64 the permutations are made otherwise */
    {"n-rooks:centred=1", 64, 3},
    {"n-rooks:corner=1", 64, 3, 0, 1},
    /* end of the list */
};
#define CASES (sizeof cases / sizeof *cases)
#define MOST_VALUES (100 * 8) /* samples x dimensions of a case */

#endif

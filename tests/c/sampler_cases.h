/* Every sampler that is registered, in every form, for the tests of what holds of all: a line each. N is a count that
 * the pattern has in `dimensions` dimensions, at least 16 and at most 100. The fields after these may be left out. */
#ifndef SAMPLER_CASES_H
#define SAMPLER_CASES_H

#include <stdint.h>

typedef struct sampler_case {
  const char *spec;
  uint32_t samples, dimensions;
  uint32_t most; /* for patterns too slow to be made of 2^20 points in a test: of how many instead; 0: 2^20 */
  /* Why, by the pattern's definition, two dimensions of a pair (0,1), (2,3), ... are not uniform together, though each
   * alone is. */
  const char *biased_in_pairs;
  const char *biased; /* why single dimensions are not uniform either */
} sampler_case;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmissing-field-initializers" /* most rows say nothing of them */

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
    {"sobol:scramble=owen-full", 64, 3},
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
    {"latin-square", 64, 3},
    {"latin-square", 64, 2},
    {"latin-square", 64, 5},
    {"latin-square:centred=1", 64, 2, .biased_in_pairs = "jumps see the centres of cells only"},
    {"n-queens", 64, 3, .most = 4099, .biased_in_pairs = "fewer solutions have a queen in the corner than elsewhere"},
    {"n-queens:centred=1", 64, 3, .most = 4099, .biased_in_pairs = "the same"},
    {"n-queens:solution=construction", 64, 3, .biased_in_pairs = "four solutions"},
    {"multi-jittered", 64, 3},
    {"multi-jittered", 60, 4},
    {"correlated-multi-jittered", 64, 3},
    {"correlated-multi-jittered", 60, 4},
    {"orthogonal-array", 64, 3},
    {"orthogonal-array:jitter=jittered", 49, 5},
    {"orthogonal-array:jitter=correlated", 81, 5},
    {"orthogonal-array:strength=3", 64, 5},
    {"orthogonal-array:strength=3,jitter=jittered", 27, 4},
    {"orthogonal-array:strength=3,jitter=correlated", 27, 4},
    {"hammersley", 64, 3},
    {"hammersley:scramble=shift", 64, 3},
    {"hammersley:scramble=digit", 64, 3},
    {"hammersley:scramble=owen", 64, 3},
    {"n-rooks", 64, 3},
    {"n-rooks", 80, 5}, /* above 64 the permutations are made otherwise */
    {"n-rooks:centred=1", 64, 3},
    {"n-rooks:corner=1", 64, 3, .biased_in_pairs = "points lie on the corners of cells"},
    {"poisson-disk", 64, 3, .most = 16384},
    {"poisson-disk:toroidal=0", 64, 3, .most = 16384,
     .biased = "points near an edge have fewer neighbours to keep away from: more lie there"},
    {"best-candidate", 16, 3, .most = 1024},
    {"blue-noise", 16, 3, .most = 1024},
    /* end of the list */
};
#pragma GCC diagnostic pop
#define CASES (sizeof cases / sizeof *cases)
#define MOST_VALUES (100 * 8) /* samples x dimensions of a case */

#endif

/* What multi-jittered and correlated-multi-jittered share: m x n cells that are divided again, so that the pattern is
 * jittered in the cells and has one point in each of the N = m n columns and N rows of sub-cells. m is the largest
 * divisor of N up to its square root: any N has such a pattern, but a prime's single column of cells makes it n-rooks,
 * with no other strata. N up to 2^32, as many as there are 32-bit cells.
 *
 * The samples come in random order, as in Kensler's paper. More than two dimensions are padded: an independent pattern
 * for each pair (0,1), (2,3), ... in an order of its own; a last dimension without a partner is the first axis of one.
 */
#ifndef ASC_MULTI_JITTER_H
#define ASC_MULTI_JITTER_H

#include "pattern.h"

/* ASC_UNSUPPORTED above 2^32 points. `correlated`: all columns share a permutation of sub-columns, all rows one of
 * sub-rows; otherwise each has its own. */
asc_status asc_multi_jitter_create(const asc_sampler_config *config, const char *name, int correlated,
                                   asc_sampler_state *made, asc_error *error);
asc_status asc_multi_jitter_fill(const void *opaque, const asc_range *range, double *points);

#endif

/* One point in each of m x n cells, and one in each of N = m n columns and N rows: jittered and n-rooks at once.
 *
 * Source: Chiu, Shirley, Wang 1994, "Multi-jittered sampling", Graphics Gems IV. Their canonical arrangement puts the
 * point of cell (column i, row j) into its j-th sub-column and i-th sub-row; then the sub-columns are shuffled within
 * each column of cells, the sub-rows within each row, each by a random permutation of its own, here from the hash: any
 * sample without the others. multi_jitter.h says which m and n. */
#include <stdlib.h>

#include "multi_jitter.h"

static asc_status multi_jittered_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  return asc_multi_jitter_create(config, "multi-jittered", 0, made, error);
}

const asc_sampler_interface asc_sampler_multi_jittered = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "multi-jittered",
    .title = "jittered and n-rooks at once",
    .source = "Chiu, Shirley, Wang 1994",
    .create = multi_jittered_create,
    .destroy = free,
    .fill = asc_multi_jitter_fill,
};

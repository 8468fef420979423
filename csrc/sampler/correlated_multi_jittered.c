/* Multi-jittered, with one permutation of sub-columns for all columns of cells and one of sub-rows for all rows: points
 * of neighbouring cells move alike, so they crowd less.
 *
 * Source: Kensler 2013, "Correlated multi-jittered sampling", Pixar Technical Memo 13-01, section 3: the point of cell
 * (column i, row j) lies in sub-column sigma(j) and sub-row tau(i). The permutations are this library's (permutation.h)
 * instead of the memo's hash, which does not reach all of them. multi_jitter.h says which m and n. */
#include <stdlib.h>

#include "multi_jitter.h"

static asc_status correlated_multi_jittered_create(const asc_sampler_config *config, asc_sampler_state *made,
                                                   asc_error *error) {
  return asc_multi_jitter_create(config, "correlated-multi-jittered", 1, made, error);
}

const asc_sampler_interface asc_sampler_correlated_multi_jittered = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "correlated-multi-jittered",
    .title = "multi-jittered, all rows and all columns shuffled alike",
    .source = "Kensler 2013",
    .create = correlated_multi_jittered_create,
    .destroy = free,
    .fill = asc_multi_jitter_fill,
};

/* Tensor products of one quadrature rule on [0, 1] with k points: N = k^d points, the first dimension running fastest,
 * each with the product of its weights. The same in every pixel. */
#ifndef ASC_TENSOR_H
#define ASC_TENSOR_H

#include "pattern.h"

#define ASC_RULE_END ((uint32_t)1 << 20) /* the most points along a dimension */

/* Writes the rule with `count` points, 1 to ASC_RULE_END: nodes in [0, 1], ascending; weights that add up to 1. */
typedef void (*asc_rule_function)(uint32_t count, double *nodes, double *weights);

/* ASC_UNSUPPORTED where N is no k^d with k up to ASC_RULE_END. */
asc_status asc_tensor_create(const char *name, asc_rule_function rule, const asc_sampler_config *config,
                             asc_sampler_state *made, asc_error *error);

/* For the interface; `destroy` is free. */
asc_status asc_tensor_fill(const void *opaque, const asc_range *range, double *points);
asc_status asc_tensor_weights(const void *opaque, uint64_t first, size_t count, double *weights);

#endif

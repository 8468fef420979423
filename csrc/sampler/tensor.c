#include "tensor.h"

#include <stdlib.h>

typedef struct tensor_state {
  uint32_t side, dimensions;
  double rule[]; /* the nodes, then the weights */
} tensor_state;

asc_status asc_tensor_create(const char *name, asc_rule_function rule, const asc_sampler_config *config,
                             asc_sampler_state *made, asc_error *error) {
  const uint32_t d = config->dimensions;
  const uint64_t side = asc_exact_root(config->samples, d);
  if (side == 0)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "%s has k^%u points in %u dimensions; %llu is not such a power: choose 1, 2^%u, 3^%u, ...", name, d,
                    d, (unsigned long long)config->samples, d, d);
  if (side > ASC_RULE_END)
    return asc_fail(error, ASC_UNSUPPORTED, "%s has at most 2^20 points along a dimension, not %llu", name,
                    (unsigned long long)side);
  tensor_state *state = malloc(sizeof *state + 2 * (size_t)side * sizeof *state->rule);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "%s: out of memory", name);
  state->side = (uint32_t)side;
  state->dimensions = d;
  rule(state->side, state->rule, state->rule + side);
  /* Rules may have the end of the interval; samplers may not. */
  if (state->rule[side - 1] >= 1.0) state->rule[side - 1] = 1.0 - 0x1p-24;
  *made = (asc_sampler_state){state, ASC_TRAIT_WEIGHTED, config->samples};
  return ASC_OK;
}

asc_status asc_tensor_fill(const void *opaque, const asc_range *range, double *points) {
  const tensor_state *state = opaque;
  const uint64_t side = state->side;
  for (size_t i = 0; i < range->sample_count; i++) {
    uint64_t rest = range->first_sample + i;
    for (uint32_t d = 0; d < range->first_dimension; d++) rest /= side;
    for (uint32_t d = 0; d < range->dimension_count; d++, rest /= side) *points++ = state->rule[rest % side];
  }
  return ASC_OK;
}

asc_status asc_tensor_weights(const void *opaque, uint64_t first, size_t count, double *weights) {
  const tensor_state *state = opaque;
  const uint64_t side = state->side;
  for (size_t i = 0; i < count; i++) {
    uint64_t rest = first + i;
    double product = 1.0;
    for (uint32_t d = 0; d < state->dimensions; d++, rest /= side) product *= state->rule[side + rest % side];
    weights[i] = product;
  }
  return ASC_OK;
}

/* Sampling until a criterion says that it is enough.
 *
 * Each pixel gets `minimum` samples, then `batch` more at a time while the criterion is not satisfied and the sampler's
 * N is not reached. Stopping when the samples look good biases the mean: where all of the first agree by chance, what
 * they missed stays missed. With unbiased=1 the decision is kept apart from the estimate (Kirk and Arvo 1991, "Unbiased
 * sampling techniques for image synthesis"): after n samples that decide, n fresh ones make the estimate, and the first
 * are thrown away. Given n, the mean of independent fresh samples is unbiased.
 *
 * Both papers sample the whole pixel. With more cells and a margin, each cell is a small pixel that also sees what is
 * close by: cells.h. */
#include "sequential.h"

static asc_cells cells_of(const double *values) {
  return (asc_cells){.refinement = ASC_ONE_BY_ONE,
                     .side = (uint32_t)values[ASC_SEQUENTIAL_CELLS],
                     .minimum = (uint64_t)values[ASC_SEQUENTIAL_MINIMUM],
                     .batch = (uint64_t)values[ASC_SEQUENTIAL_BATCH],
                     .margin = values[ASC_SEQUENTIAL_MARGIN],
                     .unbiased = values[ASC_SEQUENTIAL_UNBIASED] > 0.0};
}

uint32_t asc_sequential_reach(const double *values) { return asc_cells_reach(values[ASC_SEQUENTIAL_MARGIN]); }

asc_status asc_sequential_prepare(asc_estimator *self, asc_criterion_kind kind, asc_error *error) {
  const asc_cells how = cells_of(self->values);
  self->criterion = (asc_criterion){.kind = kind,
                                    .tolerance = self->values[ASC_SEQUENTIAL_TOLERANCE],
                                    .confidence = self->values[ASC_SEQUENTIAL_CONFIDENCE]};
  return asc_cells_prepare(self, &how, error);
}

asc_status asc_sequential_run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                              asc_estimates *made, asc_error *error) {
  const asc_cells how = cells_of(self->values);
  return asc_cells_run(self, &how, group, integrand, context, made, error);
}

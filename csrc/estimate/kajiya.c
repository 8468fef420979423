/* Hierarchical sampling: cells are sampled until the criterion is satisfied, and split into four where it is not.
 *
 * Kajiya 1986, "The rendering equation", Computer Graphics 20(4), section 5: sequential sampling, whose density is
 * even, misses the chance to sample more where the integrand varies; so the domain is a tree, each leaf of which is
 * sampled for itself, and split where its samples say so. A cell that is split leaves its samples to its four quarters,
 * each of which gets as many as a cell begins with, minimum/cells^2, where it has fewer. Largest cells first, until the
 * N samples of the pixel are spent. */
#include "cells.h"
#include "criterion_parameters.h"

enum { MINIMUM = ASC_KEYS_OF_CRITERION, CELLS, MARGIN, UNBIASED, NODE, DEPTH };

static const asc_parameter parameters[] = {
    ASC_PARAMETERS_OF_CRITERION(ASC_BY_CONTRAST, 0.02),
    ASC_PARAMETER_MINIMUM(1, 4),
    ASC_PARAMETER_CELLS(2),
    ASC_PARAMETER_MARGIN(1.5),
    ASC_PARAMETER_UNBIASED,
    {"node", ASC_INTEGER, NULL, 4, 65536, 8, "samples of a cell at which it is split"},
    {"depth", ASC_INTEGER, NULL, 0, 20, 10, "how often a cell may be split"}};

static asc_cells cells_of(const double *values) {
  return (asc_cells){.refinement = ASC_BY_SPLITTING,
                     .side = (uint32_t)values[CELLS],
                     .minimum = (uint64_t)values[MINIMUM],
                     .node = (uint64_t)values[NODE],
                     .depth = (uint32_t)values[DEPTH],
                     .margin = values[MARGIN],
                     .unbiased = values[UNBIASED] > 0.0};
}

static uint32_t reach(const double *values) { return asc_cells_reach(values[MARGIN]); }

static asc_status prepare(asc_estimator *self, asc_error *error) {
  const asc_cells how = cells_of(self->values);
  self->criterion = asc_criterion_of(self->values);
  return asc_cells_prepare(self, &how, error);
}

static asc_status run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                      asc_estimates *made, asc_error *error) {
  const asc_cells how = cells_of(self->values);
  return asc_cells_run(self, &how, group, integrand, context, made, error);
}

const asc_estimator_interface asc_estimator_kajiya = {.name = "kajiya",
                                                      .title = "cells that are split while their samples differ",
                                                      .source = "Kajiya 1986, The rendering equation",
                                                      .parameters = parameters,
                                                      .parameter_count = sizeof parameters / sizeof *parameters,
                                                      .least_dimensions = 2,
                                                      .reach = reach,
                                                      .prepare = prepare,
                                                      .run = run};

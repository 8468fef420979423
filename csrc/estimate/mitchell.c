/* Two levels: a few samples everywhere, and a blast of them where the contrast is high.
 *
 * Mitchell 1987, "Generating antialiased images at low sampling densities", Computer Graphics 21(4), section 4. He
 * takes about one sample a pixel, looks at squares of 3 x 3 pixels, and takes 4 or 9 a pixel where the contrast of a
 * square, (Imax - Imin)/(Imax + Imin), exceeds 0.4, 0.3 or 0.6 in red, green or blue. Here the squares are the cells of
 * a pixel with a margin around them, so that the blast falls on the part of the pixel that an edge crosses; cells=1,
 * margin=0 looks at whole pixels alone. The blast brings a cell to its share of the N samples of a pixel. Any other
 * criterion may take the place of the contrast. */
#include "cells.h"
#include "criterion_parameters.h"

enum { MINIMUM = ASC_KEYS_OF_CRITERION, CELLS, MARGIN, UNBIASED };

static const asc_parameter parameters[] = {ASC_PARAMETERS_OF_CRITERION(ASC_BY_CONTRAST, 0.02),
                                           ASC_PARAMETER_MINIMUM(1, 8), ASC_PARAMETER_CELLS(4),
                                           ASC_PARAMETER_MARGIN(0.8), ASC_PARAMETER_UNBIASED};

static asc_cells cells_of(const double *values) {
  return (asc_cells){.refinement = ASC_ALL_AT_ONCE,
                     .side = (uint32_t)values[CELLS],
                     .minimum = (uint64_t)values[MINIMUM],
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

const asc_estimator_interface asc_estimator_mitchell = {
    .name = "mitchell",
    .title = "two levels: all N samples where the contrast is high",
    .source = "Mitchell 1987, Generating antialiased images at low sampling densities",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .reach = reach,
    .prepare = prepare,
    .run = run};

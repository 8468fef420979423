/* Sampling a pixel until a criterion says that it is enough: what student-t and chi-squared share. */
#ifndef ASC_SEQUENTIAL_H
#define ASC_SEQUENTIAL_H

#include "cells.h"

/* The parameters, in the order of their tables. */
enum {
  ASC_SEQUENTIAL_TOLERANCE,
  ASC_SEQUENTIAL_CONFIDENCE,
  ASC_SEQUENTIAL_MINIMUM,
  ASC_SEQUENTIAL_BATCH,
  ASC_SEQUENTIAL_UNBIASED,
  ASC_SEQUENTIAL_CELLS,
  ASC_SEQUENTIAL_MARGIN,
  ASC_SEQUENTIAL_COUNT
};

/* Those that are the same in both tables. */
#define ASC_SEQUENTIAL_PARAMETERS                                                                                      \
  {"confidence", ASC_REAL, NULL, 0.0001, 0.999999999999, 0.95, "probability that the statement on the error holds"},   \
      ASC_PARAMETER_MINIMUM(2, 8),                                                                                     \
      {"batch", ASC_INTEGER, NULL, 1, 9007199254740992.0, 1, "samples of a cell between decisions"},                   \
      ASC_PARAMETER_UNBIASED, ASC_PARAMETER_CELLS(1), ASC_PARAMETER_MARGIN(0)

/* For the interfaces. The most samples of a pixel are the sampler's N; half of them decide where `unbiased`. */
asc_status asc_sequential_prepare(asc_estimator *self, asc_criterion_kind kind, asc_error *error);
asc_status asc_sequential_run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                              asc_estimates *made, asc_error *error);
uint32_t asc_sequential_reach(const double *values);

#endif

/* Sampling a pixel until a criterion says that it is enough: what student-t and chi-squared share. */
#ifndef ASC_SEQUENTIAL_H
#define ASC_SEQUENTIAL_H

#include "estimator.h"

/* The parameters, in the order of their tables. */
enum {
  ASC_SEQUENTIAL_TOLERANCE,
  ASC_SEQUENTIAL_CONFIDENCE,
  ASC_SEQUENTIAL_MINIMUM,
  ASC_SEQUENTIAL_BATCH,
  ASC_SEQUENTIAL_UNBIASED,
  ASC_SEQUENTIAL_COUNT
};

/* Those that are the same in both tables. */
#define ASC_SEQUENTIAL_PARAMETERS                                                                                      \
  {"confidence", ASC_REAL, NULL, 0.0001, 0.999999, 0.95, "probability that the statement on the error holds"},         \
      {"minimum", ASC_INTEGER, NULL, 2, 9007199254740992.0, 8, "samples before the first decision"},                   \
      {"batch", ASC_INTEGER, NULL, 1, 9007199254740992.0, 1, "samples between decisions"}, {                           \
    "unbiased", ASC_INTEGER, NULL, 0, 1, 0, "1: the samples decide how many fresh ones make the estimate"              \
  }

/* For the interfaces. The most samples of a pixel are the sampler's N; half of them decide where `unbiased`. */
asc_status asc_sequential_prepare(asc_estimator *self, asc_criterion_kind kind, asc_error *error);
asc_status asc_sequential_run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                              asc_estimates *made, asc_error *error);

#endif

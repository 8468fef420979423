/* The keys that choose a criterion, for estimators that may have any of them. */
#ifndef ASC_CRITERION_PARAMETERS_H
#define ASC_CRITERION_PARAMETERS_H

#include "criterion.h"

/* The first entries of an estimator's table. */
enum {
  ASC_KEY_CRITERION,
  ASC_KEY_TOLERANCE,
  ASC_KEY_CONFIDENCE,
  ASC_KEY_RED,
  ASC_KEY_GREEN,
  ASC_KEY_BLUE,
  ASC_KEYS_OF_CRITERION
};

#define ASC_PARAMETERS_OF_CRITERION(kind, tolerance)                                                                   \
  {"criterion", ASC_CHOICE, ASC_CRITERIA, 0, 4, kind, "what must hold of samples for no more to be taken"},            \
      {"tolerance",                                                                                                    \
       ASC_REAL,                                                                                                       \
       NULL,                                                                                                           \
       0.0,                                                                                                            \
       1e300,                                                                                                          \
       tolerance,                                                                                                      \
       "of the variance; of the range; of half of Student's interval; of the mean's deviation, by chi-squared"},       \
      {"confidence", ASC_REAL, NULL, 0.0001, 0.999999999999, 0.95, "of student-t and chi-squared"},                    \
      {"red", ASC_REAL, NULL, 0.0, 1.0, ASC_CONTRAST_RED, "contrast that is low enough, in the first channel"},        \
      {"green", ASC_REAL, NULL, 0.0, 1.0, ASC_CONTRAST_GREEN, "in the second"}, {                                      \
    "blue", ASC_REAL, NULL, 0.0, 1.0, ASC_CONTRAST_BLUE, "in all others"                                               \
  }

static inline asc_criterion asc_criterion_of(const double *values) {
  return (asc_criterion){.kind = (asc_criterion_kind)values[ASC_KEY_CRITERION],
                         .tolerance = values[ASC_KEY_TOLERANCE],
                         .confidence = values[ASC_KEY_CONFIDENCE],
                         .contrast = {values[ASC_KEY_RED], values[ASC_KEY_GREEN], values[ASC_KEY_BLUE]}};
}

#endif

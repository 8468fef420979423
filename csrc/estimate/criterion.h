/* When samples are enough. Criteria and refinements are separate: every estimator that decides asks one of these. */
#ifndef ASC_CRITERION_H
#define ASC_CRITERION_H

#include "aliascope/estimate.h"

typedef enum asc_criterion_kind {
  ASC_BY_CONTRAST = 0,
  ASC_BY_VARIANCE = 1,
  ASC_BY_RANGE = 2,
  ASC_BY_STUDENT_T = 3,
  ASC_BY_CHI_SQUARED = 4
} asc_criterion_kind;

/* The order of asc_criterion_kind. */
#define ASC_CRITERIA "contrast|variance|range|student-t|chi-squared"

/* What one channel of some samples came to. */
typedef struct asc_tally {
  asc_moments moments;
  double least, greatest;
} asc_tally;

/* With `samples` as the most values that it will be asked about; its quantiles are worked out once. */
typedef struct asc_criterion {
  asc_criterion_kind kind;
  double
      tolerance;     /* of range: of greatest - least; of variance: of the variance; of student-t: half the width of the
                        interval of the mean; of chi-squared: of the variance of the mean's upper bound, as a deviation */
  double confidence; /* of student-t, chi-squared */
  double contrast[3]; /* of the first three channels; further ones as the last */
  uint64_t least;     /* values before which nothing is enough; 2 at least of student-t and chi-squared */
  double *quantiles;  /* by count, from 0 to `known` - 1; worked out when asked beyond */
  uint64_t known;
} asc_criterion;

asc_status asc_criterion_make(asc_criterion *made, uint64_t samples);
void asc_criterion_free(asc_criterion *made);

/* Adds samples, values being [count][channels], to one tally a channel. ASC_NUMERIC where a value is not finite. */
asc_status asc_tally_add(asc_tally *to, uint32_t channels, const double *values, size_t count);
void asc_tally_merge(asc_tally *to, const asc_tally *from, uint32_t channels);

/* Whether the samples are enough, in every channel. */
int asc_criterion_satisfied(const asc_criterion *of, uint32_t channels, const asc_tally *tallies);

#endif

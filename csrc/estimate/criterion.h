/* When samples are enough. Criteria and refinements are separate: every estimator that decides asks one of these. */
#ifndef ASC_CRITERION_H
#define ASC_CRITERION_H

#include "aliascope/estimate.h"
#include "welford.h"

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

/* What is asked of samples. All but `quantiles` and `known` is filled in before asc_criterion_make.
 *
 *   contrast    (greatest - least)/(|greatest| + |least|) <= contrast[channel], Mitchell 1987's (Imax - Imin)/(Imax +
 *               Imin) where no value is negative, from 0 to 1 for all others too; 0 where both are 0: black on black
 *   variance    the unbiased variance of the values <= tolerance
 *   range       greatest - least <= tolerance
 *   student-t   t s/sqrt(n) <= tolerance, half the width of the interval of the mean that has `confidence`; t the
 *               quantile (1 + confidence)/2 of Student's distribution with n - 1 degrees (Purgathofer 1987)
 *   chi-squared sqrt((n - 1) s^2/(c n)) <= tolerance, what the standard deviation of the mean is below with
 *               `confidence`; c the quantile 1 - confidence of chi-squared with n - 1 degrees (Lee, Redner and Uselton
 *               1985) */
typedef struct asc_criterion {
  asc_criterion_kind kind;
  double tolerance;   /* not negative */
  double confidence;  /* in (0, 1), of student-t and chi-squared */
  double contrast[3]; /* of the first three channels, 0 or more; further ones have the last */
  uint64_t least;     /* values before which nothing is enough; variance, student-t, chi-squared ask for two anyhow */
  double *quantiles;  /* by count, 0 to `known` - 1, so that a decision is cheap; beyond, worked out when asked */
  uint64_t known;
} asc_criterion;

/* Mitchell 1987, section 4: thresholds of red, green, blue. */
#define ASC_CONTRAST_RED 0.4
#define ASC_CONTRAST_GREEN 0.3
#define ASC_CONTRAST_BLUE 0.6

/* Checks it and works out the quantiles for up to `samples` values. ASC_INVALID_VALUE, ASC_OUT_OF_MEMORY. */
asc_status asc_criterion_make(asc_criterion *made, uint64_t samples);
void asc_criterion_free(asc_criterion *made);

/* Adds samples, values being [count][channels], to one tally a channel. ASC_NUMERIC, and nothing is added, where a
 * value is not finite or the squares overflow. */
asc_status asc_tally_add(asc_tally *to, uint32_t channels, const double *values, size_t count);

/* Adds one sample of values that are finite, as is their square. */
static inline void asc_tally_add_known(asc_tally *to, uint32_t channels, const double *values) {
  for (uint32_t c = 0; c < channels; c++) {
    if (to[c].moments.count == 0) to[c].least = to[c].greatest = values[c];
    if (values[c] < to[c].least) to[c].least = values[c];
    if (values[c] > to[c].greatest) to[c].greatest = values[c];
    asc_moments_push(&to[c].moments, values[c]);
  }
}

/* The same for a criterion that looks at no moments but the count. */
static inline void asc_tally_add_extent(asc_tally *to, uint32_t channels, const double *values) {
  for (uint32_t c = 0; c < channels; c++) {
    if (to[c].moments.count++ == 0) to[c].least = to[c].greatest = values[c];
    if (values[c] < to[c].least) to[c].least = values[c];
    if (values[c] > to[c].greatest) to[c].greatest = values[c];
  }
}

static inline int asc_criterion_has_moments(const asc_criterion *of) {
  return of->kind != ASC_BY_CONTRAST && of->kind != ASC_BY_RANGE;
}

asc_status asc_tally_merge(asc_tally *to, const asc_tally *from, uint32_t channels);

/* Whether the samples are enough, in every channel. */
int asc_criterion_satisfied(const asc_criterion *of, uint32_t channels, const asc_tally *tallies);

#endif

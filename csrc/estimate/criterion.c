/* The criteria, whose definitions criterion.h has, and the tallies that they look at.
 *
 * Mitchell 1987, "Generating antialiased images at low sampling densities"; Purgathofer 1987, "A statistical method for
 * adaptive stochastic sampling"; Lee, Redner and Uselton 1985, "Statistically optimized sampling for distributed ray
 * tracing". */
#include "criterion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "welford.h"

#define MOST_KNOWN 1025 /* quantiles beyond take a microsecond or so, beside a thousand samples */

static int by_quantile(const asc_criterion *of) {
  return of->kind == ASC_BY_STUDENT_T || of->kind == ASC_BY_CHI_SQUARED;
}

static uint64_t least_of(const asc_criterion *of) {
  const uint64_t own = of->kind == ASC_BY_CONTRAST || of->kind == ASC_BY_RANGE ? 1 : 2;
  return of->least > own ? of->least : own;
}

/* For `count` values, at least two. */
static double quantile(const asc_criterion *of, uint64_t count) {
  if (count < of->known) return of->quantiles[count];
  const double degrees = fmin((double)count - 1.0, 1e12);
  double found = NAN;
  if (of->kind == ASC_BY_STUDENT_T) {
    (void)asc_student_t_quantile(0.5 * (1.0 - of->confidence), degrees, &found);
    return -found;
  }
  (void)asc_chi_squared_quantile(1.0 - of->confidence, degrees, &found);
  return found;
}

asc_status asc_criterion_make(asc_criterion *made, uint64_t samples) {
  made->quantiles = NULL;
  made->known = 0;
  for (int i = 0; i < 3; i++)
    if (made->kind == ASC_BY_CONTRAST && !(made->contrast[i] >= 0.0)) return ASC_INVALID_VALUE;
  if (made->kind != ASC_BY_CONTRAST && !(made->tolerance >= 0.0)) return ASC_INVALID_VALUE;
  if (!by_quantile(made)) return ASC_OK;
  if (!(made->confidence > 0.0 && made->confidence < 1.0)) return ASC_INVALID_VALUE;
  const uint64_t known = samples < MOST_KNOWN - 1 ? samples + 1 : MOST_KNOWN;
  double *quantiles = malloc(known * sizeof *quantiles);
  if (!quantiles) return ASC_OUT_OF_MEMORY;
  for (uint64_t count = 0; count < known; count++) quantiles[count] = count < 2 ? NAN : quantile(made, count);
  made->quantiles = quantiles;
  made->known = known;
  return ASC_OK;
}

void asc_criterion_free(asc_criterion *made) {
  free(made->quantiles);
  made->quantiles = NULL;
  made->known = 0;
}

static double contrast(const asc_tally *tally) {
  const double largest = fmax(fabs(tally->greatest), fabs(tally->least));
  if (!(largest > 0.0)) return 0.0;
  const double greatest = tally->greatest / largest, least = tally->least / largest; /* whose sum does not overflow */
  return (greatest - least) / (fabs(greatest) + fabs(least));
}

static int channel_satisfied(const asc_criterion *of, uint32_t channel, const asc_tally *tally) {
  const double count = (double)tally->moments.count, squares = tally->moments.squares;
  switch (of->kind) {
  case ASC_BY_CONTRAST: return contrast(tally) <= of->contrast[channel < 2 ? channel : 2];
  case ASC_BY_VARIANCE: return squares / (count - 1.0) <= of->tolerance;
  case ASC_BY_RANGE: return tally->greatest - tally->least <= of->tolerance;
  case ASC_BY_STUDENT_T:
    return quantile(of, tally->moments.count) * sqrt(squares / ((count - 1.0) * count)) <= of->tolerance;
  case ASC_BY_CHI_SQUARED: return sqrt(squares / (quantile(of, tally->moments.count) * count)) <= of->tolerance;
  }
  return 0;
}

int asc_criterion_satisfied(const asc_criterion *of, uint32_t channels, const asc_tally *tallies) {
  for (uint32_t c = 0; c < channels; c++)
    if (tallies[c].moments.count < least_of(of) || !channel_satisfied(of, c, &tallies[c])) return 0;
  return 1;
}

static void push(asc_tally *to, double value) {
  if (to->moments.count == 0) to->least = to->greatest = value;
  if (value < to->least) to->least = value;
  if (value > to->greatest) to->greatest = value;
  asc_moments_push(&to->moments, value);
}

asc_status asc_tally_add(asc_tally *to, uint32_t channels, const double *values, size_t count) {
  asc_tally made[ASC_CHANNELS_MOST];
  memcpy(made, to, channels * sizeof *made);
  for (size_t i = 0; i < count; i++)
    for (uint32_t c = 0; c < channels; c++) push(&made[c], values[i * channels + c]);
  for (uint32_t c = 0; c < channels; c++)
    if (!isfinite(made[c].moments.squares)) return ASC_NUMERIC;
  memcpy(to, made, channels * sizeof *made);
  return ASC_OK;
}

asc_status asc_tally_merge(asc_tally *to, const asc_tally *from, uint32_t channels) {
  for (uint32_t c = 0; c < channels; c++) {
    if (from[c].moments.count == 0) continue;
    const asc_tally before = to[c];
    const asc_status status = asc_moments_merge(&to[c].moments, &from[c].moments);
    if (status) return status;
    to[c].least = before.moments.count ? fmin(before.least, from[c].least) : from[c].least;
    to[c].greatest = before.moments.count ? fmax(before.greatest, from[c].greatest) : from[c].greatest;
  }
  return ASC_OK;
}

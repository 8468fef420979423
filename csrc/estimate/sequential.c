/* Sampling until a criterion says that it is enough.
 *
 * Each pixel gets `minimum` samples, then `batch` more at a time while the criterion is not satisfied and the sampler's
 * N is not reached. Stopping when the samples look good biases the mean: where all of the first agree by chance, what
 * they missed stays missed. With unbiased=1 the decision is kept apart from the estimate (Kirk and Arvo 1991, "Unbiased
 * sampling techniques for image synthesis"): after n samples that decide, the n samples that follow in the sequence
 * make the estimate, and the first are thrown away. Given n, the mean of independent fresh samples is unbiased. */
#include "sequential.h"

#include <stdlib.h>
#include <string.h>

asc_status asc_sequential_prepare(asc_estimator *self, asc_criterion_kind kind, asc_error *error) {
  const double *values = self->values;
  const uint64_t minimum = (uint64_t)values[ASC_SEQUENTIAL_MINIMUM];
  const int unbiased = values[ASC_SEQUENTIAL_UNBIASED] > 0.0;
  const uint64_t most = unbiased ? self->samples / 2 : self->samples;
  if (minimum > most)
    return asc_fail(error, ASC_INVALID_VALUE, "%s: minimum=%llu is more than the %llu samples that a pixel has%s",
                    self->interface->name, (unsigned long long)minimum, (unsigned long long)most,
                    unbiased ? " for the decision" : "");
  self->criterion = (asc_criterion){.kind = kind,
                                    .tolerance = values[ASC_SEQUENTIAL_TOLERANCE],
                                    .confidence = values[ASC_SEQUENTIAL_CONFIDENCE],
                                    .least = minimum};
  const asc_status status = asc_criterion_make(&self->criterion, most);
  return status ? asc_fail(error, status, "%s: %s", self->interface->name, asc_status_text(status)) : ASC_OK;
}

/* A group at work. */
typedef struct state {
  const asc_estimator *self;
  const asc_group *group;
  asc_integrand integrand;
  void *context;
  size_t pixels;
  asc_tally *tallies; /* [pixel][channel] */
  asc_draw *draws;
  size_t *open; /* the pixels that are not decided */
} state;

static asc_status take(const state *of, size_t draws, asc_error *error) {
  return asc_take(of->self, of->draws, draws, of->integrand, of->context, error);
}

static asc_draw draw(const state *of, size_t pixel, uint64_t first, uint64_t count) {
  return (asc_draw){.pixel = asc_pixel_of(of->group, pixel),
                    .first = first,
                    .count = count,
                    .to = of->tallies + pixel * of->self->channels};
}

/* Samples until every pixel is decided. */
static asc_status decide(const state *of, uint64_t most, asc_error *error) {
  const asc_estimator *self = of->self;
  const uint64_t batch = (uint64_t)self->values[ASC_SEQUENTIAL_BATCH];
  uint64_t taken = 0, wanted = self->criterion.least;
  size_t open = of->pixels;
  for (size_t i = 0; i < open; i++) of->open[i] = i;
  while (open) {
    for (size_t i = 0; i < open; i++) of->draws[i] = draw(of, of->open[i], taken, wanted - taken);
    const asc_status status = take(of, open, error);
    if (status) return status;
    taken = wanted;
    if (taken == most) break;
    size_t left = 0;
    for (size_t i = 0; i < open; i++)
      if (!asc_criterion_satisfied(&self->criterion, self->channels, of->tallies + of->open[i] * self->channels))
        of->open[left++] = of->open[i];
    open = left;
    wanted = most - taken < batch ? most : taken + batch;
  }
  return ASC_OK;
}

/* As many fresh samples of each pixel, in place of those that decided. */
static asc_status start_afresh(const state *of, asc_error *error) {
  const uint32_t channels = of->self->channels;
  for (size_t i = 0; i < of->pixels; i++) {
    const uint64_t count = of->tallies[i * channels].moments.count;
    of->draws[i] = draw(of, i, count, count);
  }
  memset(of->tallies, 0, of->pixels * channels * sizeof *of->tallies);
  return take(of, of->pixels, error);
}

asc_status asc_sequential_run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                              asc_estimates *made, asc_error *error) {
  const size_t pixels = (size_t)group->columns * group->rows;
  const int unbiased = self->values[ASC_SEQUENTIAL_UNBIASED] > 0.0;
  const state work = {self,
                      group,
                      integrand,
                      context,
                      pixels,
                      calloc(pixels, self->channels * sizeof *work.tallies),
                      calloc(pixels, sizeof *work.draws),
                      calloc(pixels, sizeof *work.open)};
  asc_status status = work.tallies && work.draws && work.open ? ASC_OK : ASC_OUT_OF_MEMORY;
  if (status) (void)asc_fail(error, status, "out of memory");
  if (status == ASC_OK) status = decide(&work, unbiased ? self->samples / 2 : self->samples, error);
  if (status == ASC_OK && unbiased) status = start_afresh(&work, error);
  for (size_t i = 0; i < pixels && status == ASC_OK; i++) {
    const asc_tally *tallies = work.tallies + i * self->channels;
    asc_write_tallies(made, i, self->channels, tallies, tallies->moments.count * (unbiased ? 2 : 1));
  }
  free(work.tallies);
  free(work.draws);
  free(work.open);
  return status;
}

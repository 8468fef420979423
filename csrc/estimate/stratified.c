/* Strata: the pixel in k x k equal cells (in one dimension k), with as many samples in each.
 *
 * "Stratified Sampling" of the lecture; Cochran 1977, "Sampling techniques", chapter 5. The samples of a cell are those
 * of the sampler that follow each other, moved into it. The standard error is asc_stratify's; with one sample a cell,
 * which is jittered sampling, cells are collapsed with their neighbours, and the standard error is too large. */
#include <math.h>
#include <stdlib.h>

#include "estimator.h"

enum { CELLS, COUNT, PARAMETERS };

static const asc_parameter parameters[PARAMETERS] = {
    {"k", ASC_INTEGER, NULL, 1, 1024, 4, "cells along each of the first two dimensions"},
    {"n", ASC_INTEGER, NULL, 0, 9007199254740992.0, 0, "samples of a pixel, a multiple of the cells; 0: all N"}};

#define MOST_AT_ONCE 65536 /* cells of a block of pixels */

static size_t cells_of(const asc_estimator *self) {
  const size_t k = (size_t)self->values[CELLS];
  return self->dimensions > 1 ? k * k : k;
}

static asc_status prepare(asc_estimator *self, asc_error *error) {
  const uint64_t count = self->values[COUNT] > 0.0 ? (uint64_t)self->values[COUNT] : self->samples;
  const size_t cells = cells_of(self);
  if (count > self->samples)
    return asc_fail(error, ASC_INVALID_VALUE, "stratified: n=%llu is more than the %llu samples of a pixel",
                    (unsigned long long)count, (unsigned long long)self->samples);
  if (count % cells != 0)
    return asc_fail(error, ASC_INVALID_VALUE, "stratified: %llu samples are no multiple of %zu cells",
                    (unsigned long long)count, cells);
  self->samples = count;
  return ASC_OK;
}

/* The draw of a cell; rows run there and back, so that cells with following numbers are neighbours. */
static asc_draw draw_of(const asc_estimator *self, asc_pixel pixel, size_t cell, asc_tally *to) {
  const size_t k = (size_t)self->values[CELLS], cells = cells_of(self);
  const size_t row = cell / k, along = row % 2 ? k - 1 - cell % k : cell % k;
  const double width = 1.0 / (double)k;
  const uint64_t count = self->samples / cells;
  return (asc_draw){.pixel = pixel,
                    .first = cell * count,
                    .count = count,
                    .x = (double)along / (double)k,
                    .y = (double)row / (double)k,
                    .width = width,
                    .height = width,
                    .to = to};
}

/* `tallies` are [cell][channel]; `strata` has room for all cells. */
static asc_status write_pixel(const asc_estimator *self, size_t pixel, const asc_tally *tallies, asc_stratum *strata,
                              asc_estimates *made) {
  const size_t cells = cells_of(self);
  const uint32_t channels = self->channels;
  for (uint32_t c = 0; c < channels; c++) {
    for (size_t i = 0; i < cells; i++) strata[i] = (asc_stratum){1.0, tallies[i * channels + c].moments};
    asc_stratified found;
    const asc_status status = asc_stratify(strata, cells, &found);
    if (status) return status;
    made->means[pixel * channels + c] = found.mean;
    if (made->standard_errors) made->standard_errors[pixel * channels + c] = found.standard_error;
    /* Those of the channel that has least: fmin passes over the NaN there was. */
    if (made->degrees) made->degrees[pixel] = fmin(made->degrees[pixel], found.degrees);
  }
  if (made->counts) made->counts[pixel] = self->samples;
  made->spent += self->samples;
  return ASC_OK;
}

static asc_status run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                      asc_estimates *made, asc_error *error) {
  const size_t pixels = (size_t)group->columns * group->rows, cells = cells_of(self);
  size_t block = MOST_AT_ONCE / cells;
  if (block > pixels) block = pixels;
  if (block == 0) block = 1;
  asc_draw *draws = malloc(block * cells * sizeof *draws);
  asc_tally *tallies = malloc(block * cells * self->channels * sizeof *tallies);
  asc_stratum *strata = malloc(cells * sizeof *strata);
  asc_status status = draws && tallies && strata ? ASC_OK : ASC_OUT_OF_MEMORY;
  if (status) (void)asc_fail(error, status, "out of memory");
  for (size_t first = 0; first < pixels && status == ASC_OK; first += block) {
    const size_t here = pixels - first < block ? pixels - first : block;
    for (size_t i = 0; i < here * cells; i++) {
      asc_tally *to = tallies + i * self->channels;
      for (uint32_t c = 0; c < self->channels; c++) to[c] = (asc_tally){0};
      draws[i] = draw_of(self, asc_pixel_of(group, first + i / cells), i % cells, to);
    }
    status = asc_take(self, group, draws, here * cells, integrand, context, error);
    for (size_t i = 0; i < here && status == ASC_OK; i++) {
      status = write_pixel(self, first + i, tallies + i * cells * self->channels, strata, made);
      const asc_pixel pixel = asc_pixel_of(group, first + i);
      if (status)
        (void)asc_fail(error, status, "stratified: in pixel (%d, %d): %s", pixel.x, pixel.y, asc_status_text(status));
    }
  }
  free(draws);
  free(tallies);
  free(strata);
  return status;
}

const asc_estimator_interface asc_estimator_stratified = {.name = "stratified",
                                                          .title = "as many samples in every cell of the pixel",
                                                          .source = "Cochran 1977, Sampling techniques, chapter 5",
                                                          .parameters = parameters,
                                                          .parameter_count = PARAMETERS,
                                                          .least_dimensions = 1,
                                                          .prepare = prepare,
                                                          .run = run};

#include "complaint.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#define CHUNK 1024 /* samples that are looked at together */

/* The first of a chunk's samples that has a coordinate outside [0, 1) or a weight that is no number, or ASC_OK. */
static asc_status look(const asc_sampler *sampler, const asc_sampler_desc *of, const asc_range *range, double *points,
                       asc_error *error) {
  const asc_status status = asc_sampler_fill(sampler, range, points);
  if (status != ASC_OK && status != ASC_OUT_OF_RANGE)
    return asc_fail(error, status, "the sampler %s failed in pixel (%d, %d): %s", of->spec, range->pixel_x,
                    range->pixel_y, asc_status_text(status));
  for (size_t i = 0; status && i < range->sample_count * of->dimensions; i++)
    if (!(points[i] >= 0.0 && points[i] < 1.0))
      return asc_fail(error, status,
                      "the sampler %s gave a value outside [0, 1): %g as number %zu of sample %" PRIu64
                      " of pixel (%d, %d)",
                      of->spec, points[i], i % of->dimensions, range->first_sample + i / of->dimensions, range->pixel_x,
                      range->pixel_y);
  return ASC_OK;
}

static asc_status look_at_weights(const asc_sampler *sampler, const asc_sampler_desc *of, asc_error *error) {
  double weights[CHUNK];
  for (uint64_t first = 0; first < of->samples; first += CHUNK) {
    const size_t count = of->samples - first < CHUNK ? (size_t)(of->samples - first) : CHUNK;
    const asc_status status = asc_sampler_weights(sampler, first, count, weights);
    for (size_t i = 0; status == ASC_NUMERIC && i < count; i++)
      if (!isfinite(weights[i]))
        return asc_fail(error, status, "the sampler %s gives sample %" PRIu64 " the weight %g", of->spec, first + i,
                        weights[i]);
  }
  return ASC_OK;
}

asc_status complain_of_sampler(const asc_sampler *sampler, complaint_area area, asc_status status, asc_error *error) {
  asc_sampler_desc of;
  double *points = NULL;
  if (!asc_sampler_resolved(sampler, &of)) points = malloc(sizeof *points * CHUNK * of.dimensions);
  if (!points) return asc_fail(error, status, "the sampler failed: %s", asc_status_text(status));
  asc_status found = look_at_weights(sampler, &of, error);
  const int32_t border = (int32_t)area.border;
  for (int32_t y = -border; !found && y < (int32_t)area.height + border; y++)
    for (int32_t x = -border; !found && x < (int32_t)area.width + border; x++)
      for (uint64_t first = 0; !found && first < of.samples; first += CHUNK) {
        const size_t count = of.samples - first < CHUNK ? (size_t)(of.samples - first) : CHUNK;
        found = look(sampler, &of, &(asc_range){x, y, first, count, 0, of.dimensions}, points, error);
      }
  free(points);
  return found ? status : asc_fail(error, status, "the sampler %s failed: %s", of.spec, asc_status_text(status));
}

asc_status complain_of_pixels(const float *pixels, complaint_area area, asc_error *error) {
  const size_t count = (size_t)3 * area.width * area.height;
  for (size_t i = 0; i < count; i++)
    if (!isfinite(pixels[i]))
      return asc_fail(error, ASC_NUMERIC, "pixel (%zu, %zu) is not finite: a colour is too large for float",
                      i / 3 % area.width, i / 3 / area.width);
  return ASC_OK;
}

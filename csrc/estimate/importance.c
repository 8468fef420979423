/* Importance sampling, as an integrand about an integrand. */
#include <math.h>
#include <stdlib.h>

#include "aliascope/estimate.h"

static asc_status divided(const asc_importance *by, size_t count, const asc_pixel *pixels, const double *u,
                          double *points, double *pdf, double *values) {
  asc_status status = by->warp(by->warp_context, count, u, points, pdf);
  if (status == ASC_OK) status = by->integrand(by->context, count, pixels, points, values);
  for (size_t i = 0; i < count && status == ASC_OK; i++) {
    if (!(pdf[i] >= 0.0) || isinf(pdf[i])) return ASC_NUMERIC;
    for (uint32_t c = 0; c < by->channels; c++) {
      double *value = &values[i * by->channels + c];
      *value = pdf[i] > 0.0 ? *value / pdf[i] : 0.0;
    }
  }
  return status;
}

asc_status asc_importance_values(void *importance, size_t count, const asc_pixel *pixels, const double *u,
                                 double *values) {
  const asc_importance *by = importance;
  if (!by || !by->warp || !by->integrand || !by->point_dimensions || !by->channels) return ASC_INVALID_ARGUMENT;
  if (count == 0) return ASC_OK;
  double *points = malloc(count * by->point_dimensions * sizeof *points), *pdf = malloc(count * sizeof *pdf);
  const asc_status status = points && pdf ? divided(by, count, pixels, u, points, pdf, values) : ASC_OUT_OF_MEMORY;
  free(points);
  free(pdf);
  return status;
}

asc_status asc_density_warping(const void *density, size_t count, const double *u, double *points, double *pdf) {
  const asc_status status = asc_density_sample(density, u, count, points);
  return status ? status : asc_density_pdf(density, points, count, pdf);
}

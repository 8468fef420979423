/* What the files of weightings share. Each is one asc_weighting_interface; uneven.c lists them, checks what they get
 * and makes the sum of what they give 1. */
#ifndef ASC_WEIGHTING_H
#define ASC_WEIGHTING_H

#include "aliascope/uneven.h"

/* Samples that were checked: finite, within `radius` of the centre in x and in y. */
typedef struct asc_samples {
  const asc_filter *filter; /* NULL: a constant within the radius */
  double radius;
  const double *points; /* [count][2] */
  size_t count;
} asc_samples;

typedef struct asc_weighting_interface {
  const char *name;   /* kebab-case */
  const char *title;  /* the definition in a few words */
  const char *source; /* the publication */
  const asc_parameter *parameters;
  size_t parameter_count;
  const char *filter; /* as in asc_weighting_info */
  double radius;      /* where no filter is given */
  /* Writes the weights times any constant; a weight is computed from the samples as a set. `values` has one entry a
   * parameter. */
  asc_status (*weigh)(const asc_samples *samples, const double *values, double *weights);
} asc_weighting_interface;

/* Writes the filter's values at the samples. ASC_OUT_OF_MEMORY. */
asc_status asc_filter_at_samples(const asc_samples *samples, double *values);

#endif

/* Reconstruction filters.
 *
 * A filter is immutable once made and may be used from any number of threads. It is given by a profile in one
 * dimension, x in pixels from its centre, that is even and has the integral 1; the filter of a picture is the product
 * of the profile along x and along y. A profile is zero past its radius: for x < -radius and for x >= radius, half open
 * as pixels are.
 */
#ifndef ASC_FILTER_H
#define ASC_FILTER_H

#include "aliascope/base.h"
#include "aliascope/sampler.h"

typedef struct asc_filter asc_filter;

typedef struct asc_filter_desc {
  size_t struct_size; /* sizeof(asc_filter_desc) */
  const char *spec;   /* "name" or "name:key=value,key=value", such as "mitchell:b=0,c=0.75" */
} asc_filter_desc;

/* Makes a filter. ASC_UNKNOWN_NAME, ASC_UNKNOWN_KEY (the message lists near misses), ASC_INVALID_VALUE. */
ASC_API asc_status asc_filter_create(const asc_filter_desc *desc, asc_filter **filter, asc_error *error);
ASC_API void asc_filter_destroy(asc_filter *filter);

/* The resolved desc: `spec` in canonical form (keys sorted, defaults left out). The string lives as long as the
 * filter. */
ASC_API asc_status asc_filter_resolved(const asc_filter *filter, asc_filter_desc *desc);

/* In pixels, from ASC_FILTER_RADIUS_LEAST to ASC_FILTER_RADIUS_MOST. */
#define ASC_FILTER_RADIUS_LEAST 0.5
#define ASC_FILTER_RADIUS_MOST 8
ASC_API double asc_filter_radius(const asc_filter *filter);

/* Writes the profile at n positions. At one that is not a number it is zero. */
ASC_API asc_status asc_filter_evaluate(const asc_filter *filter, const double *x, size_t n, double *values);

/* The profile's integral from a to b, either of which may be infinite, within 1e-14; negative where b < a.
 * ASC_INVALID_ARGUMENT where one is not a number. */
ASC_API asc_status asc_filter_integral(const asc_filter *filter, double a, double b, double *integral);

/* The profile's Fourier transform, the integral of profile(x) cos(2 pi frequency x), at n frequencies in cycles a
 * pixel, within 1e-12. ASC_INVALID_ARGUMENT beyond ASC_FILTER_FREQUENCY_MOST either way: its time grows with the
 * frequency. */
#define ASC_FILTER_FREQUENCY_MOST 1000
ASC_API asc_status asc_filter_response(const asc_filter *filter, const double *frequencies, size_t n, double *response);

/* What is registered, for lists and help. Strings live as long as the library. */
typedef struct asc_filter_info {
  const char *name, *title, *source;
  const asc_parameter *parameters;
  size_t parameter_count;
} asc_filter_info;

ASC_API size_t asc_filter_count(void);
ASC_API asc_status asc_filter_describe(size_t index, asc_filter_info *info);

#endif

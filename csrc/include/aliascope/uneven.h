/* Filtering of unevenly spread samples: weights that make up for their density.
 *
 * The plain average of samples that are crowded on one side of an edge, as an adaptive sampler leaves them, leans to
 * that side. A method of weighting is named by a spec, "name" or "name:key=value,key=value". Every function is pure and
 * may be called from any thread.
 */
#ifndef ASC_UNEVEN_H
#define ASC_UNEVEN_H

#include "aliascope/base.h"
#include "aliascope/filter.h"
#include "aliascope/sampler.h"

#define ASC_UNEVEN_MOST 16777216 /* samples of one call, 2^24 */

typedef struct asc_uneven_desc {
  size_t struct_size;       /* sizeof(asc_uneven_desc) */
  const char *spec;         /* the method: "area" */
  const asc_filter *filter; /* NULL: the box over the pixel; of multi-stage its own filter */
  const double *points;     /* [count][2]: x and y in pixels from the pixel's centre */
  size_t count;             /* 1 to ASC_UNEVEN_MOST */
} asc_uneven_desc;

/* Writes `count` weights of sum 1: the filtered value is the sum of weight times value. They are negative where the
 * filter is. The filter's support is closed here: on its border it has the value next to it. Samples at the same place
 * get the same weight, and another order of the samples gives the same weights in that order.
 *
 * ASC_UNKNOWN_NAME, ASC_UNKNOWN_KEY, ASC_INVALID_VALUE of the spec; ASC_INVALID_ARGUMENT for no samples, or one that is
 * not finite or not within the filter's radius of the centre, in x and in y; ASC_UNSUPPORTED for a filter that the
 * method does not take; ASC_NUMERIC where the filter is zero at all samples, or its negative parts outweigh the others;
 * ASC_OUT_OF_MEMORY. */
ASC_API asc_status asc_uneven_weights(const asc_uneven_desc *desc, double *weights, asc_error *error);

/* Writes the areas of the Voronoi cells of n points (x, y), clipped to bounds = {left, bottom, right, top}, which hold
 * them; points at the same place share their cell in equal parts. Places are read to 2^-51 of half the longer side.
 * Takes time n log n; n^2 at worst, where one cell borders on most others and mostly outside the bounds.
 * ASC_INVALID_ARGUMENT for no points or more than ASC_UNEVEN_MOST, one outside, or bounds without area or not finite;
 * ASC_OUT_OF_MEMORY. */
ASC_API asc_status asc_voronoi_areas(const double *points, size_t n, const double bounds[4], double *areas,
                                     asc_error *error);

/* What is registered, for lists and help. Strings live as long as the library. */
typedef struct asc_weighting_info {
  const char *name, *title, *source;
  const asc_parameter *parameters;
  size_t parameter_count;
  const char *filter; /* the name of the only filter that it takes; NULL: it takes any */
} asc_weighting_info;

ASC_API size_t asc_weighting_count(void);
ASC_API asc_status asc_weighting_describe(size_t index, asc_weighting_info *info);

/* The canonical form of a spec: keys sorted, defaults left out. `capacity` bytes with the NUL. */
ASC_API asc_status asc_weighting_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error);

#endif

/* Discrepancies of point sets, and what else a set is judged by.
 *
 * A measure is named by a spec, "name" or "name:key=value,key=value". Points are double, row-major [point][dimension],
 * in the closed unit cube; n(A) counts those in A, N is their number, vol(A) the volume of A within the cube. Every
 * function is pure and may be called from any thread.
 */
#ifndef ASC_DISCREPANCY_H
#define ASC_DISCREPANCY_H

#include "aliascope/base.h"
#include "aliascope/sampler.h"

typedef struct asc_discrepancy_desc {
  size_t struct_size; /* sizeof(asc_discrepancy_desc) */
  const char *spec;
  const double *points;
  size_t count;        /* N, at least 1 */
  uint32_t dimensions; /* at least 1 */
  uint64_t seed;       /* of measures that draw at random */
} asc_discrepancy_desc;

typedef enum asc_certainty {
  ASC_EXACT = 0,    /* but for rounding: lower = value = upper */
  ASC_BOUNDS = 1,   /* lower <= the measure <= upper, and value one of the two, as the measure says */
  ASC_ESTIMATED = 2 /* a mean over random draws, with its standard error */
} asc_certainty;

/* What a measure came to. `witness` is where an extreme is met: the corners of a box (lower, then upper), the edge
 * a x + b y + c = 0 as a, b, c, the centre and radius of a disc; as `title` of the measure says. */
#define ASC_WITNESS_MOST 8
typedef struct asc_measurement {
  size_t struct_size; /* sizeof(asc_measurement) */
  double value, lower, upper, standard_error;
  asc_certainty certainty;
  uint32_t witness_count;
  double witness[8];
  uint32_t closed; /* 1: the extreme is met with the border's points counted in */
} asc_measurement;

/* Measures a point set. ASC_UNKNOWN_NAME, ASC_UNKNOWN_KEY, ASC_INVALID_VALUE of the spec; ASC_INVALID_ARGUMENT for no
 * points, or a value that is not in [0, 1]; ASC_UNSUPPORTED for a dimension or count that the measure does not do. */
ASC_API asc_status asc_discrepancy(const asc_discrepancy_desc *desc, asc_measurement *made, asc_error *error);

/* What is registered, for lists and help. Strings live as long as the library. */
typedef struct asc_measure_info {
  const char *name, *title, *source;
  const asc_parameter *parameters;
  size_t parameter_count;
  uint32_t least_dimensions, most_dimensions;
  uint64_t quick_points; /* up to so many points it takes about a second at most, in two dimensions */
} asc_measure_info;

ASC_API size_t asc_measure_count(void);
ASC_API asc_status asc_measure_describe(size_t index, asc_measure_info *info);

/* The canonical form of a spec: keys sorted, defaults left out. `capacity` bytes with the NUL. */
ASC_API asc_status asc_measure_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error);

#endif

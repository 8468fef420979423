/* What the files of measures share. Each measure is one asc_measure_interface; registry.c lists them. */
#ifndef ASC_MEASURE_H
#define ASC_MEASURE_H

#include "aliascope/discrepancy.h"

#define ASC_ANY_DIMENSION UINT32_MAX

/* What is measured: checked, every value in [0, 1]. */
typedef struct asc_point_set {
  const double *points;
  size_t count;
  uint32_t dimensions;
  uint64_t seed;
} asc_point_set;

typedef struct asc_measure_interface {
  const char *name;   /* kebab-case */
  const char *title;  /* the definition in a few words */
  const char *source; /* the publication */
  const asc_parameter *parameters;
  size_t parameter_count;
  uint32_t least_dimensions, most_dimensions;
  uint64_t quick_points; /* as in asc_measure_info */
  /* Writes value, bounds, certainty and witness into `made`, which is exact, 0, without witness before. `values` has
   * one entry a parameter. */
  asc_status (*evaluate)(const asc_point_set *set, const double *values, asc_measurement *made, asc_error *error);
} asc_measure_interface;

/* An exact result without a witness. */
static inline void asc_measured(asc_measurement *made, double value) {
  made->value = made->lower = made->upper = value;
}

#endif

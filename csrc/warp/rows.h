/* What the files of warps share: a function of one row, applied to many. */
#ifndef ASC_ROWS_H
#define ASC_ROWS_H

#include "aliascope/warp.h"

#define ASC_PI 3.14159265358979323846

/* How far the length of a direction, a radius or a sum of barycentrics may be off by rounding: those in float are
 * taken too. */
#define ASC_ROUNDING 1e-6

/* One row to another; 0 where it is outside the domain or not a number. */
typedef int (*asc_row_function)(const double *from, double *to);

static inline asc_status asc_rows(asc_row_function row, const double *from, size_t from_columns, size_t n, double *to,
                                  size_t to_columns) {
  if (n > 0 && (!from || !to)) return ASC_INVALID_ARGUMENT;
  for (size_t i = 0; i < n; i++)
    if (!row(from + i * from_columns, to + i * to_columns)) return ASC_INVALID_ARGUMENT;
  return ASC_OK;
}

static inline int asc_in_unit(double x) { return x >= 0.0 && x <= 1.0; }

static inline double asc_limited(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

static inline int asc_is_direction(const double *w) {
  const double squared = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
  return squared >= 1.0 - 2.0 * ASC_ROUNDING && squared <= 1.0 + 2.0 * ASC_ROUNDING;
}

#endif

/* A table of a filter's integral from 0, for those who need it at very many places. */
#ifndef ASC_PRIMITIVE_H
#define ASC_PRIMITIVE_H

#include "aliascope/filter.h"

/* Where the profile is smooth from one knot to the next: every multiple of asc_filter_knot_spacing. */
double asc_filter_knot_spacing(const asc_filter *filter);

/* At each node its integral and its value times the spacing of the nodes, from 0 to the radius. */
typedef struct asc_primitive_table {
  double *nodes; /* [count + 1][2] */
  uint32_t count;
  double radius, per_unit; /* nodes in a pixel */
} asc_primitive_table;

/* ASC_OUT_OF_MEMORY. */
asc_status asc_primitive_table_create(const asc_filter *filter, asc_primitive_table *made);
void asc_primitive_table_destroy(asc_primitive_table *made);

/* The one that a filter was made with. */
const asc_primitive_table *asc_filter_table(const asc_filter *filter);

/* The integral from 0 to x, |x| <= radius, within 1e-9: cubic between the nodes. */
static inline double asc_primitive_at(const asc_primitive_table *table, double x) {
  const double place = (x < 0.0 ? -x : x) * table->per_unit;
  const uint32_t below = place < table->count ? (uint32_t)place : table->count - 1;
  const double t = place - below, *a = table->nodes + 2 * (size_t)below, *b = a + 2;
  const double rise = b[0] - a[0];
  const double integral = a[0] + t * (a[1] + t * ((3.0 * rise - 2.0 * a[1] - b[1]) + t * (a[1] + b[1] - 2.0 * rise)));
  return x < 0.0 ? -integral : integral;
}

#endif

/* A set's points in the order of one of their coordinates. */
#ifndef ASC_COORDINATES_H
#define ASC_COORDINATES_H

#include "measure.h"

typedef struct asc_coordinate {
  double value;
  uint32_t point;
} asc_coordinate;

/* Fills sorted[count] with the coordinates in one dimension, rising, of equal ones the first point first: in one order
 * whatever the library's qsort. For up to 2^32 points. */
void asc_sort_coordinates(const asc_point_set *set, uint32_t dimension, asc_coordinate *sorted);

#endif

#include "coordinates.h"

#include <stdlib.h>

static int by_value(const void *a, const void *b) {
  const asc_coordinate *p = a, *q = b;
  return p->value != q->value ? (p->value > q->value) - (p->value < q->value)
                              : (p->point > q->point) - (p->point < q->point);
}

void asc_sort_coordinates(const asc_point_set *set, uint32_t dimension, asc_coordinate *sorted) {
  for (size_t i = 0; i < set->count; i++)
    sorted[i] = (asc_coordinate){set->points[i * set->dimensions + dimension], (uint32_t)i};
  qsort(sorted, set->count, sizeof *sorted, by_value);
}

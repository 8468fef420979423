/* Exact answers about places on a grid of integers: what a triangulation decides by. */
#ifndef ASC_PREDICATES_H
#define ASC_PREDICATES_H

#include <stdint.h>

/* Coordinates lie in [-ASC_PLACE_MOST, ASC_PLACE_MOST]: then a difference is a double without rounding, and nothing
 * below leaves 256 bits. */
#define ASC_PLACE_MOST ((int64_t)1 << 51)

typedef struct asc_place {
  int64_t x, y;
} asc_place;

/* 1 where a, b, c turn counterclockwise, -1 clockwise, 0 where they lie on a line. */
int asc_orientation(asc_place a, asc_place b, asc_place c);

/* For a, b, c counterclockwise: 1 where d lies inside the circle through them, -1 outside, 0 on it. */
int asc_in_circle(asc_place a, asc_place b, asc_place c, asc_place d);

#endif

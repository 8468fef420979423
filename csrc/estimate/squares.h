/* The squares that whitted.c divides pixels into, and the points of the lattice that are their corners. */
#ifndef ASC_SQUARES_H
#define ASC_SQUARES_H

#include "estimator.h"

#define ASC_SQUARES_DEPTH_MOST 10

typedef struct asc_square {
  uint32_t pixel;
  uint32_t x, y; /* of its upper left corner, in steps of the lattice from the pixel's */
  uint32_t level;
  uint32_t corners[4]; /* numbers of points: upper left, upper right, lower left, lower right */
  int divided;
} asc_square;

/* A table from numbers to values: open addressing, at most half full. */
typedef struct asc_point_table {
  uint64_t *keys; /* plus 1; 0: free */
  uint32_t *found;
  size_t capacity, count;
} asc_point_table;

typedef struct asc_squares {
  const asc_estimator *self;
  asc_group group;
  asc_group area; /* the group's pixels, and those around it whose first points are looked at */
  uint32_t ring;
  uint32_t depth; /* the lattice has 2^depth steps a pixel */
  asc_square *squares;
  uint32_t count, capacity;
  asc_point_table own;    /* (pixel, x, y): which points a pixel uses */
  asc_point_table shared; /* points on the borders of pixels, by their place in the group */
  struct asc_squares_wish {
    uint32_t pixel, x, y;
  } * points;     /* all points, in the order in which they were asked for */
  double *values; /* [point][channel] */
  uint32_t point_count, point_capacity, taken;
  uint64_t *spent; /* [pixel], the points that it uses */
} asc_squares;

asc_status asc_squares_make(asc_squares *made, const asc_estimator *self, const asc_group *group, uint32_t ring,
                            uint32_t depth);
void asc_squares_free(asc_squares *made);

/* A pixel as one square. */
asc_status asc_squares_add_pixel(asc_squares *to, uint32_t pixel);

/* The points of a pixel that is divided `start` times, for those around it. */
asc_status asc_squares_add_points(asc_squares *to, uint32_t pixel, uint32_t start);

/* The values at a point of the lattice, from a pixel's upper left corner, that the pixel it lies in uses. */
const double *asc_squares_around(const asc_squares *of, uint32_t pixel, int64_t x, int64_t y);

/* Four squares in the place of one, unless the points that the pixel then uses are more than `most`. */
asc_status asc_squares_divide(asc_squares *of, uint32_t square, uint64_t most);

/* Takes the samples of all new points. */
asc_status asc_squares_take(asc_squares *of, asc_integrand integrand, void *context, uint64_t *spent, asc_error *error);

/* The values at a corner. */
const double *asc_squares_corner(const asc_squares *of, const asc_square *square, int corner);

/* Those at the upper left corner of a pixel. */
const double *asc_squares_origin(const asc_squares *of, uint32_t pixel);

/* Which sample of its pixel a point of the lattice is. */
uint64_t asc_squares_index(const asc_squares *of, uint32_t x, uint32_t y);

#endif

/* Patterns of the plane, made whole, in any number of dimensions: padded, that is an independent pattern for each pair
 * of dimensions (0,1), (2,3), ..., the pairs shuffled against each other. A last dimension without a partner has the
 * first coordinate of a pattern of its own. */
#ifndef ASC_PLANAR_H
#define ASC_PLANAR_H

#include "pattern.h"

/* Writes all points of one pair of dimensions of one pixel, in [0, 1); `key` is the pixel's. */
typedef asc_status (*asc_plane_function)(const void *state, asc_key key, uint32_t pair, double (*points)[2]);

/* Answers a range of a pattern of `samples` points by making its planes whole. ASC_OUT_OF_MEMORY. */
asc_status asc_planar_fill(const void *state, uint64_t samples, uint64_t seed, asc_plane_function plane,
                           const asc_range *range, double *points);

#endif

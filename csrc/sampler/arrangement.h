/* Samplers whose points are made of another's by groups of dimensions; sampler.h has what they are. */
#ifndef ASC_ARRANGEMENT_H
#define ASC_ARRANGEMENT_H

#include "made.h"
#include "pattern.h"

#define ASC_DECORRELATED_MOST                                                                                          \
  ((uint64_t)1 << 14) /* samples: a pixel's whole pattern is sorted at each call of fill                               \
                       */

/* A group: `size` dimensions from `first` on, which are the first ones of `pattern`. */
typedef struct asc_arranged_group {
  asc_sampler *pattern;
  uint32_t first, size;
} asc_arranged_group;

typedef struct asc_arranged {
  asc_arrangement_desc desc; /* resolved; `spec` is the sampler's, `groups` is `sizes` */
  uint32_t *sizes;           /* as they were asked for: the first group may hold the first two of them */
  uint64_t shuffling_mix;    /* of the seed of all that is drawn here */
  size_t count;
  asc_arranged_group groups[];
} asc_arranged;

/* The key of what is drawn for one pixel. */
static inline asc_key asc_arranged_key(const asc_arranged *of, const asc_range *range) {
  return asc_pixel_key(of->shuffling_mix, range->pixel_x, range->pixel_y);
}

/* The dimensions of a group that a range asks for, from its own first: 0 where it asks for none. `column` is the first
 * of them in the range's rows. */
typedef struct asc_columns {
  uint32_t first, count, column;
} asc_columns;

asc_columns asc_columns_of(const asc_arranged_group *group, const asc_range *range);

/* For `fill` of the interface, of an asc_arranged. */
asc_status asc_decorrelated_fill(const void *arranged, const asc_range *range, double *points);

#endif

/* The samples of a group's pixels while they are decided, and the cells that they lie in. */
#ifndef ASC_FIELD_H
#define ASC_FIELD_H

#include "cells.h"

#define ASC_FIELD_NONE UINT32_MAX

typedef struct asc_cell {
  double x, y, side; /* in its pixel */
  uint32_t count;    /* its samples: those of a cell that was split into it too */
  uint32_t pixel;
  uint32_t next;       /* cell of the same pixel */
  uint32_t parts;      /* cells each way that stand in its place; 0: it is whole */
  uint32_t first_part; /* of these, row by row */
  uint32_t level;
  int decided;
} asc_cell;

typedef struct asc_field_sample {
  double x, y; /* in its pixel */
  uint32_t cell;
  uint32_t next; /* sample of the same pixel */
} asc_field_sample;

typedef struct asc_field_pixel {
  uint32_t first_cell, last_cell, first_sample, last_sample;
  uint64_t index; /* of the next sample of its sequence */
  uint64_t spent;
} asc_field_pixel;

/* Growing arrays. */
typedef struct asc_field {
  const asc_estimator *self;
  const asc_cells *how;
  asc_group group;
  asc_group area; /* the group's pixels, and those around it that the criterion looks at */
  uint32_t reach;
  int keeps; /* samples, one by one: else their tallies alone */
  asc_field_pixel *pixels;
  asc_cell *cells;
  asc_tally *tallies; /* [cell][channel] */
  uint32_t cell_count, cell_capacity;
  asc_field_sample *samples;
  double *values; /* [sample][channel] */
  uint32_t sample_count, sample_capacity;
  /* Samples that are to be taken. */
  asc_pixel *wished_pixels;
  double *wished_points;
  uint32_t *wished_cells;
  uint32_t wish_count, wish_capacity;
  asc_error failure; /* of asc_field_wish, where there is more to be said than its status */
  int asked;         /* since the last time that samples were taken, though none may have fallen in an open cell */
} asc_field;

asc_status asc_field_make(asc_field *made, const asc_estimator *self, const asc_cells *how, const asc_group *group);
void asc_field_free(asc_field *made);

/* A new cell of a pixel; ASC_OUT_OF_MEMORY. */
asc_status asc_field_add_cell(asc_field *to, uint32_t pixel, double x, double y, double side, uint32_t level);

/* Asks for the samples of the pixel's sequence before `end`, as far as they fall in cells that are open, until the
 * pixel has `most`. */
asc_status asc_field_wish(asc_field *of, uint32_t pixel, uint64_t end, uint64_t most);

/* Takes the samples that were asked for. */
asc_status asc_field_take(asc_field *of, asc_integrand integrand, void *context, uint64_t *spent, asc_error *error);

/* parts x parts cells in the place of one, among which its samples are divided. */
asc_status asc_field_divide(asc_field *of, uint32_t cell, uint32_t parts);

/* Whether each of parts x parts cells would have a sample. At most 4 x 4. */
int asc_field_all_meet(const asc_field *of, uint32_t cell, uint32_t parts);

#endif

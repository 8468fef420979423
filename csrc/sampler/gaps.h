/* What discs around points leave free of the square: a list of small squares that together hold all of it, all of one
 * size, so that a uniform place in one of them, drawn again while it is inside a disc, is uniform in what is free.
 *
 * Source: Ebeida, Mitchell, Patney, Davidson, Owens 2012, "A simple algorithm for maximal Poisson-disk sampling in high
 * dimensions": squares are quartered, and quarters inside a single disc dropped. */
#ifndef ASC_GAPS_H
#define ASC_GAPS_H

#include "aliascope/base.h"
#include "stream.h"

typedef struct asc_gaps_square {
  uint32_t x, y;
} asc_gaps_square;

/* The points stand in a grid whose cells are so small, a diagonal of the radius at most, that each holds one. Around it
 * is a border, at least a radius wide; in it the points of the torus stand again, moved by its periods. */
typedef struct asc_gaps {
  double radius, squared_radius;
  int toroidal;
  uint32_t side, stride, reach; /* cells along an edge; with the border; as far as a radius goes */
  double (*centre)[2];
  uint32_t level; /* how often the squares were quartered; before, they are cells of the grid */
  size_t count, capacity;
  asc_gaps_square *open, *next;
} asc_gaps;

/* Discs of a radius, from 0 to 1.08, around points of which no two are closer than it. The list starts with the cells
 * that hold no point. ASC_OUT_OF_MEMORY; then there is nothing to end. */
asc_status asc_gaps_begin(asc_gaps *gaps, double radius, int toroidal, const double (*points)[2], size_t count);
void asc_gaps_end(asc_gaps *gaps);

/* Adds the disc of a point that no disc holds. The list is left as it is. */
void asc_gaps_add(asc_gaps *gaps, const double point[2]);

/* A uniform place in the squares of the list, which is not empty; which of them it is in. */
size_t asc_gaps_draw(const asc_gaps *gaps, asc_stream *stream, double place[2]);

/* The squared distance of a place in square k from the nearest point, as far as `reach` cells; any that is not above
 * `enough` where there is one. */
double asc_gaps_nearest(const asc_gaps *gaps, size_t k, const double place[2], double enough);

/* Takes square k from the list: it is inside a disc. The last one takes its number. */
void asc_gaps_drop(asc_gaps *gaps, size_t k);

/* Quarters all squares and keeps what no single disc covers. 0 where there is no room for that, in memory or between
 * numbers: then nothing is changed. */
int asc_gaps_quarter(asc_gaps *gaps);

#endif

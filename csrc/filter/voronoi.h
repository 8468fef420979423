/* The Voronoi cells of samples in a rectangle. */
#ifndef ASC_VORONOI_H
#define ASC_VORONOI_H

#include "delaunay.h"

/* Samples as sites on a grid of integers: of 2^52 to 2^53 steps over the longer side of the rectangle, its centre at 0.
 * Those in the same step are one site. Which sites are neighbours is found on the grid, the lines between them where
 * the samples are: of two that are close the grid would turn the line. Where cells would then not fill the rectangle,
 * as of samples within a few steps of each other, the lines are those of the grid too. */
typedef struct asc_voronoi {
  size_t count;      /* sites */
  asc_place *places; /* [site], by x, then y: what is computed from here on does not depend on the samples' order */
  struct asc_rest {
    double x, y;
  } * rests;            /* [site] how far, in steps, the sample is taken to be from the place: at most half a step */
  uint32_t *samples;    /* [site] how many are there */
  uint32_t *site;       /* [sample] */
  double step;          /* its length */
  double width, height; /* of half the rectangle, in steps */
  asc_delaunay mesh;
} asc_voronoi;

/* The rectangle as left, bottom, right, top. */
typedef struct asc_rectangle {
  double left, bottom, right, top;
} asc_rectangle;

/* `points` are [count][2], finite and in the closed rectangle, 1 to ASC_PLACES_MOST. ASC_OUT_OF_MEMORY. */
asc_status asc_voronoi_create(const double *points, size_t count, const asc_rectangle *bounds, asc_voronoi *made);
void asc_voronoi_destroy(asc_voronoi *made);

/* From one site to another, in steps. */
static inline struct asc_rest asc_voronoi_way(const asc_voronoi *diagram, uint32_t from, uint32_t to) {
  const asc_place a = diagram->places[from], b = diagram->places[to]; /* their difference is a double */
  return (struct asc_rest){(double)(b.x - a.x) + (diagram->rests[to].x - diagram->rests[from].x),
                           (double)(b.y - a.y) + (diagram->rests[to].y - diagram->rests[from].y)};
}

/* A corner of a cell, in steps from its site, and its neighbours around the cell. */
typedef struct asc_corner {
  double x, y;
  uint32_t next, before; /* counterclockwise, clockwise */
} asc_corner;

/* A convex polygon. */
typedef struct asc_cell {
  asc_corner *corners; /* room for those of any cell of one diagram */
  uint32_t used;
  uint32_t any; /* one of the polygon's corners; ASC_NONE where nothing is left */
} asc_cell;

asc_status asc_cell_create(const asc_voronoi *diagram, asc_cell *cell);
void asc_cell_destroy(asc_cell *cell);

/* The cell of a site, clipped to the rectangle: those places nearer to it than to any other. */
void asc_cell_of(const asc_voronoi *diagram, uint32_t site, asc_cell *cell);

/* In steps squared. */
double asc_cell_area(const asc_cell *cell);

#endif

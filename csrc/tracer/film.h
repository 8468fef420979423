/* Where samples are added up whose filter reaches past their own pixel.
 *
 * Every sample adds weight x radiance, and weight, to all pixels whose filter holds it; a pixel is the sum of the first
 * over the sum of the second. So that borders are no darker, pixels beyond the picture are sampled too, `reach` of them
 * each way.
 *
 * The weighted mean rather than the sum over N: it keeps a constant constant, and a sample count too low for the
 * filter's integral shows as noise in detail, not as noise everywhere. What it costs is a bias of order 1/N.
 *
 * The same bits for every number of threads and order of tiles: a tile of sampled pixels has cells of its own for all
 * pixels that it reaches, filled in the order of its samples; a pixel then adds up those tiles that reach it, from the
 * top, then from the left. The cells of a band of tile rows are held at a time, and of the row above it: 64 MiB, or two
 * rows of tiles where those are more (at most 4 KiB for each pixel of the picture's width).
 */
#ifndef TRACER_FILM_H
#define TRACER_FILM_H

#include "aliascope/filter.h"
#include "tracer.h"

#define FILM_TILE 16u /* sampled pixels a side: no pixel is reached by more than two tiles each way */
#define FILM_REACH_MOST 8
#define FILM_TAPS_MOST 16

typedef struct film_cell {
  double sum[4]; /* weight x radiance, weight */
} film_cell;

typedef struct film {
  const asc_filter *filter;
  double radius;
  int32_t reach;          /* how many pixels away a sample may count */
  uint32_t taps;          /* how many pixels, each way, hold a sample */
  uint32_t side;          /* cells of a tile, each way */
  uint32_t width, height; /* of the picture */
  uint32_t across, down;  /* tiles */
  uint32_t rows;          /* of tiles in a band */
  film_cell *cells;       /* [rows + 1][across][side][side]; row r of tiles in slot r % (rows + 1) */
} film;

/* ASC_OUT_OF_MEMORY. */
asc_status film_make(film *made, const asc_filter *filter, uint32_t width, uint32_t height);
void film_free(film *made);

/* The cells of a tile. Cell (0, 0) is the pixel `reach` up and left of the tile's first. */
film_cell *film_tile(const film *of, uint32_t column, uint32_t row);

/* A sample: its own pixel's cell, and where in that pixel it lies, in [0, 1). */
typedef struct film_sample {
  film_cell *cell;
  double x, y;
} film_sample;

/* Adds at most FILM_BATCH samples, in their order. */
#define FILM_BATCH 16
void film_add(const film *of, size_t count, const film_sample *samples, const double (*radiance)[3]);

/* One past the last row of pixels that are complete when rows [0, row) of tiles are. */
uint32_t film_complete(const film *of, uint32_t row);

/* Writes one row of pixels. ASC_NUMERIC where the weights of a pixel do not add up to something positive. */
asc_status film_write_row(const film *of, uint32_t y, float *pixels);

#endif

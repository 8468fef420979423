/* Where samples are added up whose filter reaches past their own pixel.
 *
 * Every sample adds weight x radiance, and weight, to all pixels whose filter holds it. So that borders are no darker,
 * pixels beyond the picture are sampled too, `reach` of them each way. With A the sum of the first over N, S that of
 * the second, and m the plain mean of the pixel's own samples, the pixel is
 *
 *   A + (1 - S) m,
 *
 * A with a control variate: S is 1 on average. Like the weighted mean A / S, from which it differs by (S - 1)(A - m) to
 * first order, it keeps a constant constant, has half the error that A alone has at N = 4 and 16 (measured on a zone
 * plate with an edge), and a bias of order 1/N. Unlike A / S it has a variance: with negative lobes and few samples S
 * comes near 0 or below (with N = 1 and lanczos in one pixel of 30 it is below 0.2).
 *
 * The same bits for every number of threads and order of tiles: a tile of sampled pixels has cells of its own for all
 * pixels that it reaches, filled in the order of its samples; a pixel then adds up those tiles that reach it, from the
 * top, then from the left. The cells of a band of tile rows are held at a time, and of the row above it: 64 MiB, or two
 * rows of tiles where those are more (at most 5 KiB for each pixel of the picture's width).
 */
#ifndef TRACER_FILM_H
#define TRACER_FILM_H

#include <math.h>

#include "aliascope/filter.h"
#include "tracer.h"

#define FILM_TILE 16u /* sampled pixels a side: no pixel is reached by more than two tiles each way */
#define FILM_REACH_MOST 8
#define FILM_TAPS_MOST 16

/* weight x radiance, weight. As a vector, of GCC and Clang, since loops over four are vectorised badly. */
typedef double film_cell __attribute__((vector_size(4 * sizeof(double))));
typedef float film_cell_single __attribute__((vector_size(4 * sizeof(float))));

typedef int32_t film_bits __attribute__((vector_size(4 * sizeof(int32_t))));

/* A sum of floats, and what it rounded away. */
typedef struct film_cell_compensated {
  film_cell_single sum, lost;
} film_cell_compensated;

/* Adds to a sum of two floats, which do not overlap (Dekker 1971, A floating-point technique for extending the
 * available precision, add2 with a plain number). What the addition loses is told without regard to which of the two is
 * larger (Knuth, The Art of Computer Programming, vol. 2, section 4.2.2, theorem B): with negative lobes and samples
 * that outshine the sum it may be either, for which Neumaier 1974 compares them. Unlike Neumaier's, whose losses have a
 * plain sum of their own, which stands still at 2^24 samples as much as that of floats does, losses go back into the
 * sum. Each addition is off by 2 u^2 of the sum so far at most, u = 2^-24. */
static inline void film_add_compensated(film_cell_compensated *into, film_cell_single value) {
  const film_cell_single before = into->sum, after = before + value, added = after - before;
  const film_cell_single rounded = ((before - (after - added)) + (value - added)) + into->lost;
  /* Past the largest float it is no number, nor is zero times that; the sum then stays infinite. */
  const film_cell_single lost = (film_cell_single)((film_bits)rounded & (rounded * 0.0F == (film_cell_single){0}));
  into->sum = after + lost;
  into->lost = lost - (into->sum - after);
}

/* Its value. */
static inline void film_read_compensated(const film_cell_compensated *of, film_cell *read) {
  for (int i = 0; i < 4; i++) (*read)[i] = (double)of->sum[i] + (isfinite(of->lost[i]) ? (double)of->lost[i] : 0.0);
}

typedef struct film {
  tracer_film kept; /* what its cells are: film_cell, film_cell_single or film_cell_compensated */
  const asc_filter *filter;
  double radius;
  uint64_t samples;       /* a pixel */
  int32_t reach;          /* how many pixels away a sample may count */
  uint32_t taps;          /* how many pixels, each way, hold a sample */
  uint32_t side;          /* cells of a tile, each way */
  uint32_t width, height; /* of the picture */
  uint32_t across, down;  /* tiles */
  uint32_t rows;          /* of tiles in a band */
  void *cells;            /* [rows + 1][across][tile's]; row r of tiles in slot r % (rows + 1) */
} film;

/* ASC_OUT_OF_MEMORY. */
asc_status film_make(film *made, tracer_film kept, const asc_filter *filter, uint32_t width, uint32_t height,
                     uint64_t samples);
void film_free(film *made);

/* The pixels of a tile that are sampled: [x, x + columns) x [y, y + rows). */
typedef struct film_tile {
  int32_t x, y;
  uint32_t columns, rows;
} film_tile;

/* Where a tile lies; sets its cells to 0. */
film_tile film_begin(const film *of, uint32_t column, uint32_t row);

/* The cells of one sampled pixel: weighted, those of other pixels around it, and its own plain sum. */
typedef struct film_pixel {
  void *weighted, *plain;
} film_pixel;

/* The cells of pixel (x, y) of a tile. */
film_pixel film_at(const film *of, uint32_t column, uint32_t row, uint32_t x, uint32_t y);

/* A sample: its own pixel's cells, where in that pixel it lies, in [0, 1), and N times its weight in the pattern. */
typedef struct film_sample {
  film_pixel pixel;
  double x, y, scale;
} film_sample;

/* Adds at most FILM_BATCH samples, in their order. */
#define FILM_BATCH 16
void film_add(const film *of, size_t count, const film_sample *samples, const double (*radiance)[4]);

/* One past the last row of pixels that are complete when rows [0, row) of tiles are. */
uint32_t film_complete(const film *of, uint32_t row);

/* Writes one row of pixels. */
void film_write_row(const film *of, uint32_t y, float *pixels);

#endif

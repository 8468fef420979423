/* Points are made a tile at a time: up to four dimensions, each as a column of ASC_LANES samples, which the compiler
 * vectorises; then they are written row by row. */
#ifndef ASC_TILE_H
#define ASC_TILE_H

#include <string.h>

#include "hash.h"
#include "vectorise.h"

#define ASC_TILE_COLUMNS 4

typedef struct asc_tile {
  double column[ASC_TILE_COLUMNS][ASC_LANES];
} asc_tile;

/* Up to four values of one point; the count cannot be seen as that of a memcpy, whose call would take longer. */
ASC_INLINE void asc_copy_few(const double *values, uint32_t count, double *copied) {
  if (count >= 2) memcpy(copied, values, 2 * sizeof *values);
  if (count == 4) memcpy(copied + 2, values + 2, 2 * sizeof *values);
  if (count % 2) copied[count - 1] = values[count - 1];
}

/* asc_draw_at of ASC_LANES samples, as two words each. */
ASC_INLINE void asc_draw_lanes(uint64_t start, uint64_t first, uint32_t high[ASC_LANES], uint32_t low[ASC_LANES]) {
  ASC_LANES_LOOP
  for (uint64_t i = 0; i < ASC_LANES; i++) {
    const uint64_t bits = asc_draw_at(start, first + i);
    high[i] = (uint32_t)(bits >> 32);
    low[i] = (uint32_t)bits;
  }
}

/* x[0], y[0], x[1], y[1], ... */
ASC_INLINE void asc_zip(const double *x, const double *y, size_t count, double *zipped) {
  for (size_t i = 0; i < count; i++) {
    zipped[2 * i] = x[i];
    zipped[2 * i + 1] = y[i];
  }
}

/* All rows of all four columns, one after the other: the columns zipped, and zipped again. */
ASC_INLINE void asc_tile_rows(const asc_tile *tile, double *rows) {
  double even[2 * ASC_LANES], odd[2 * ASC_LANES];
  asc_zip(tile->column[0], tile->column[2], ASC_LANES, even);
  asc_zip(tile->column[1], tile->column[3], ASC_LANES, odd);
  asc_zip(even, odd, sizeof even / sizeof *even, rows);
}

/* Writes rows [from, to) of columns [begin, end). Row `from` begins at `points`, the next `stride` further. */
ASC_INLINE void asc_tile_write(const asc_tile *tile, uint32_t begin, uint32_t end, uint32_t from, uint32_t to,
                               double *points, size_t stride) {
  const int whole = to - from == ASC_LANES && begin == 0;
  if (whole && end == 4 && stride == 4) {
    asc_tile_rows(tile, points);
  } else if (whole && end == 4) {
    double rows[4 * ASC_LANES];
    asc_tile_rows(tile, rows);
    for (size_t i = 0; i < ASC_LANES; i++) memcpy(points + i * stride, rows + 4 * i, 4 * sizeof *rows);
  } else if (whole && end == 2 && stride == 2) {
    asc_zip(tile->column[0], tile->column[1], ASC_LANES, points);
  } else {
    for (uint32_t i = from; i < to; i++, points += stride)
      for (size_t c = begin; c < end; c++) points[c - begin] = tile->column[c][i];
  }
}

#endif

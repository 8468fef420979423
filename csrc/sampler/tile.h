/* Points are made a tile at a time: up to four dimensions, each as a column of ASC_LANES samples, which the compiler
 * vectorises; then they are written row by row. */
#ifndef ASC_TILE_H
#define ASC_TILE_H

#include "hash.h"
#include "vectorise.h"

#define ASC_TILE_COLUMNS 4

typedef struct asc_tile {
  double column[ASC_TILE_COLUMNS][ASC_LANES];
} asc_tile;

/* All rows of the first `columns` columns; constants, when inlined, so that the loop is transposed in registers. */
ASC_INLINE void asc_tile_transpose(const asc_tile *tile, uint32_t columns, double *points, size_t stride) {
  for (size_t i = 0; i < ASC_LANES; i++)
    for (size_t c = 0; c < columns; c++) points[i * stride + c] = tile->column[c][i];
}

/* Writes rows [from, to) of columns [begin, end). Row `from` begins at `points`, the next `stride` further. */
ASC_INLINE void asc_tile_write(const asc_tile *tile, uint32_t begin, uint32_t end, uint32_t from, uint32_t to,
                               double *points, size_t stride) {
  const int whole = to - from == ASC_LANES && begin == 0;
  if (whole && end == 4 && stride == 4) {
    asc_tile_transpose(tile, 4, points, 4);
  } else if (whole && end == 4) {
    asc_tile_transpose(tile, 4, points, stride);
  } else if (whole && end == 2 && stride == 2) {
    asc_tile_transpose(tile, 2, points, 2);
  } else {
    for (uint32_t i = from; i < to; i++, points += stride)
      for (size_t c = begin; c < end; c++) points[c - begin] = tile->column[c][i];
  }
}

#endif

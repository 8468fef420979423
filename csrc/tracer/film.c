#include "film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vectorise.h"

#define BUDGET ((size_t)64 << 20) /* bytes */

static size_t cell_size(const film *of) {
  return of->kept == TRACER_FILM_FLOAT ? sizeof(film_cell_single) : sizeof(film_cell);
}

/* A tile has side x side cells for the pixels that it reaches, from `reach` left of and above its first, then as many
 * as it has pixels for their plain sums. */
static size_t tile_cells(const film *of) { return (size_t)of->side * of->side + (size_t)FILM_TILE * FILM_TILE; }

asc_status film_make(film *made, tracer_film kept, const asc_filter *filter, uint32_t width, uint32_t height,
                     uint64_t samples) {
  const double radius = asc_filter_radius(filter);
  const uint32_t reach = (uint32_t)ceil(radius + 0.5) - 1; /* the largest whole number below radius + 1/2 */
  *made = (film){.kept = kept,
                 .filter = filter,
                 .radius = radius,
                 .samples = samples,
                 .reach = (int32_t)reach,
                 .taps = (uint32_t)ceil(2.0 * radius),
                 .side = FILM_TILE + 2 * reach,
                 .width = width,
                 .height = height,
                 .across = (width + 2 * reach + FILM_TILE - 1) / FILM_TILE,
                 .down = (height + 2 * reach + FILM_TILE - 1) / FILM_TILE};
  const size_t row = made->across * tile_cells(made) * cell_size(made);
  const size_t fit = BUDGET / row;
  made->rows = fit < 2 ? 1 : fit > made->down ? made->down : (uint32_t)fit - 1;
  made->cells = aligned_alloc(sizeof(film_cell), (made->rows + (size_t)1) * row);
  return made->cells ? ASC_OK : ASC_OUT_OF_MEMORY;
}

void film_free(film *made) { free(made->cells); }

static void *cells_of(const film *of, uint32_t column, uint32_t row) {
  const size_t slot = row % (of->rows + 1);
  return (char *)of->cells + (slot * of->across + column) * tile_cells(of) * cell_size(of);
}

film_tile film_begin(const film *of, uint32_t column, uint32_t row) {
  memset(cells_of(of, column, row), 0, tile_cells(of) * cell_size(of));
  const uint32_t x = column * FILM_TILE, y = row * FILM_TILE; /* from `reach` left of and above the picture */
  const uint32_t right = of->width + 2 * (uint32_t)of->reach - x, bottom = of->height + 2 * (uint32_t)of->reach - y;
  return (film_tile){(int32_t)x - of->reach, (int32_t)y - of->reach, right < FILM_TILE ? right : FILM_TILE,
                     bottom < FILM_TILE ? bottom : FILM_TILE};
}

film_pixel film_at(const film *of, uint32_t column, uint32_t row, uint32_t x, uint32_t y) {
  char *cells = cells_of(of, column, row);
  const size_t side = of->side, reach = (size_t)of->reach, size = cell_size(of);
  return (film_pixel){cells + ((y + reach) * side + x + reach) * size,
                      cells + (side * side + (size_t)y * FILM_TILE + x) * size};
}

/* The first of the pixels, relative to the sample's own, that hold a sample at x in [0, 1); writes the sample's
 * distances from all their centres. The last is kept within reach: it may be one too many where 2 radius is not
 * whole. */
static inline int32_t positions_of(const film *of, double x, double *positions) {
  const double from = x - 0.5 - of->radius;
  const int32_t toward_zero = (int32_t)from;
  const int32_t least = toward_zero + (from >= toward_zero), most = of->reach + 1 - (int32_t)of->taps;
  const int32_t first = least < most ? least : most;
  for (uint32_t i = 0; i < of->taps; i++) positions[i] = x - 0.5 - (first + (int32_t)i);
  return first;
}

#define ADD(to, value) (*(to) += (value))

/* Adds each sample to its pixel's plain sum, and to the taps x taps cells that are `offset` from its pixel's. The cells
 * are of one type, what is added of another, of `real` numbers. */
#define DEFINE_SPLAT(splat, cell, term, real, add)                                                                     \
  ASC_VECTORISE                                                                                                        \
  static void splat(const film *of, size_t count, const film_sample *samples, const ptrdiff_t *offset,                 \
                    const double *weights, const film_cell *values) {                                                  \
    const uint32_t side = of->side, taps = of->taps;                                                                   \
    for (size_t k = 0; k < count; k++) {                                                                               \
      const double *along_x = weights + (size_t)2 * taps * k, *along_y = along_x + taps;                               \
      const term value = __builtin_convertvector(values[k], term);                                                     \
      cell *plain = samples[k].pixel.plain, *corner = (cell *)samples[k].pixel.weighted + offset[k];                   \
      add(plain, value);                                                                                               \
      for (uint32_t j = 0; j < taps; j++) {                                                                            \
        cell *row = corner + (size_t)j * side;                                                                         \
        for (uint32_t i = 0; i < taps; i++) add(row + i, (real)(along_x[i] * along_y[j]) * value);                     \
      }                                                                                                                \
    }                                                                                                                  \
  }
DEFINE_SPLAT(splat_double, film_cell, film_cell, double, ADD)
DEFINE_SPLAT(splat_single, film_cell_single, film_cell_single, float, ADD)
DEFINE_SPLAT(splat_compensated, film_cell_compensated, film_cell_single, float, film_add_compensated)

void film_add(const film *of, size_t count, const film_sample *samples, const double (*radiance)[4]) {
  double positions[FILM_BATCH * 2 * FILM_TAPS_MOST] = {0.0}, weights[FILM_BATCH * 2 * FILM_TAPS_MOST];
  ptrdiff_t offset[FILM_BATCH];
  film_cell values[FILM_BATCH];
  const size_t taps = of->taps;
  for (size_t k = 0; k < count; k++) {
    const int32_t x = positions_of(of, samples[k].x, positions + 2 * taps * k);
    const int32_t y = positions_of(of, samples[k].y, positions + 2 * taps * k + taps);
    offset[k] = (ptrdiff_t)y * of->side + x;
    values[k] = samples[k].scale * (film_cell){radiance[k][0], radiance[k][1], radiance[k][2], 1.0};
  }
  (void)asc_filter_evaluate(of->filter, positions, 2 * taps * count, weights);
  if (of->kept == TRACER_FILM_FLOAT)
    splat_single(of, count, samples, offset, weights, values);
  else if (of->kept == TRACER_FILM_COMPENSATED)
    splat_compensated(of, count, samples, offset, weights, values);
  else
    splat_double(of, count, samples, offset, weights, values);
}

uint32_t film_complete(const film *of, uint32_t row) {
  if (row >= of->down) return of->height;
  const uint32_t sampled = row * FILM_TILE, reach = (uint32_t)of->reach; /* from `reach` above the picture */
  return sampled < 2 * reach ? 0 : sampled - 2 * reach;
}

/* (By pointer: without AVX there is no calling convention for four doubles.) */
static inline void read_cell(const film *of, const void *cells, size_t index, film_cell *read) {
  if (of->kept == TRACER_FILM_FLOAT)
    *read = __builtin_convertvector(((const film_cell_single *)cells)[index], film_cell);
  else if (of->kept == TRACER_FILM_COMPENSATED)
    film_read_compensated((const film_cell_compensated *)cells + index, read);
  else
    *read = ((const film_cell *)cells)[index];
}

void film_write_row(const film *of, uint32_t y, float *pixels) {
  const uint32_t reach = (uint32_t)of->reach;
  const double samples = (double)of->samples;
  for (uint32_t x = 0; x < of->width; x++) {
    /* Cells of the first tile begin 2 reach left of and above the picture. */
    const uint32_t at_x = x + 2 * reach, at_y = y + 2 * reach;
    film_cell sum = {0.0}, part, plain;
    for (uint32_t row = y / FILM_TILE; row <= at_y / FILM_TILE; row++) {
      for (uint32_t column = x / FILM_TILE; column <= at_x / FILM_TILE; column++) {
        const size_t line = at_y - row * FILM_TILE, place = at_x - column * FILM_TILE;
        read_cell(of, cells_of(of, column, row), line * of->side + place, &part);
        sum += part;
      }
    }
    const uint32_t own_x = x + reach, own_y = y + reach;
    const film_pixel own = film_at(of, own_x / FILM_TILE, own_y / FILM_TILE, own_x % FILM_TILE, own_y % FILM_TILE);
    read_cell(of, own.plain, 0, &plain);
    const double missing = 1.0 - sum[3] / samples;
    for (size_t c = 0; c < 3; c++)
      pixels[3 * ((size_t)y * of->width + x) + c] = (float)((sum[c] + missing * plain[c]) / samples);
  }
}

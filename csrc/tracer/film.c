#include "film.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "vectorise.h"

#define BUDGET ((size_t)64 << 20) /* bytes */

/* A tile has side x side cells for the pixels that it reaches, from `reach` left of and above its first, then as many
 * as it has pixels for their plain sums. */
static size_t tile_cells(const film *of) { return (size_t)of->side * of->side + (size_t)FILM_TILE * FILM_TILE; }

asc_status film_make(film *made, const asc_filter *filter, uint32_t width, uint32_t height, uint64_t samples) {
  const double radius = asc_filter_radius(filter);
  const uint32_t reach = (uint32_t)ceil(radius + 0.5) - 1; /* the largest whole number below radius + 1/2 */
  *made = (film){.filter = filter,
                 .radius = radius,
                 .samples = samples,
                 .reach = (int32_t)reach,
                 .taps = (uint32_t)ceil(2.0 * radius),
                 .side = FILM_TILE + 2 * reach,
                 .width = width,
                 .height = height,
                 .across = (width + 2 * reach + FILM_TILE - 1) / FILM_TILE,
                 .down = (height + 2 * reach + FILM_TILE - 1) / FILM_TILE};
  const size_t row = made->across * tile_cells(made) * sizeof(film_cell);
  const size_t fit = BUDGET / row;
  made->rows = fit < 2 ? 1 : fit > made->down ? made->down : (uint32_t)fit - 1;
  made->cells = aligned_alloc(sizeof(film_cell), (made->rows + (size_t)1) * row);
  return made->cells ? ASC_OK : ASC_OUT_OF_MEMORY;
}

void film_free(film *made) { free(made->cells); }

static film_cell *cells_of(const film *of, uint32_t column, uint32_t row) {
  const size_t slot = row % (of->rows + 1);
  return of->cells + (slot * of->across + column) * tile_cells(of);
}

film_tile film_begin(const film *of, uint32_t column, uint32_t row) {
  memset(cells_of(of, column, row), 0, tile_cells(of) * sizeof(film_cell));
  const uint32_t x = column * FILM_TILE, y = row * FILM_TILE; /* from `reach` left of and above the picture */
  const uint32_t right = of->width + 2 * (uint32_t)of->reach - x, bottom = of->height + 2 * (uint32_t)of->reach - y;
  return (film_tile){(int32_t)x - of->reach, (int32_t)y - of->reach, right < FILM_TILE ? right : FILM_TILE,
                     bottom < FILM_TILE ? bottom : FILM_TILE};
}

film_pixel film_at(const film *of, uint32_t column, uint32_t row, uint32_t x, uint32_t y) {
  film_cell *cells = cells_of(of, column, row);
  const uint32_t reach = (uint32_t)of->reach;
  return (film_pixel){cells + (size_t)(y + reach) * of->side + x + reach,
                      cells + (size_t)of->side * of->side + (size_t)y * FILM_TILE + x};
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

/* Adds each sample to the taps x taps cells from `corner` on. */
ASC_VECTORISE
static void splat(size_t count, uint32_t side, uint32_t taps, film_cell *const *corner, const double *weights,
                  const film_cell *values) {
  for (size_t k = 0; k < count; k++) {
    const double *along_x = weights + (size_t)2 * taps * k, *along_y = along_x + taps;
    const film_cell value = values[k];
    for (uint32_t j = 0; j < taps; j++) {
      film_cell *row = corner[k] + (size_t)j * side;
      for (uint32_t i = 0; i < taps; i++) row[i] += along_x[i] * along_y[j] * value;
    }
  }
}

void film_add(const film *of, size_t count, const film_sample *samples, const double (*radiance)[4]) {
  double positions[FILM_BATCH * 2 * FILM_TAPS_MOST] = {0.0}, weights[FILM_BATCH * 2 * FILM_TAPS_MOST];
  film_cell *corner[FILM_BATCH], values[FILM_BATCH];
  const size_t taps = of->taps;
  for (size_t k = 0; k < count; k++) {
    const int32_t x = positions_of(of, samples[k].x, positions + 2 * taps * k);
    const int32_t y = positions_of(of, samples[k].y, positions + 2 * taps * k + taps);
    corner[k] = samples[k].pixel.weighted + (ptrdiff_t)y * of->side + x;
    values[k] = samples[k].scale * (film_cell){radiance[k][0], radiance[k][1], radiance[k][2], 1.0};
    for (int c = 0; c < 3; c++) (*samples[k].pixel.plain)[c] += values[k][c];
  }
  (void)asc_filter_evaluate(of->filter, positions, 2 * taps * count, weights);
  splat(count, of->side, of->taps, corner, weights, values);
}

uint32_t film_complete(const film *of, uint32_t row) {
  if (row >= of->down) return of->height;
  const uint32_t sampled = row * FILM_TILE, reach = (uint32_t)of->reach; /* from `reach` above the picture */
  return sampled < 2 * reach ? 0 : sampled - 2 * reach;
}

void film_write_row(const film *of, uint32_t y, float *pixels) {
  const uint32_t reach = (uint32_t)of->reach;
  const double samples = (double)of->samples;
  for (uint32_t x = 0; x < of->width; x++) {
    /* Cells of the first tile begin 2 reach left of and above the picture. */
    const uint32_t at_x = x + 2 * reach, at_y = y + 2 * reach;
    film_cell sum = {0.0};
    for (uint32_t row = y / FILM_TILE; row <= at_y / FILM_TILE; row++) {
      for (uint32_t column = x / FILM_TILE; column <= at_x / FILM_TILE; column++) {
        const size_t line = at_y - row * FILM_TILE, place = at_x - column * FILM_TILE;
        sum += cells_of(of, column, row)[line * of->side + place];
      }
    }
    const uint32_t own_x = x + reach, own_y = y + reach;
    const film_cell plain =
        *film_at(of, own_x / FILM_TILE, own_y / FILM_TILE, own_x % FILM_TILE, own_y % FILM_TILE).plain;
    const double missing = 1.0 - sum[3] / samples;
    for (size_t c = 0; c < 3; c++)
      pixels[3 * ((size_t)y * of->width + x) + c] = (float)((sum[c] + missing * plain[c]) / samples);
  }
}

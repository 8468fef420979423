#include "film.h"

#include <math.h>
#include <stdlib.h>

#include "vectorise.h"

#define BUDGET ((size_t)64 << 20) /* bytes */

asc_status film_make(film *made, const asc_filter *filter, uint32_t width, uint32_t height) {
  const double radius = asc_filter_radius(filter);
  const uint32_t reach = (uint32_t)ceil(radius + 0.5) - 1; /* the largest whole number below radius + 1/2 */
  *made = (film){.filter = filter,
                 .radius = radius,
                 .reach = (int32_t)reach,
                 .taps = (uint32_t)ceil(2.0 * radius),
                 .side = FILM_TILE + 2 * reach,
                 .width = width,
                 .height = height,
                 .across = (width + 2 * reach + FILM_TILE - 1) / FILM_TILE,
                 .down = (height + 2 * reach + FILM_TILE - 1) / FILM_TILE};
  const size_t row = (size_t)made->across * made->side * made->side * sizeof(film_cell);
  const size_t fit = BUDGET / row;
  made->rows = fit < 2 ? 1 : fit > made->down ? made->down : (uint32_t)fit - 1;
  made->cells = aligned_alloc(sizeof(film_cell), (made->rows + (size_t)1) * row);
  return made->cells ? ASC_OK : ASC_OUT_OF_MEMORY;
}

void film_free(film *made) { free(made->cells); }

film_cell *film_tile(const film *of, uint32_t column, uint32_t row) {
  const size_t slot = row % (of->rows + 1);
  return of->cells + (slot * of->across + column) * of->side * of->side;
}

/* Adds each sample to the taps x taps cells from `corner` on. */
ASC_VECTORISE
static void splat(uint32_t count, uint32_t side, uint32_t taps, film_cell *const *corner, const double *weights,
                  const double (*radiance)[3]) {
  for (uint32_t k = 0; k < count; k++) {
    const double *along_x = weights + (size_t)2 * taps * k, *along_y = along_x + taps;
    const double value[4] = {radiance[k][0], radiance[k][1], radiance[k][2], 1.0};
    for (uint32_t j = 0; j < taps; j++) {
      film_cell *row = corner[k] + (size_t)j * side;
      for (uint32_t i = 0; i < taps; i++) {
        const double weight = along_x[i] * along_y[j];
        for (int c = 0; c < 4; c++) row[i].sum[c] += weight * value[c];
      }
    }
  }
}

/* The first of the pixels, relative to the sample's own, that hold a sample at x in [0, 1); writes the sample's
 * distances from all their centres. The last is kept within reach: it may be one too many where 2 radius is not
 * whole. */
static int32_t positions_of(const film *of, double x, double *positions) {
  const int32_t least = (int32_t)floor(x - 0.5 - of->radius) + 1, most = of->reach + 1 - (int32_t)of->taps;
  const int32_t first = least < most ? least : most;
  for (uint32_t i = 0; i < of->taps; i++) positions[i] = x - 0.5 - (first + (int32_t)i);
  return first;
}

void film_add(const film *of, size_t count, const film_sample *samples, const double (*radiance)[3]) {
  double positions[FILM_BATCH * 2 * FILM_TAPS_MOST], weights[FILM_BATCH * 2 * FILM_TAPS_MOST];
  film_cell *corner[FILM_BATCH];
  const size_t taps = of->taps;
  for (size_t k = 0; k < count; k++) {
    const int32_t x = positions_of(of, samples[k].x, positions + 2 * taps * k);
    const int32_t y = positions_of(of, samples[k].y, positions + 2 * taps * k + taps);
    corner[k] = samples[k].cell + (ptrdiff_t)y * of->side + x;
  }
  (void)asc_filter_evaluate(of->filter, positions, 2 * taps * count, weights);
  splat((uint32_t)count, of->side, of->taps, corner, weights, radiance);
}

uint32_t film_complete(const film *of, uint32_t row) {
  if (row >= of->down) return of->height;
  const uint32_t sampled = row * FILM_TILE, reach = (uint32_t)of->reach; /* rows, from `reach` above the picture on */
  const uint32_t complete = sampled < 2 * reach ? 0 : sampled - 2 * reach;
  return complete < of->height ? complete : of->height;
}

/* Pixel y is row y + 2 reach of the cells of the top row of tiles: theirs begin 2 reach above the picture. */
asc_status film_write_row(const film *of, uint32_t y, float *pixels) {
  const uint32_t reach = (uint32_t)of->reach;
  asc_status status = ASC_OK;
  for (uint32_t x = 0; x < of->width; x++) {
    double sum[4] = {0.0};
    for (uint32_t row = y / FILM_TILE; row <= (y + 2 * reach) / FILM_TILE; row++) {
      for (uint32_t column = x / FILM_TILE; column <= (x + 2 * reach) / FILM_TILE; column++) {
        const size_t inside = (size_t)(y + 2 * reach - row * FILM_TILE) * of->side + x + 2 * reach - column * FILM_TILE;
        const film_cell *cell = film_tile(of, column, row) + inside;
        for (int c = 0; c < 4; c++) sum[c] += cell->sum[c];
      }
    }
    if (!(sum[3] > 0.0)) {
      status = ASC_NUMERIC;
      continue;
    }
    for (int c = 0; c < 3; c++) pixels[3 * ((size_t)y * of->width + x) + (size_t)c] = (float)(sum[c] / sum[3]);
  }
  return status;
}

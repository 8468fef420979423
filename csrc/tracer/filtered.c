#include "filtered.h"

#include <string.h>

/* A band of tile rows, whose units are tiles, then rows of pixels. */
typedef struct band {
  const tracer *made;
  const asc_sampler *sampler;
  uint64_t samples;
  const film *target;
  uint32_t first_row; /* of tiles */
  uint32_t first_y;   /* of pixels */
  float *pixels;
} band;

static asc_status add_tile(void *job, uint32_t unit, block_work *memory) {
  const band *self = job;
  const film *of = self->target;
  const uint32_t column = unit % of->across, row = self->first_row + unit / of->across;
  const uint32_t reach = (uint32_t)of->reach;
  film_cell *cells = film_tile(of, column, row);
  memset(cells, 0, (size_t)of->side * of->side * sizeof *cells);
  /* From `reach` left of and above the picture, how far the tile goes and where what is sampled ends. */
  const uint32_t left = column * FILM_TILE, top = row * FILM_TILE;
  const uint32_t right = left + FILM_TILE < of->width + 2 * reach ? left + FILM_TILE : of->width + 2 * reach;
  const uint32_t bottom = top + FILM_TILE < of->height + 2 * reach ? top + FILM_TILE : of->height + 2 * reach;
  for (uint32_t y = top; y < bottom; y += BLOCK_SIDE) {
    for (uint32_t x = left; x < right; x += BLOCK_SIDE) {
      const block area = {(int32_t)x - of->reach, (int32_t)y - of->reach,
                          right - x < BLOCK_SIDE ? right - x : BLOCK_SIDE,
                          bottom - y < BLOCK_SIDE ? bottom - y : BLOCK_SIDE};
      film_cell *first = cells + (size_t)(y - top + reach) * of->side + x - left + reach;
      asc_status status = block_add(self->made, self->sampler, self->samples, area, of, first, memory);
      if (status) return status;
    }
  }
  return ASC_OK;
}

static asc_status write_row(void *job, uint32_t unit, block_work *memory) {
  (void)memory;
  const band *self = job;
  return film_write_row(self->target, self->first_y + unit, self->pixels);
}

asc_status filtered_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, const film *target,
                           uint32_t threads, float *pixels, crew_cost *cost) {
  band job = {.made = made, .sampler = sampler, .samples = samples, .target = target, .pixels = pixels};
  while (job.first_row < target->down) {
    const uint32_t left = target->down - job.first_row;
    const uint32_t rows = left < target->rows ? left : target->rows;
    asc_status status = crew_run(threads, rows * target->across, add_tile, &job, cost);
    if (status) return status;
    job.first_row += rows;
    const uint32_t complete = film_complete(target, job.first_row);
    status = crew_run(threads, complete - job.first_y, write_row, &job, cost);
    if (status) return status;
    job.first_y = complete;
  }
  return ASC_OK;
}

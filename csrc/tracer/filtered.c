#include "filtered.h"

/* A band of tile rows, whose units are tiles, then rows of pixels. */
typedef struct band {
  const tracer *made;
  const asc_sampler *sampler;
  const film *target;
  uint32_t first_row; /* of tiles */
  uint32_t first_y;   /* of pixels */
  float *pixels;
} band;

static asc_status add_tile(void *job, uint32_t unit, block_work *memory) {
  const band *self = job;
  const uint32_t column = unit % self->target->across, row = self->first_row + unit / self->target->across;
  const film_tile tile = film_begin(self->target, column, row);
  for (uint32_t y = 0; y < tile.rows; y += BLOCK_SIDE) {
    for (uint32_t x = 0; x < tile.columns; x += BLOCK_SIDE) {
      const block area = {tile.x + (int32_t)x, tile.y + (int32_t)y,
                          tile.columns - x < BLOCK_SIDE ? tile.columns - x : BLOCK_SIDE,
                          tile.rows - y < BLOCK_SIDE ? tile.rows - y : BLOCK_SIDE};
      film_pixel cells[BLOCK_SIDE * BLOCK_SIDE];
      for (uint32_t i = 0; i < area.rows * area.columns; i++)
        cells[i] = film_at(self->target, column, row, x + i % area.columns, y + i / area.columns);
      asc_status status =
          block_add(self->made, self->sampler, self->target->samples, area, self->target, cells, memory);
      if (status) return status;
    }
  }
  return ASC_OK;
}

static asc_status write_row(void *job, uint32_t unit, block_work *memory) {
  (void)memory;
  const band *self = job;
  film_write_row(self->target, self->first_y + unit, self->pixels);
  return ASC_OK;
}

asc_status filtered_render(const tracer *made, const asc_sampler *sampler, const film *target, uint32_t threads,
                           float *pixels, crew_cost *cost) {
  band job = {.made = made, .sampler = sampler, .target = target, .pixels = pixels};
  while (job.first_row < target->down) {
    const uint32_t left = target->down - job.first_row;
    const uint32_t rows = left < target->rows ? left : target->rows;
    asc_status status = crew_run(made, threads, rows * target->across, add_tile, &job, cost);
    if (status) return status;
    job.first_row += rows;
    const uint32_t complete = film_complete(target, job.first_row);
    status = crew_run(made, threads, complete - job.first_y, write_row, &job, cost);
    if (status) return status;
    job.first_y = complete;
  }
  return ASC_OK;
}

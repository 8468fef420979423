#include "adaptive.h"

#include <stdatomic.h>

#include "shine.h"

/* The unit of work: a group that the estimator decides for itself. What it looks at outside is sampled again by the
 * next tile, so that tiles wait for none: a ring round 64 x 64 pixels is 6 % more, of the first samples alone. */
#define TILE 64u

typedef struct picture {
  const tracer *made;
  const asc_estimator *estimator;
  uint32_t dimensions;
  uint32_t across; /* tiles */
  float *pixels;
  uint32_t *counts;
  asc_error *error; /* of one thread alone */
  atomic_ullong samples;
} picture;

typedef struct rays_of_tile {
  const tracer *made;
  packet *rays;
  uint32_t dimensions;
} rays_of_tile;

/* Sixteen samples in a row are a packet. Which these are follows from the tile alone. */
static asc_status trace(void *context, size_t count, const asc_pixel *pixels, const double *points, double *values) {
  const rays_of_tile *self = context;
  const tracer *made = self->made;
  packet *rays = self->rays;
  double sample_x[PACKET] = {0.0}, sample_y[PACKET] = {0.0}, places[PACKET][2] = {{0.0}}, radiance[PACKET][4];
  rays->sample_x = sample_x;
  rays->sample_y = sample_y;
  rays->lens = (const double(*)[2])places;
  rays->radiance = radiance;
  for (size_t done = 0; done < count; done += PACKET) {
    rays->lanes = count - done < PACKET ? (uint32_t)(count - done) : PACKET;
    for (uint32_t i = 0; i < PACKET; i++) {
      const double *point = points + (done + (i < rays->lanes ? i : 0)) * self->dimensions;
      rays->further[i] = point + 2;
      if (i >= rays->lanes) continue;
      sample_x[i] = pixels[done + i].x + point[0];
      sample_y[i] = pixels[done + i].y + point[1];
    }
    if (made->view.lens_radius > 0.0)
      lens_points(&made->lens, rays->lanes, points + done * self->dimensions + 2 + made->further.lens, self->dimensions,
                  places);
    packet_cast(made, rays);
    const sight seen = shine_see(made, rays);
    if (seen.one)
      shine_take(made, seen, &(sample_rows){PACKET, sample_x, sample_y, rays->lens, radiance});
    else if (!shine_take_each(made, rays))
      packet_shade(made, rays);
    for (uint32_t i = 0; i < rays->lanes; i++)
      for (uint32_t channel = 0; channel < 3; channel++) values[3 * (done + i) + channel] = radiance[i][channel];
  }
  return ASC_OK;
}

static asc_status render_tile(void *job, uint32_t tile, block_work *memory) {
  picture *self = job;
  const asc_view *view = &self->made->view;
  const uint32_t x = tile % self->across * TILE, y = tile / self->across * TILE;
  const asc_group group = {(int32_t)x, (int32_t)y, view->width - x < TILE ? view->width - x : TILE,
                           view->height - y < TILE ? view->height - y : TILE};
  double means[TILE * TILE * 3];
  uint64_t counts[TILE * TILE];
  asc_estimates made = {.struct_size = sizeof made, .means = means, .counts = counts};
  rays_of_tile context = {self->made, block_packet(memory), self->dimensions};
  const asc_status status = asc_estimate(self->estimator, &group, trace, &context, &made, self->error);
  if (status) return status;
  for (uint32_t i = 0; i < group.columns * group.rows; i++) {
    const size_t pixel = (size_t)(y + i / group.columns) * view->width + x + i % group.columns;
    for (uint32_t channel = 0; channel < 3; channel++)
      self->pixels[3 * pixel + channel] = (float)means[3 * (size_t)i + channel];
    if (self->counts) self->counts[pixel] = (uint32_t)counts[i];
  }
  (void)atomic_fetch_add(&self->samples, made.spent);
  return ASC_OK;
}

asc_status adaptive_render(const tracer *made, const asc_estimator *estimator, uint32_t dimensions, uint32_t threads,
                           float *pixels, uint32_t *counts, crew_cost *cost, uint64_t *samples, asc_error *error) {
  const asc_view *view = &made->view;
  picture job = {.made = made,
                 .estimator = estimator,
                 .dimensions = dimensions,
                 .across = (view->width + TILE - 1) / TILE,
                 .pixels = pixels,
                 .counts = counts,
                 .error = error};
  const uint32_t tiles = job.across * ((view->height + TILE - 1) / TILE);
  const asc_status status = crew_run(made, threads, tiles, render_tile, &job, cost);
  *samples = atomic_load(&job.samples);
  return status;
}

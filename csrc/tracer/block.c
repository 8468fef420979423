#include "block.h"

#include <stdlib.h>
#include <string.h>

#define CHUNK 1024 /* samples of a pixel that are drawn at a time */

struct block_work {
  packet rays;
  uint32_t pixel[PACKET]; /* of the block's, by lane */
  double scale[PACKET];   /* N times the sample's weight, by lane: 1 but for quadrature rules */
  double sum[BLOCK_SIDE * BLOCK_SIDE][3];
  double weights[CHUNK];
  double *points;  /* [CHUNK][dimensions] */
  double *further; /* [PACKET][dimensions - 2]: of samples whose packet is not full yet */
  block area;
  const film *target; /* NULL: samples go to `sum` */
  const film_pixel *cells;
};

block_work *block_work_make(const tracer *made) {
  block_work *memory = aligned_alloc(64, (sizeof *memory + 63) / 64 * 64);
  if (!memory) return NULL;
  memset(memory, 0, sizeof *memory);
  packet_begin(&memory->rays);
  const size_t further = made->further.count;
  memory->points = malloc(CHUNK * (2 + further) * sizeof(double));
  if (further) memory->further = malloc(PACKET * further * sizeof(double));
  if (!memory->points || (further && !memory->further)) {
    block_work_free(memory);
    return NULL;
  }
  return memory;
}

void block_work_free(block_work *memory) {
  if (!memory) return;
  free(memory->points);
  free(memory->further);
  free(memory);
}

packet *block_packet(block_work *memory) { return &memory->rays; }

ray_counts block_rays(const block_work *memory) { return memory->rays.counts; }

static void add_to_film(block_work *memory) {
  const packet *rays = &memory->rays;
  const block area = memory->area;
  film_sample samples[PACKET];
  for (uint32_t i = 0; i < rays->lanes; i++) {
    const uint32_t number = memory->pixel[i];
    samples[i] = (film_sample){memory->cells[number], rays->sample_x[i] - (area.x + (int32_t)(number % area.columns)),
                               rays->sample_y[i] - (area.y + (int32_t)(number / area.columns)), memory->scale[i]};
  }
  film_add(memory->target, rays->lanes, samples, rays->radiance);
}

/* Lanes of one pixel follow each other: its sum is kept aside meanwhile, as each addition would wait for the store of
 * the one before. */
static void add_to_sums(block_work *memory) {
  const packet *rays = &memory->rays;
  for (uint32_t i = 0; i < rays->lanes;) {
    const uint32_t number = memory->pixel[i];
    double *into = memory->sum[number];
    double red = into[0], green = into[1], blue = into[2];
    for (; i < rays->lanes && memory->pixel[i] == number; i++) {
      red += memory->scale[i] * rays->radiance[i][0];
      green += memory->scale[i] * rays->radiance[i][1];
      blue += memory->scale[i] * rays->radiance[i][2];
    }
    into[0] = red;
    into[1] = green;
    into[2] = blue;
  }
}

/* Traces what has gathered, and adds it up in the lanes' order. */
static void flush(const tracer *made, block_work *memory) {
  packet *rays = &memory->rays;
  if (rays->lanes == 0) return;
  packet_trace(made, rays);
  if (memory->target)
    add_to_film(memory);
  else
    add_to_sums(memory);
  rays->lanes = 0;
}

/* All samples of one pixel, into packets that go on with the next pixel where they are not full. */
static asc_status add_pixel(const tracer *made, const asc_sampler *sampler, uint64_t samples, int32_t x, int32_t y,
                            uint32_t number, block_work *memory) {
  packet *rays = &memory->rays;
  const size_t further = made->further.count;
  const int weighted = (asc_sampler_traits(sampler) & ASC_TRAIT_WEIGHTED) != 0;
  for (uint64_t done = 0; done < samples; done += CHUNK) {
    const uint64_t left = samples - done;
    const asc_range range = {x, y, done, left < CHUNK ? (size_t)left : CHUNK, 0, tracer_dimensions(made)};
    asc_status status = asc_sampler_fill(sampler, &range, memory->points);
    if (status == ASC_OK && weighted) status = asc_sampler_weights(sampler, done, range.sample_count, memory->weights);
    if (status) return status;
    for (size_t i = 0; i < range.sample_count; i++) {
      const uint32_t lane = rays->lanes++;
      const double *point = memory->points + i * (2 + further);
      rays->sample_x[lane] = x + point[0];
      rays->sample_y[lane] = y + point[1];
      if (further) {
        double *kept = memory->further + lane * further;
        memcpy(kept, point + 2, further * sizeof(double));
        rays->further[lane] = kept;
      }
      memory->pixel[lane] = number;
      memory->scale[lane] = weighted ? (double)samples * memory->weights[i] : 1.0;
      if (rays->lanes == PACKET) flush(made, memory);
    }
  }
  return ASC_OK;
}

static asc_status add_pixels(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area,
                             block_work *memory) {
  memory->rays.lanes = 0;
  memory->area = area;
  for (uint32_t i = 0; i < area.rows * area.columns; i++) {
    asc_status status = add_pixel(made, sampler, samples, area.x + (int32_t)(i % area.columns),
                                  area.y + (int32_t)(i / area.columns), i, memory);
    if (status) return status;
  }
  flush(made, memory);
  return ASC_OK;
}

asc_status block_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area,
                        block_work *memory, float *pixels) {
  memset(memory->sum, 0, sizeof memory->sum);
  memory->target = NULL;
  asc_status status = add_pixels(made, sampler, samples, area, memory);
  if (status) return status;
  for (uint32_t i = 0; i < area.rows * area.columns; i++) {
    const size_t x = (size_t)area.x + i % area.columns, y = (size_t)area.y + i / area.columns;
    float *pixel = pixels + 3 * (y * made->view.width + x);
    for (int channel = 0; channel < 3; channel++) pixel[channel] = (float)(memory->sum[i][channel] / (double)samples);
  }
  return ASC_OK;
}

asc_status block_add(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area, const film *target,
                     const film_pixel *cells, block_work *memory) {
  memory->target = target;
  memory->cells = cells;
  return add_pixels(made, sampler, samples, area, memory);
}

#include "block.h"

#include <stdlib.h>
#include <string.h>

#include "vectorise.h"

#define CHUNK 1024 /* samples of a pixel that are drawn at a time: some patterns are made whole for each call */
#define BATCH 1024 /* numbers of samples that are drawn before their rays are traced, of as many pixels as it takes */

/* Where in the block's samples, which are those of its pixels one after the other. */
typedef struct cursor {
  uint32_t pixel; /* of the block's */
  uint64_t sample;
} cursor;

/* Lanes in a row that are of one pixel. */
typedef struct share {
  uint32_t pixel, lanes;
} share;

struct block_work {
  packet rays;
  share shares[PACKET];
  uint32_t share_count;
  double sum[BLOCK_SIDE * BLOCK_SIDE][3];
  double *points;    /* [MOST_ROWS][dimensions]: drawn, and not traced yet */
  double (*lens)[2]; /* [MOST_ROWS], where there is one: their points of it */
  double *weights;   /* [MOST_ROWS], or none: N times the samples' weights, which are 1 but for quadrature rules */
  uint32_t dimensions;
  int weighted;
  uint64_t samples; /* a pixel */
  block area;
  const film *target; /* NULL: samples go to `sum` */
  const film_pixel *cells;
};

#define MOST_ROWS (PACKET + BATCH / 2 + CHUNK) /* of no full packet, of less than a batch, of what completes it */

block_work *block_work_make(const tracer *made) {
  block_work *memory = aligned_alloc(64, (sizeof *memory + 63) / 64 * 64);
  if (!memory) return NULL;
  memset(memory, 0, sizeof *memory);
  packet_begin(&memory->rays);
  memory->dimensions = tracer_dimensions(made);
  memory->points = malloc((size_t)MOST_ROWS * memory->dimensions * sizeof(double));
  memory->weights = malloc(MOST_ROWS * sizeof(double));
  memory->lens = calloc(MOST_ROWS + PACKET, sizeof *memory->lens);
  if (!memory->points || !memory->weights || !memory->lens) {
    block_work_free(memory);
    return NULL;
  }
  return memory;
}

void block_work_free(block_work *memory) {
  if (!memory) return;
  free(memory->points);
  free(memory->weights);
  free(memory->lens);
  free(memory);
}

packet *block_packet(block_work *memory) { return &memory->rays; }

ray_counts block_rays(const block_work *memory) { return memory->rays.counts; }

static int32_t pixel_x(const block *area, uint32_t pixel) { return area->x + (int32_t)(pixel % area->columns); }

static int32_t pixel_y(const block *area, uint32_t pixel) { return area->y + (int32_t)(pixel / area->columns); }

/* Moves on by at most so many samples of one pixel; gives how many. */
static size_t advance(cursor *at, uint64_t samples, size_t most) {
  const uint64_t left = samples - at->sample;
  if (left > most) {
    at->sample += most;
    return most;
  }
  *at = (cursor){at->pixel + 1, 0};
  return (size_t)left;
}

/* --- adding up ------------------------------------------------------------------------------------------------------
 */

/* `weights`: of the lanes, NULL where they are all 1. */
static void add_to_film(const block_work *memory, const double *weights) {
  const packet *rays = &memory->rays;
  film_sample samples[PACKET];
  uint32_t i = 0;
  for (uint32_t k = 0; k < memory->share_count; k++) {
    const share of = memory->shares[k];
    const int32_t x = pixel_x(&memory->area, of.pixel), y = pixel_y(&memory->area, of.pixel);
    for (uint32_t end = i + of.lanes; i < end; i++)
      samples[i] = (film_sample){memory->cells[of.pixel], rays->sample_x[i] - x, rays->sample_y[i] - y,
                                 weights ? weights[i] : 1.0};
  }
  film_add(memory->target, rays->lanes, samples, rays->radiance);
}

/* A pixel's sum is kept aside meanwhile, as each addition would wait for the store of the one before. */
static void add_to_sums(block_work *memory, const double *weights) {
  const double(*radiance)[3] = (const double(*)[3])memory->rays.radiance;
  uint32_t i = 0;
  for (uint32_t k = 0; k < memory->share_count; k++) {
    const share of = memory->shares[k];
    double *into = memory->sum[of.pixel];
    double red = into[0], green = into[1], blue = into[2];
    for (uint32_t end = i + of.lanes; i < end; i++) {
      const double weight = weights ? weights[i] : 1.0;
      red += weight * radiance[i][0];
      green += weight * radiance[i][1];
      blue += weight * radiance[i][2];
    }
    into[0] = red;
    into[1] = green;
    into[2] = blue;
  }
}

/* --- samples to rays ------------------------------------------------------------------------------------------------
 */

/* Draws samples, behind `kept` rows of those before, until they are a batch or the block's last; gives the rows. */
static asc_status draw(const asc_sampler *sampler, uint32_t pixels, cursor *at, size_t kept, block_work *memory,
                       size_t *rows) {
  *rows = kept;
  while (at->pixel < pixels && *rows * memory->dimensions < BATCH + kept * memory->dimensions) {
    const cursor from = *at;
    const size_t count = advance(at, memory->samples, CHUNK);
    const asc_range range = {pixel_x(&memory->area, from.pixel),
                             pixel_y(&memory->area, from.pixel),
                             from.sample,
                             count,
                             0,
                             memory->dimensions};
    asc_status status = asc_sampler_fill(sampler, &range, memory->points + *rows * memory->dimensions);
    if (status == ASC_OK && memory->weighted)
      status = asc_sampler_weights(sampler, from.sample, count, memory->weights + *rows);
    if (status) return status;
    for (size_t i = *rows; memory->weighted && i < *rows + count; i++) memory->weights[i] *= (double)memory->samples;
    *rows += count;
  }
  return ASC_OK;
}

/* Where samples lie, from where they lie in their pixel. */
ASC_VECTORISE static void place(const double *restrict points, size_t stride, size_t count, double x, double y,
                                double *restrict sample_x, double *restrict sample_y) {
  if (stride == 2 && count == PACKET) {
    for (size_t i = 0; i < PACKET; i++) {
      sample_x[i] = x + points[2 * i];
      sample_y[i] = y + points[2 * i + 1];
    }
    return;
  }
  for (size_t i = 0; i < count; i++) {
    sample_x[i] = x + points[stride * i];
    sample_y[i] = y + points[stride * i + 1];
  }
}

/* Traces the samples of at most PACKET rows. */
static void trace(const tracer *made, cursor *at, size_t first, size_t count, block_work *memory) {
  packet *rays = &memory->rays;
  const size_t stride = memory->dimensions;
  const double *points = memory->points + first * stride, *weights = memory->weights + first;
  rays->lanes = (uint32_t)count;
  memory->share_count = 0;
  for (size_t lane = 0, lanes; lane < count; lane += lanes) {
    const uint32_t pixel = at->pixel;
    lanes = advance(at, memory->samples, count - lane);
    place(points + lane * stride, stride, lanes, pixel_x(&memory->area, pixel), pixel_y(&memory->area, pixel),
          rays->sample_x + lane, rays->sample_y + lane);
    memory->shares[memory->share_count++] = (share){pixel, (uint32_t)lanes};
  }
  for (size_t i = 0; i < count && stride > 2; i++) rays->further[i] = points + i * stride + 2;
  rays->lens = (const double(*)[2])memory->lens + first;
  packet_trace(made, rays);
  if (memory->target)
    add_to_film(memory, memory->weighted ? weights : NULL);
  else
    add_to_sums(memory, memory->weighted ? weights : NULL);
  rays->lanes = 0;
}

/* All samples of the block's pixels, into packets that go on with the next pixel where they are not full. Of many
 * samples that are drawn one after the other the steps overlap, which wait for each other in each. */
static asc_status add_pixels(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area,
                             block_work *memory) {
  const uint32_t pixels = area.rows * area.columns;
  cursor drawn = {0, 0}, traced = {0, 0};
  memory->weighted = (asc_sampler_traits(sampler) & ASC_TRAIT_WEIGHTED) != 0;
  memory->samples = samples;
  memory->area = area;
  for (size_t kept = 0; drawn.pixel < pixels;) {
    size_t rows, done = 0;
    asc_status status = draw(sampler, pixels, &drawn, kept, memory, &rows);
    if (status) return status;
    if (made->view.lens_radius > 0.0)
      lens_points(&made->lens, rows, memory->points + 2 + made->further.lens, memory->dimensions, memory->lens);
    for (; done + PACKET <= rows; done += PACKET) trace(made, &traced, done, PACKET, memory);
    kept = rows - done;
    if (kept > 0 && drawn.pixel == pixels) trace(made, &traced, done, kept, memory);
    memmove(memory->points, memory->points + done * memory->dimensions, kept * memory->dimensions * sizeof(double));
    memmove(memory->weights, memory->weights + done, kept * sizeof(double));
  }
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

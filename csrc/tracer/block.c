#include "block.h"

#include <stdlib.h>
#include <string.h>

#include "shine.h"
#include "vectorise.h"

#define CHUNK 1024 /* samples of a pixel that are drawn at a time: some patterns are made whole for each call */
#define BATCH                                                                                                          \
  1024 /* numbers that are drawn before the rays of their samples are traced, of as many pixels as it takes */

#define AHEAD 32768 /* numbers that are drawn at a time of a distant sampler: those of whole pixels */

#define MOST_ROWS (PACKET + BATCH / 2 + CHUNK) /* of no full packet, of less than a batch, of what completes it */
#define PADDED_ROWS (MOST_ROWS + PACKET)       /* the last packet's lanes that are not in use are numbers too */

/* Where in the block's samples, which are those of its pixels one after the other. */
typedef struct cursor {
  uint32_t pixel; /* of the block's */
  uint64_t sample;
} cursor;

/* Rows one after the other that saw the same. */
typedef struct run {
  size_t end; /* one past the last */
  int alone;  /* whether the paint, and `mix` where that is patterned, say what they saw; else `radiance` does */
  paint paint;
} run;

/* Samples that were drawn, and are not added up yet, each a row. */
struct block_work {
  packet rays;
  alignas(64) double sample_x[PADDED_ROWS];
  alignas(64) double sample_y[PADDED_ROWS];
  alignas(64) double mix[PADDED_ROWS];         /* of runs alone */
  alignas(64) double lens[PADDED_ROWS][2];     /* where there is one */
  alignas(64) double radiance[PADDED_ROWS][4]; /* as a packet's */
  film_cell sum[BLOCK_SIDE * BLOCK_SIDE];
  film_cell_compensated compensated[BLOCK_SIDE * BLOCK_SIDE]; /* instead of `sum`, where that is what is kept */
  double weights[MOST_ROWS]; /* N times the samples' weights; not set where they are all 1 */
  run runs[PADDED_ROWS / PACKET];
  sight sights[PADDED_ROWS / PACKET]; /* by packet */
  double *points;                     /* [MOST_ROWS][dimensions] */
  double *ahead;                      /* [AHEAD], once there is a distant sampler */
  uint32_t ahead_first, ahead_end;    /* the pixels of the block whose numbers these are */
  uint32_t dimensions;
  int weighted, distant;
  tracer_film kept; /* in what sums are */
  uint64_t samples; /* a pixel */
  block area;
  const film *target; /* NULL: samples go to `sum` */
  const film_pixel *cells;
};

block_work *block_work_make(const tracer *made) {
  block_work *memory = aligned_alloc(64, (sizeof *memory + 63) / 64 * 64);
  if (!memory) return NULL;
  memset(memory, 0, sizeof *memory);
  packet_begin(&memory->rays);
  memory->dimensions = tracer_dimensions(made);
  memory->kept = made->options.film;
  memory->points = malloc((size_t)MOST_ROWS * memory->dimensions * sizeof(double));
  if (!memory->points) {
    block_work_free(memory);
    return NULL;
  }
  return memory;
}

void block_work_free(block_work *memory) {
  if (!memory) return;
  free(memory->points);
  free(memory->ahead);
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

/* --- samples to rays ------------------------------------------------------------------------------------------------
 */

/* Where samples lie, from where they lie in their pixel. */
ASC_VECTORISE static void place(const double *restrict points, size_t stride, size_t count, double x, double y,
                                double *restrict sample_x, double *restrict sample_y) {
  if (stride == 2) {
    for (size_t i = 0; i < count; i++) {
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

/* All samples of pixels that lie side by side, of a sampler that is better asked for many at a time. */
static asc_status draw_ahead(const asc_sampler *sampler, uint32_t pixel, uint32_t pixels, block_work *memory,
                             double *points) {
  const block *area = &memory->area;
  const size_t each = memory->samples * memory->dimensions;
  const uint32_t most = (uint32_t)(AHEAD / (each ? each : 1)), all = area->rows * area->columns;
  const asc_range range = {area->x, area->y, 0, memory->samples, 0, memory->dimensions};
  if (!memory->ahead) memory->ahead = malloc(AHEAD * sizeof(double));
  if (!memory->ahead) return ASC_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < pixels; i++, pixel++) {
    if (pixel < memory->ahead_first || pixel >= memory->ahead_end) {
      const uint32_t count = all - pixel < most ? all - pixel : most;
      const asc_status status = asc_sampler_fill_area(sampler, &range, area->columns, pixel, count, memory->ahead);
      if (status) return status;
      memory->ahead_first = pixel;
      memory->ahead_end = pixel + count;
    }
    memcpy(points + i * each, memory->ahead + (pixel - memory->ahead_first) * each, each * sizeof(double));
  }
  return ASC_OK;
}

/* Draws samples as the rows from `row` on, at most `wanted`: of as many pixels side by side, or at least of one what is
 * drawn at a time. Gives how many. */
static asc_status draw_some(const asc_sampler *sampler, cursor *at, size_t row, size_t wanted, block_work *memory,
                            size_t *count) {
  const uint32_t pixel = at->pixel, side = memory->area.columns - pixel % memory->area.columns;
  const int32_t x = pixel_x(&memory->area, pixel), y = pixel_y(&memory->area, pixel);
  const uint64_t first = at->sample, fit = memory->samples ? wanted / memory->samples : 0;
  const uint32_t pixels = fit < 1 ? 1 : fit < side ? (uint32_t)fit : side;
  const size_t each = advance(at, memory->samples, CHUNK);
  at->pixel += pixels - 1; /* where there are several, all their samples are drawn */
  *count = pixels * each;
  double *points = memory->points + row * memory->dimensions, *weights = memory->weights + row;
  const asc_range range = {x, y, first, each, 0, memory->dimensions};
  asc_status status = memory->distant ? draw_ahead(sampler, pixel, pixels, memory, points)
                                      : asc_sampler_fill_pixels(sampler, &range, pixels, points);
  for (uint32_t i = 0; i < pixels && status == ASC_OK; i++) {
    const size_t done = i * each;
    if (memory->weighted) status = asc_sampler_weights(sampler, first, each, weights + done);
    place(points + done * memory->dimensions, memory->dimensions, each, x + (int32_t)i, y,
          memory->sample_x + row + done, memory->sample_y + row + done);
  }
  for (size_t i = 0; memory->weighted && i < *count; i++) weights[i] *= (double)memory->samples;
  return status;
}

/* Draws samples, behind the rows that there are, until a batch is added, or the block's last is; gives all rows. */
static asc_status draw(const tracer *made, const asc_sampler *sampler, cursor *at, block_work *memory, size_t *rows) {
  const uint32_t pixels = memory->area.rows * memory->area.columns;
  const size_t enough = *rows + BATCH / memory->dimensions;
  while (at->pixel < pixels && *rows < enough) {
    size_t count;
    asc_status status = draw_some(sampler, at, *rows, enough - *rows, memory, &count);
    if (status) return status;
    *rows += count;
  }
  if (made->view.lens_radius > 0.0)
    lens_points(&made->lens, *rows, memory->points + 2 + made->further.lens, memory->dimensions, memory->lens);
  return ASC_OK;
}

/* Sends the rays of at most PACKET rows. */
static void cast(const tracer *made, size_t first, uint32_t count, block_work *memory) {
  packet *rays = &memory->rays;
  const size_t stride = memory->dimensions;
  const double *further = memory->points + first * stride + 2;
  rays->lanes = count;
  rays->sample_x = memory->sample_x + first;
  rays->sample_y = memory->sample_y + first;
  rays->lens = (const double(*)[2])memory->lens + first;
  rays->radiance = memory->radiance + first;
  for (size_t i = 0; i < PACKET && stride > 2; i++) rays->further[i] = further + (i < count ? i * stride : 0);
  packet_cast(made, rays);
  sight *seen = &memory->sights[first / PACKET];
  *seen = shine_see(made, rays);
  if (!seen->one && !shine_take_each(made, rays)) packet_shade(made, rays);
}

/* Traces the first rows. Many are drawn, then sent, then shaded, then added up: within each of these steps rays do not
 * wait for each other, so that the machine has several under way. */
static void trace(const tracer *made, size_t rows, block_work *memory) {
  for (size_t i = 0; i < rows; i += PACKET) cast(made, i, rows - i < PACKET ? (uint32_t)(rows - i) : PACKET, memory);
  run *to = memory->runs;
  for (size_t first = 0; first < rows; first = to++->end) {
    const sight *seen = &memory->sights[first / PACKET];
    to->end = first + PACKET;
    while (to->end < rows && shine_same(*seen, memory->sights[to->end / PACKET])) to->end += PACKET;
    const sample_rows of = {to->end - first, memory->sample_x + first, memory->sample_y + first,
                            (const double(*)[2])memory->lens + first, memory->radiance + first};
    to->alone = !memory->target && memory->kept == TRACER_FILM_DOUBLE && shine_paint(made, *seen, &to->paint);
    if (!to->alone && seen->one) shine_take(made, *seen, &of);
    if (to->alone && to->paint.patterned) shine_mix(made, *seen, &of, memory->mix + first);
  }
}

/* --- adding up ------------------------------------------------------------------------------------------------------
 */

static void add_to_film(block_work *memory, cursor *at, size_t rows) {
  for (size_t first = 0; first < rows; first += FILM_BATCH) {
    film_sample samples[FILM_BATCH];
    const size_t count = rows - first < FILM_BATCH ? rows - first : FILM_BATCH;
    for (size_t i = 0; i < count;) {
      const uint32_t pixel = at->pixel;
      const int32_t x = pixel_x(&memory->area, pixel), y = pixel_y(&memory->area, pixel);
      for (const size_t end = i + advance(at, memory->samples, count - i); i < end; i++)
        samples[i] =
            (film_sample){memory->cells[pixel], memory->sample_x[first + i] - x, memory->sample_y[first + i] - y,
                          memory->weighted ? memory->weights[first + i] : 1.0};
    }
    film_add(memory->target, count, samples, (const double(*)[4])memory->radiance + first);
  }
}

#define SUMS 4

/* A pixel's sum is kept aside meanwhile, and as several, as each addition would wait for the one before. */
ASC_VECTORISE static void add_rows(const double (*radiance)[4], const double *weights, size_t count, film_cell *into) {
  film_cell sums[SUMS] = {*into}, more[SUMS];
  size_t i = 0;
  for (; i + SUMS <= count; i += SUMS) {
    memcpy(more, radiance[i], sizeof more);
    for (size_t k = 0; k < SUMS; k++) sums[k] += weights ? weights[i + k] * more[k] : more[k];
  }
  for (; i < count; i++) {
    memcpy(more, radiance[i], sizeof *more);
    sums[0] += weights ? weights[i] * more[0] : more[0];
  }
  *into = (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/* The sum of numbers, each times its weight, in 8 parts; of the weights alone where there are no numbers. */
ASC_INLINE double sum_of(const double *numbers, const double *weights, size_t count) {
  double sums[8] = {0.0};
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {
    ASC_LANES_LOOP
    for (size_t k = 0; k < 8; k++) sums[k] += (numbers ? numbers[i + k] : 1.0) * (weights ? weights[i + k] : 1.0);
  }
  for (; i < count; i++) sums[0] += (numbers ? numbers[i] : 1.0) * (weights ? weights[i] : 1.0);
  for (size_t k = 0; k < 4; k++) sums[k] += sums[k + 4];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

/* `mix` is NULL of what is not patterned, `weights` where they are 1. */
ASC_VECTORISE static void add_paint(const paint *of, const double *mix, const double *weights, size_t count,
                                    film_cell *into) {
  film_cell base, change;
  memcpy(&base, of->base, sizeof base);
  *into += base * (weights ? sum_of(NULL, weights, count) : (double)count);
  if (!mix) return;
  memcpy(&change, of->change, sizeof change);
  *into += change * (weights ? sum_of(mix, weights, count) : sum_of(mix, NULL, count));
}

/* The same in float, to a sum that is one of floats. */
ASC_VECTORISE static void add_rows_single(const double (*radiance)[4], const double *weights, size_t count,
                                          film_cell *into) {
  film_cell_single sum = __builtin_convertvector(*into, film_cell_single);
  for (size_t i = 0; i < count; i++) {
    film_cell more;
    memcpy(&more, radiance[i], sizeof more);
    sum += __builtin_convertvector(weights ? weights[i] * more : more, film_cell_single);
  }
  *into = __builtin_convertvector(sum, film_cell);
}

/* The same with what each addition loses. */
ASC_VECTORISE static void add_rows_compensated(const double (*radiance)[4], const double *weights, size_t count,
                                               film_cell_compensated *into) {
  film_cell_compensated sum = *into;
  for (size_t i = 0; i < count; i++) {
    film_cell more;
    memcpy(&more, radiance[i], sizeof more);
    film_add_compensated(&sum, __builtin_convertvector(weights ? weights[i] * more : more, film_cell_single));
  }
  *into = sum;
}

static void add_to_sums(block_work *memory, cursor *at, size_t rows) {
  const run *in = memory->runs;
  for (size_t i = 0, count; i < rows; i += count) {
    if (i == in->end) in++;
    const double *weights = memory->weighted ? memory->weights + i : NULL;
    const uint32_t pixel = at->pixel;
    film_cell *into = &memory->sum[pixel];
    const double(*radiance)[4] = (const double(*)[4])memory->radiance + i;
    count = advance(at, memory->samples, (in->end < rows ? in->end : rows) - i);
    if (in->alone)
      add_paint(&in->paint, in->paint.patterned ? memory->mix + i : NULL, weights, count, into);
    else if (memory->kept == TRACER_FILM_COMPENSATED)
      add_rows_compensated(radiance, weights, count, &memory->compensated[pixel]);
    else if (memory->kept == TRACER_FILM_FLOAT)
      add_rows_single(radiance, weights, count, into);
    else
      add_rows(radiance, weights, count, into);
  }
}

/* Moves the rows from `first` on to the front. */
static void move_rows(block_work *memory, size_t first, size_t count) {
  const size_t stride = memory->dimensions;
  memmove(memory->points, memory->points + first * stride, count * stride * sizeof(double));
  memmove(memory->weights, memory->weights + first, count * sizeof(double));
  memmove(memory->sample_x, memory->sample_x + first, count * sizeof(double));
  memmove(memory->sample_y, memory->sample_y + first, count * sizeof(double));
}

/* All samples of the block's pixels, into packets that go on with the next pixel where they are not full. */
static asc_status add_pixels(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area,
                             block_work *memory) {
  const uint32_t pixels = area.rows * area.columns;
  cursor drawn = {0, 0}, added = {0, 0};
  memory->weighted = (asc_sampler_traits(sampler) & ASC_TRAIT_WEIGHTED) != 0;
  memory->distant =
      (asc_sampler_traits(sampler) & ASC_TRAIT_DISTANT) && samples <= CHUNK && samples * memory->dimensions <= AHEAD;
  memory->ahead_first = memory->ahead_end = 0;
  memory->samples = samples;
  memory->area = area;
  for (size_t rows = 0; drawn.pixel < pixels;) {
    asc_status status = draw(made, sampler, &drawn, memory, &rows);
    if (status) return status;
    const size_t ready = drawn.pixel < pixels ? rows / PACKET * PACKET : rows;
    trace(made, ready, memory);
    if (memory->target)
      add_to_film(memory, &added, ready);
    else
      add_to_sums(memory, &added, ready);
    rows -= ready;
    if (rows > 0) move_rows(memory, ready, rows);
  }
  return ASC_OK;
}

asc_status block_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area,
                        block_work *memory, float *pixels) {
  memset(memory->sum, 0, sizeof memory->sum);
  memset(memory->compensated, 0, sizeof memory->compensated);
  memory->target = NULL;
  asc_status status = add_pixels(made, sampler, samples, area, memory);
  if (status) return status;
  for (uint32_t i = 0; i < area.rows * area.columns; i++) {
    const size_t x = (size_t)area.x + i % area.columns, y = (size_t)area.y + i / area.columns;
    float *pixel = pixels + 3 * (y * made->view.width + x);
    if (memory->kept == TRACER_FILM_COMPENSATED) film_read_compensated(&memory->compensated[i], &memory->sum[i]);
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

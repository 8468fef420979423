#include "block.h"

#include <math.h>
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"
#include "shade.h"

#define PACKET 16
#define CHUNK 1024 /* samples of a pixel that are drawn at a time */

struct block_work {
  alignas(64) struct RTCRayHit16 rays;
  alignas(64) int valid[PACKET];
  struct RTCIntersectContext context;
  double sample_x[PACKET], sample_y[PACKET]; /* where in the picture, in pixels */
  uint32_t pixel[PACKET];                    /* of the block's */
  uint32_t lanes;
  double sum[BLOCK_SIDE * BLOCK_SIDE][3];
  double points[CHUNK][2];
};

block_work *block_work_make(void) {
  block_work *memory = aligned_alloc(64, (sizeof *memory + 63) / 64 * 64);
  if (!memory) return NULL;
  memset(memory, 0, sizeof *memory);
  rtcInitIntersectContext(&memory->context);
  memory->context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return memory;
}

void block_work_free(block_work *memory) { free(memory); }

/* Rays through the lanes' samples. Perspective: from the eye, t is the depth; orthographic: from the eye's plane. */
static void make_rays(const asc_view *view, block_work *memory) {
  struct RTCRay16 *ray = &memory->rays.ray;
  struct RTCHit16 *hit = &memory->rays.hit;
  const double step_x = 2.0 * view->half_width / view->width, step_y = 2.0 * view->half_height / view->height;
  float u[PACKET], v[PACKET];
  for (int i = 0; i < PACKET; i++) {
    u[i] = (float)(step_x * memory->sample_x[i] - view->half_width);
    v[i] = (float)(view->half_height - step_y * memory->sample_y[i]);
  }
  const int perspective = view->projection == ASC_PERSPECTIVE;
  for (int i = 0; i < PACKET; i++) {
    ray->org_x[i] = perspective ? 0.0f : u[i];
    ray->org_y[i] = perspective ? 0.0f : v[i];
    ray->org_z[i] = 0.0f;
    ray->dir_x[i] = perspective ? u[i] : 0.0f;
    ray->dir_y[i] = perspective ? v[i] : 0.0f;
    ray->dir_z[i] = 1.0f;
    ray->tnear[i] = 0.0f;
    ray->tfar[i] = INFINITY;
    ray->time[i] = 0.0f;
    ray->mask[i] = UINT32_MAX;
    ray->flags[i] = 0;
    hit->geomID[i] = RTC_INVALID_GEOMETRY_ID;
    hit->instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
}

/* Traces what has gathered, and adds it up in the lanes' order. */
static void flush(const tracer *made, block_work *memory) {
  if (memory->lanes == 0) return;
  for (uint32_t i = 0; i < PACKET; i++) {
    memory->valid[i] = i < memory->lanes ? -1 : 0;
    if (i < memory->lanes) continue;
    memory->sample_x[i] = memory->sample_x[0]; /* not traced; but numbers, for the arithmetic */
    memory->sample_y[i] = memory->sample_y[0];
  }
  make_rays(&made->view, memory);
  rtcIntersect16(memory->valid, made->scene, &memory->context, &memory->rays);
  for (uint32_t i = 0; i < memory->lanes; i++) {
    const struct RTCHit16 *hit = &memory->rays.hit;
    double patterned[3];
    const double *radiance =
        shade(made, hit->geomID[i], hit->primID[i], memory->sample_x[i], memory->sample_y[i], patterned);
    double *sum = memory->sum[memory->pixel[i]];
    sum[0] += radiance[0];
    sum[1] += radiance[1];
    sum[2] += radiance[2];
  }
  memory->lanes = 0;
}

/* All samples of one pixel, into packets that go on with the next pixel where they are not full. */
static asc_status add_pixel(const tracer *made, const asc_sampler *sampler, uint64_t samples, uint32_t x, uint32_t y,
                            uint32_t number, block_work *memory) {
  for (uint64_t done = 0; done < samples; done += CHUNK) {
    const uint64_t left = samples - done;
    const asc_range range = {(int32_t)x, (int32_t)y, done, left < CHUNK ? (size_t)left : CHUNK, 0, 2};
    asc_status status = asc_sampler_fill(sampler, &range, &memory->points[0][0]);
    if (status) return status;
    for (size_t i = 0; i < range.sample_count; i++) {
      const uint32_t lane = memory->lanes++;
      memory->sample_x[lane] = x + memory->points[i][0];
      memory->sample_y[lane] = y + memory->points[i][1];
      memory->pixel[lane] = number;
      if (memory->lanes == PACKET) flush(made, memory);
    }
  }
  return ASC_OK;
}

asc_status block_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, uint32_t x, uint32_t y,
                        block_work *memory, float *pixels) {
  const asc_view *view = &made->view;
  const uint32_t columns = view->width - x < BLOCK_SIDE ? view->width - x : BLOCK_SIDE;
  const uint32_t rows = view->height - y < BLOCK_SIDE ? view->height - y : BLOCK_SIDE;
  memset(memory->sum, 0, sizeof memory->sum);
  memory->lanes = 0;
  for (uint32_t i = 0; i < rows * columns; i++) {
    asc_status status = add_pixel(made, sampler, samples, x + i % columns, y + i / columns, i, memory);
    if (status) return status;
  }
  flush(made, memory);
  for (uint32_t i = 0; i < rows * columns; i++) {
    float *pixel = pixels + 3 * ((size_t)(y + i / columns) * view->width + x + i % columns);
    for (int channel = 0; channel < 3; channel++) pixel[channel] = (float)(memory->sum[i][channel] / (double)samples);
  }
  return ASC_OK;
}

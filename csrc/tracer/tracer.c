/* Making a tracer, and its pictures. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#include "tracer.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "adaptive.h"
#include "aliascope/plugin.h"
#include "complaint.h"
#include "corners.h"
#include "emitter.h"
#include "filtered.h"
#include "frames.h"
#include "relative.h"
#include "scene.h"

static double seconds(clockid_t clock) {
  struct timespec now;
  (void)clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double tracer_thread_cpu_seconds(void) { return seconds(CLOCK_THREAD_CPUTIME_ID) + asc_plugin_seconds(); }

uint32_t tracer_embree_version(void) { return RTC_VERSION; }

void tracer_describe(const tracer *made, tracer_kernel *kernel) {
  const tracer_kernel found = {(uint32_t)rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_VERSION),
                               made->options.packet,
                               rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED)  ? 16
                               : rtcGetDeviceProperty(made->device, RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED) ? 8
                                                                                                               : 4,
                               (rtcGetSceneFlags(made->scene) & RTC_SCENE_FLAG_ROBUST) != 0};
  *kernel = found;
}

static asc_status take_options(tracer *made, const tracer_options *given, asc_error *error) {
  tracer_options *taken = &made->options;
  if (given) *taken = *given;
  if (given && given->struct_size != sizeof *given)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_create_with: the options need their struct_size");
  if (taken->packet == 0) taken->packet = PACKET;
  if (taken->packet != 1 && taken->packet != 4 && taken->packet != 8 && taken->packet != PACKET)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "packets of %u rays: there are those of 1, 4, 8 and 16",
                    taken->packet);
  if (taken->not_robust > 1 || taken->not_relative > 1 || taken->look_once > 1 ||
      (unsigned)taken->film > TRACER_FILM_COMPENSATED)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_create_with: an option has no such value");
  return ASC_OK;
}

asc_status tracer_create(const asc_scene *scene, tracer **made, asc_error *error) {
  return tracer_create_with(scene, NULL, made, error);
}

static asc_status take_scene(tracer *made, const asc_scene *world, asc_error *error) {
  relative_scene local;
  asc_status status = relative_take(world, &made->options, &local, error);
  made->ahead = local.ahead;
  if (status == ASC_OK) status = tracer_take_appearance(made, &local.scene, error);
  if (status == ASC_OK) {
    /* One thread builds, so that the structure, and with it which of two touching surfaces is met, is always the
     * same. */
    made->device = rtcNewDevice("threads=1,set_affinity=0,ignore_config_files=1");
    status = made->device ? tracer_take_geometry(made, &local, error)
                          : asc_fail(error, ASC_UNAVAILABLE, "Embree does not start on this machine");
  }
  /* Pieces have such corners too. */
  made->looks_again = !made->options.look_once && !made->options.not_robust && status == ASC_OK &&
                      (made->parts || corners_any_surrounded(world));
  if (status == ASC_OK) status = emitter_take(made, &local.scene, error);
  relative_free(&local);
  return status;
}

asc_status tracer_create_with(const asc_scene *scene, const tracer_options *options, tracer **made, asc_error *error) {
  if (!scene || scene->struct_size != sizeof *scene || !made)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_create: the scene needs its struct_size");
  *made = NULL;
  tracer *fresh = calloc(1, sizeof *fresh);
  if (!fresh) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  asc_status status = take_options(fresh, options, error);
  if (status == ASC_OK) status = take_scene(fresh, scene, error);
  if (status) {
    tracer_destroy(fresh);
    return status;
  }
  *made = fresh;
  return ASC_OK;
}
uint32_t tracer_dimensions(const tracer *made) { return 2 + made->further.count; }

void tracer_groups(const tracer *made, uint32_t *sizes, size_t *count) {
  *count = made->further.group_count;
  if (sizes) memcpy(sizes, made->further.groups, *count * sizeof *sizes);
}

void tracer_destroy(tracer *made) {
  if (!made) return;
  if (made->scene) rtcReleaseScene(made->scene);
  if (made->device) rtcReleaseDevice(made->device);
  for (int kind = 0; kind < GEOMETRY_KINDS; kind++) {
    free(made->material_of[kind]);
    free(made->motion_of[kind]);
    free(made->emitter_of[kind]);
    free(made->least_lift[kind]);
  }
  for (size_t i = 0; i < made->part_count; i++) free(made->parts[i].members);
  free(made->parts);
  frames_free(made);
  free(made->further.groups);
  free(made->motions);
  free(made->materials);
  free(made->triangle_planes);
  free(made->disc_planes);
  free(made->balls);
  free(made->disc_balls);
  free(made->planes);
  free(made->lights);
  free(made->emitters);
  free(made);
}

/* A picture of the box filter, whose units are rows of blocks. */
typedef struct picture {
  const tracer *made;
  const asc_sampler *sampler;
  uint64_t samples; /* a pixel */
  float *pixels;
} picture;

static asc_status render_row(void *job, uint32_t row, block_work *memory) {
  const picture *self = job;
  const asc_view *view = &self->made->view;
  const uint32_t y = row * BLOCK_SIDE;
  for (uint32_t x = 0; x < view->width; x += BLOCK_SIDE) {
    const block area = {(int32_t)x, (int32_t)y, view->width - x < BLOCK_SIDE ? view->width - x : BLOCK_SIDE,
                        view->height - y < BLOCK_SIDE ? view->height - y : BLOCK_SIDE};
    asc_status status = block_render(self->made, self->sampler, self->samples, area, memory, self->pixels);
    if (status) return status;
  }
  return ASC_OK;
}

/* Whether each sample counts in its own pixel alone, and there for as much as any other. */
static int is_box(const asc_filter *filter) {
  asc_filter_desc resolved;
  return asc_filter_resolved(filter, &resolved) || strcmp(resolved.spec, "box") == 0;
}

/* Renders, and counts the samples; `border`: how many pixels beyond the picture were sampled, each way. */
static asc_status render(const tracer *made, const tracer_desc *desc, uint64_t samples, float *pixels, crew_cost *cost,
                         uint64_t *all_samples, uint32_t *border) {
  const asc_view *view = &made->view;
  const uint32_t threads = desc->threads ? desc->threads : 1;
  if (is_box(desc->filter)) {
    picture job = {made, desc->sampler, samples, pixels};
    *all_samples = samples * view->width * view->height;
    return crew_run(made, threads, (view->height + BLOCK_SIDE - 1) / BLOCK_SIDE, render_row, &job, cost);
  }
  film target;
  asc_status status = film_make(&target, made->options.film, desc->filter, view->width, view->height, samples);
  if (status) return status;
  *border = (uint32_t)target.reach;
  *all_samples = samples * (view->width + 2 * (uint64_t)*border) * (view->height + 2 * (uint64_t)*border);
  status = filtered_render(made, desc->sampler, &target, threads, pixels, cost);
  film_free(&target);
  return status;
}

static tracer_cost cost_of(const tracer *made, uint64_t samples, const crew_cost *spent, double wall_seconds) {
  return (tracer_cost){.samples = samples,
                       .primary_rays = samples,
                       .reflection_rays = spent->rays.reflection,
                       .bounce_rays = spent->rays.bounce,
                       .shadow_rays = spent->rays.shadow,
                       .cpu_seconds = spent->cpu_seconds,
                       .wall_seconds = wall_seconds,
                       .build_cpu_seconds = made->build_cpu_seconds};
}

asc_status tracer_render(tracer *made, const tracer_desc *desc, float *pixels, tracer_cost *cost, asc_error *error) {
  if (!made || !desc || desc->struct_size != sizeof *desc || !desc->sampler || !pixels)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_render: the desc needs its struct_size and a sampler");
  asc_sampler_desc sampling;
  asc_status status = asc_sampler_resolved(desc->sampler, &sampling);
  if (status || sampling.dimensions < tracer_dimensions(made))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_render: the sampler needs %u dimensions",
                    tracer_dimensions(made));
  crew_cost spent = {0};
  uint64_t samples = 0;
  const double begun = seconds(CLOCK_MONOTONIC);
  complaint_area area = {made->view.width, made->view.height, 0};
  status = render(made, desc, sampling.samples, pixels, &spent, &samples, &area.border);
  if (status == ASC_OUT_OF_MEMORY) return asc_fail(error, status, "%s", asc_status_text(status));
  if (status) return complain_of_sampler(desc->sampler, area, status, error);
  status = complain_of_pixels(pixels, area, error);
  if (status) return status;
  if (cost) *cost = cost_of(made, samples, &spent, seconds(CLOCK_MONOTONIC) - begun);
  return ASC_OK;
}

asc_status tracer_render_adaptive(tracer *made, const tracer_adaptive_desc *desc, float *pixels, uint32_t *counts,
                                  tracer_cost *cost, asc_error *error) {
  if (!made || !desc || desc->struct_size != sizeof *desc || !desc->estimator || !pixels)
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "tracer_render_adaptive: the desc needs its struct_size and an estimator");
  asc_estimator_desc estimator;
  asc_sampler_desc sampling;
  asc_status status = asc_estimator_resolved(desc->estimator, &estimator);
  if (status == ASC_OK) status = asc_sampler_resolved(estimator.sampler, &sampling);
  if (status || estimator.channels != 3 || sampling.dimensions < tracer_dimensions(made))
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "tracer_render_adaptive: the estimator needs three channels, and a sampler of %u dimensions",
                    tracer_dimensions(made));
  crew_cost spent = {0};
  uint64_t samples = 0;
  const double begun = seconds(CLOCK_MONOTONIC);
  status = adaptive_render(made, desc->estimator, sampling.dimensions, desc->threads ? desc->threads : 1, pixels,
                           counts, &spent, &samples, NULL);
  const complaint_area area = {made->view.width, made->view.height, 0};
  if (status == ASC_OUT_OF_RANGE) return complain_of_sampler(estimator.sampler, area, status, error);
  /* Again, tile by tile, for the first pixel that fails. */
  if (status == ASC_NUMERIC)
    return adaptive_render(made, desc->estimator, sampling.dimensions, 1, pixels, counts, &spent, &samples, error);
  if (status)
    return asc_fail(error, status, status == ASC_OUT_OF_MEMORY ? "%s" : "the estimate failed: %s",
                    asc_status_text(status));
  status = complain_of_pixels(pixels, area, error);
  if (status) return status;
  if (cost) *cost = cost_of(made, samples, &spent, seconds(CLOCK_MONOTONIC) - begun);
  return ASC_OK;
}

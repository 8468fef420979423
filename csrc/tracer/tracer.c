/* Making a tracer, and dividing a picture among threads. */
#define _POSIX_C_SOURCE 200809L /* clock_gettime, pthreads */
#include "tracer.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <time.h>

#include "block.h"
#include "scene.h"

static double seconds(clockid_t clock) {
  struct timespec now;
  (void)clock_gettime(clock, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double tracer_thread_cpu_seconds(void) { return seconds(CLOCK_THREAD_CPUTIME_ID); }

uint32_t tracer_embree_version(void) { return RTC_VERSION; }

asc_status tracer_create(const asc_scene *scene, tracer **made, asc_error *error) {
  if (!scene || scene->struct_size != sizeof *scene || !made)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_create: the scene needs its struct_size");
  *made = NULL;
  tracer *fresh = calloc(1, sizeof *fresh);
  if (!fresh) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  asc_status status = tracer_take_appearance(fresh, scene, error);
  if (status == ASC_OK) {
    /* One thread builds, so that the structure, and with it which of two touching surfaces is met, is always the
     * same. */
    fresh->device = rtcNewDevice("threads=1,set_affinity=0,ignore_config_files=1");
    status = fresh->device ? tracer_take_geometry(fresh, scene, error)
                           : asc_fail(error, ASC_UNAVAILABLE, "Embree does not start on this machine");
  }
  if (status) {
    tracer_destroy(fresh);
    return status;
  }
  *made = fresh;
  return ASC_OK;
}

void tracer_destroy(tracer *made) {
  if (!made) return;
  if (made->scene) rtcReleaseScene(made->scene);
  if (made->device) rtcReleaseDevice(made->device);
  for (int kind = 0; kind < GEOMETRY_KINDS; kind++) free(made->material_of[kind]);
  free(made->materials);
  free(made->triangle_planes);
  free(made->disc_planes);
  free(made->balls);
  free(made->planes);
  free(made->lights);
  free(made);
}

/* What the threads of one picture share. */
typedef struct picture {
  const tracer *made;
  const asc_sampler *sampler;
  uint64_t samples; /* a pixel */
  float *pixels;
  atomic_uint next_row; /* of blocks */
  atomic_ullong shadow_rays;
  atomic_int status;
} picture;

typedef struct worker {
  picture *shared;
  double cpu_seconds;
  pthread_t thread;
} worker;

static void *work(void *argument) {
  worker *self = argument;
  picture *shared = self->shared;
  const double begun = tracer_thread_cpu_seconds();
  const asc_view *view = &shared->made->view;
  const uint32_t rows = (view->height + BLOCK_SIDE - 1) / BLOCK_SIDE;
  block_work *memory = block_work_make();
  if (!memory) atomic_store(&shared->status, ASC_OUT_OF_MEMORY);
  for (uint32_t row; memory && (row = atomic_fetch_add(&shared->next_row, 1)) < rows;) {
    for (uint32_t x = 0; x < view->width; x += BLOCK_SIDE) {
      asc_status status =
          block_render(shared->made, shared->sampler, shared->samples, x, row * BLOCK_SIDE, memory, shared->pixels);
      if (status) atomic_store(&shared->status, (int)status);
    }
  }
  if (memory) (void)atomic_fetch_add(&shared->shadow_rays, block_shadow_rays(memory));
  block_work_free(memory);
  self->cpu_seconds = tracer_thread_cpu_seconds() - begun;
  return NULL;
}

/* Runs the workers, the first of them in this thread; a thread that can't be had leaves its share to the others. */
static double run(picture *shared, worker *workers, uint32_t count) {
  uint32_t started = 1;
  for (uint32_t i = 0; i < count; i++) workers[i].shared = shared;
  while (started < count && pthread_create(&workers[started].thread, NULL, work, &workers[started]) == 0) started++;
  (void)work(&workers[0]);
  double cpu_seconds = workers[0].cpu_seconds;
  for (uint32_t i = 1; i < started; i++) {
    (void)pthread_join(workers[i].thread, NULL);
    cpu_seconds += workers[i].cpu_seconds;
  }
  return cpu_seconds;
}

asc_status tracer_render(tracer *made, const tracer_desc *desc, float *pixels, tracer_cost *cost, asc_error *error) {
  if (!made || !desc || desc->struct_size != sizeof *desc || !desc->sampler || !pixels)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_render: the desc needs its struct_size and a sampler");
  asc_sampler_desc sampling;
  asc_status status = asc_sampler_resolved(desc->sampler, &sampling);
  if (status || sampling.dimensions < 2)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "tracer_render: the sampler needs two dimensions");
  if (asc_sampler_traits(desc->sampler) & ASC_TRAIT_WEIGHTED)
    return asc_fail(error, ASC_UNSUPPORTED, "the tracer takes samplers whose points weigh the same");
  const uint32_t threads = desc->threads ? desc->threads : 1;
  worker *workers = calloc(threads, sizeof *workers);
  if (!workers) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  picture shared = {.made = made, .sampler = desc->sampler, .samples = sampling.samples, .pixels = pixels};
  const double begun = seconds(CLOCK_MONOTONIC);
  const double cpu_seconds = run(&shared, workers, threads);
  free(workers);
  status = (asc_status)atomic_load(&shared.status);
  if (status) return asc_fail(error, status, "the sampler failed: %s", asc_status_text(status));
  if (cost) {
    const uint64_t samples = sampling.samples * made->view.width * made->view.height;
    *cost = (tracer_cost){samples,
                          samples,
                          cpu_seconds,
                          seconds(CLOCK_MONOTONIC) - begun,
                          made->build_cpu_seconds,
                          atomic_load(&shared.shadow_rays)};
  }
  return ASC_OK;
}

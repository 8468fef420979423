#include "crew.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "scene.h"

typedef struct crew {
  const tracer *made;
  crew_unit unit;
  void *job;
  uint32_t count;
  atomic_ullong next;
  atomic_int status;
} crew;

typedef struct worker {
  crew *shared;
  double cpu_seconds;
  ray_counts rays;
  pthread_t thread;
} worker;

static void *work(void *argument) {
  worker *self = argument;
  crew *shared = self->shared;
  const double begun = tracer_thread_cpu_seconds();
  block_work *memory = block_work_make(shared->made);
  asc_status status = memory ? ASC_OK : ASC_OUT_OF_MEMORY;
  for (uint64_t unit; !status && (unit = atomic_fetch_add(&shared->next, 1)) < shared->count;) {
    status = (asc_status)atomic_load(&shared->status);
    if (status == ASC_OK) status = shared->unit(shared->job, (uint32_t)unit, memory);
  }
  if (status) atomic_store(&shared->status, (int)status);
  if (memory) self->rays = block_rays(memory);
  block_work_free(memory);
  self->cpu_seconds = tracer_thread_cpu_seconds() - begun;
  return NULL;
}

static void add_cost(crew_cost *cost, const worker *from) {
  cost->cpu_seconds += from->cpu_seconds;
  cost->rays.reflection += from->rays.reflection;
  cost->rays.bounce += from->rays.bounce;
  cost->rays.shadow += from->rays.shadow;
}

asc_status crew_run(const tracer *made, uint32_t threads, uint32_t count, crew_unit unit, void *job, crew_cost *cost) {
  worker *workers = calloc(threads, sizeof *workers);
  if (!workers) return ASC_OUT_OF_MEMORY;
  crew shared = {.made = made, .unit = unit, .job = job, .count = count};
  for (uint32_t i = 0; i < threads; i++) workers[i].shared = &shared;
  /* The first works in this thread; a thread that can't be had leaves its share to the others. */
  uint32_t started = 1;
  while (started < threads && pthread_create(&workers[started].thread, NULL, work, &workers[started]) == 0) started++;
  (void)work(&workers[0]);
  for (uint32_t i = 0; i < started; i++) {
    if (i > 0) (void)pthread_join(workers[i].thread, NULL);
    add_cost(cost, &workers[i]);
  }
  free(workers);
  return (asc_status)atomic_load(&shared.status);
}

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
  atomic_ullong shadow_rays;
  atomic_int status;
} crew;

typedef struct worker {
  crew *shared;
  double cpu_seconds;
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
  if (memory) (void)atomic_fetch_add(&shared->shadow_rays, block_shadow_rays(memory));
  block_work_free(memory);
  self->cpu_seconds = tracer_thread_cpu_seconds() - begun;
  return NULL;
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
  cost->cpu_seconds += workers[0].cpu_seconds;
  for (uint32_t i = 1; i < started; i++) {
    (void)pthread_join(workers[i].thread, NULL);
    cost->cpu_seconds += workers[i].cpu_seconds;
  }
  free(workers);
  cost->shadow_rays += atomic_load(&shared.shadow_rays);
  return (asc_status)atomic_load(&shared.status);
}

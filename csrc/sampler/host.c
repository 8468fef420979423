#define _GNU_SOURCE /* syscall, sched_setaffinity */
#include <linux/futex.h>
#include <pthread.h>
#include <sched.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "remote.h"

#define FOREVER 3600.0 /* s */

void asc_remote_sleep(_Atomic uint32_t *turn, uint32_t old, double longest) {
  const struct timespec limit = {(time_t)longest, (long)((longest - (double)(time_t)longest) * 1e9)};
  (void)syscall(SYS_futex, turn, FUTEX_WAIT, old, &limit, NULL, 0);
}

void asc_remote_say(_Atomic uint32_t *turn, uint32_t now) {
  atomic_store(turn, now);
  (void)syscall(SYS_futex, turn, FUTEX_WAKE, 1, NULL, NULL, 0);
}

static double seconds(clockid_t clock) {
  struct timespec time;
  (void)clock_gettime(clock, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

double asc_remote_now(void) { return seconds(CLOCK_MONOTONIC); }

void *asc_remote_map(int memory, size_t *bytes) {
  struct stat of;
  if (fstat(memory, &of) || (size_t)of.st_size < asc_plugin_memory(1)) return NULL;
  *bytes = (size_t)of.st_size;
  void *mapped = mmap(NULL, *bytes, PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
  return mapped == MAP_FAILED ? NULL : mapped;
}

static const asc_sampler_interface *served;

/* --- the table ------------------------------------------------------------------------------------------------------
 */

static int copied(char *into, size_t capacity, const char *text) {
  const size_t length = strnlen(text, capacity);
  if (length == capacity) return 0;
  memcpy(into, text, length + 1);
  return 1;
}

static asc_status describe(const char *path, asc_remote_table *table) {
  asc_status status = asc_plugin_open(path, &served, &table->error);
  if (status) return status;
  int fits = copied(table->name, sizeof table->name, served->name) &&
             copied(table->title, sizeof table->title, served->title) &&
             copied(table->source, sizeof table->source, served->source);
  table->has_weights = served->weights != NULL;
  table->parameter_count = (uint32_t)served->parameter_count;
  for (size_t i = 0; i < served->parameter_count; i++) {
    const asc_parameter *from = &served->parameters[i];
    asc_remote_parameter *to = &table->parameters[i];
    fits = fits && copied(to->name, sizeof to->name, from->name) && copied(to->text, sizeof to->text, from->text) &&
           copied(to->choices, sizeof to->choices, from->choices ? from->choices : "");
    to->kind = (uint32_t)from->kind;
    to->minimum = from->minimum;
    to->maximum = from->maximum;
    to->fallback = from->fallback;
  }
  return fits ? ASC_OK
              : asc_fail(&table->error, ASC_PLUGIN,
                         "%s: a text of its table is too long (name %zu bytes, title %zu, source %zu; of a parameter "
                         "name %zu, choices %zu, text %zu)",
                         path, sizeof table->name - 1, sizeof table->title - 1, sizeof table->source - 1,
                         sizeof table->parameters->name - 1, sizeof table->parameters->choices - 1,
                         sizeof table->parameters->text - 1);
}

/* --- questions ------------------------------------------------------------------------------------------------------
 */

static asc_status create(asc_remote_channel *channel) {
  const asc_sampler_config config = {sizeof config, channel->samples, channel->dimensions, channel->seed,
                                     channel->data};
  asc_sampler_state made = {0};
  const asc_status status = served->create(&config, &made, &channel->error);
  struct rlimit limit;
  if (status == ASC_OUT_OF_MEMORY && !getrlimit(RLIMIT_AS, &limit) && limit.rlim_cur != RLIM_INFINITY)
    (void)asc_fail(&channel->error, status, "out of memory: the plugin may take %.3g GiB",
                   (double)limit.rlim_cur / (1024.0 * 1024.0 * 1024.0));
  channel->state = (uint64_t)(uintptr_t)made.state;
  channel->traits = made.traits;
  channel->index_end = made.index_end;
  return status;
}

static asc_status answer(asc_remote_channel *channel) {
  void *state = (void *)(uintptr_t)channel->state; /* NOLINT(performance-no-int-to-ptr): the own pointer, come back */
  switch (channel->question) {
  case ASC_REMOTE_CREATE: return create(channel);
  case ASC_REMOTE_DESTROY: served->destroy(state); return ASC_OK;
  case ASC_REMOTE_FILL:
    return asc_fill_area_of(served, state, &channel->range, channel->columns, channel->first, channel->pixels,
                            channel->data);
  case ASC_REMOTE_WEIGHTS:
    return served->weights(state, channel->range.first_sample, channel->range.sample_count, channel->data);
  default: return ASC_INVALID_ARGUMENT;
  }
}

/* Has this thread run where its client does, which waits meanwhile: to wake another processor takes ten times as long.
 */
static void follow(int32_t *own, int32_t client) {
  if (client == *own || client < 0 || client >= CPU_SETSIZE) return;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET((size_t)client, &one);
  (void)sched_setaffinity(0, sizeof one, &one);
  *own = client;
}

static void *serve(void *argument) {
  asc_remote_channel *channel = argument;
  int32_t processor = -1;
  for (;;) {
    uint32_t turn;
    while ((turn = atomic_load(&channel->turn)) != ASC_REMOTE_ASKED) asc_remote_sleep(&channel->turn, turn, FOREVER);
    follow(&processor, channel->processor);
    const double begun = seconds(CLOCK_THREAD_CPUTIME_ID);
    channel->status = (uint32_t)answer(channel);
    channel->seconds = seconds(CLOCK_THREAD_CPUTIME_ID) - begun;
    asc_remote_say(&channel->turn, ASC_REMOTE_ANSWERED);
  }
  return NULL;
}

asc_status asc_plugin_serve(int memory, const char *path, asc_error *error) {
  size_t bytes;
  void *shared = asc_remote_map(memory, &bytes);
  if (!shared) return asc_fail(error, ASC_INVALID_ARGUMENT, "the memory to be shared cannot be mapped");
  asc_remote_table *table = shared;
  table->status = (uint32_t)describe(path, table);
  const size_t channels = (bytes - asc_plugin_memory(0)) / sizeof(asc_remote_channel);
  for (size_t i = 0; i < channels && !table->status; i++) {
    pthread_t thread;
    const int failed = pthread_create(&thread, NULL, serve, &asc_remote_channels(shared)[i]);
    if (failed) table->status = (uint32_t)asc_fail(&table->error, ASC_PLUGIN, "%s: no thread to serve it", path);
  }
  asc_remote_say(&table->turn, ASC_REMOTE_ANSWERED);
  return (asc_status)table->status;
}

/* Plugins in a process of their own, its client's side under the sanitizers: the plugin's own numbers, ends of the host
 * at any time, and hosts that lie. */
#define _GNU_SOURCE /* memfd_create, kill */
#include "../../csrc/sampler/remote.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "threads_alone.h"

#define PATH ".build/plugins/kronecker.so"
#define CHANNELS 3 /* fewer than threads */
#define THREADS 5
#define LIMIT 20.0 /* s */

typedef struct host {
  pid_t process;
  int memory, alive;
} host;

typedef void host_program(int memory);

static void serve(int memory) { (void)asc_plugin_serve(memory, PATH, NULL); }

static host begin(host_program *program) {
  int ends[2];
  assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
  const int memory = memfd_create("test", MFD_CLOEXEC);
  assert_int_equal(ftruncate(memory, (off_t)asc_plugin_memory(CHANNELS)), 0);
  const pid_t process = fork();
  assert_true(process >= 0);
  if (process == 0) {
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL); /* where a test fails before it ends the host */
    (void)close(ends[0]);
    program(memory);
    char byte;
    (void)!read(ends[1], &byte, 1); /* until the client ends */
    _exit(0);
  }
  (void)close(ends[1]);
  return (host){process, memory, ends[0]};
}

static void end(host *ended) {
  (void)kill(ended->process, SIGKILL);
  assert_int_equal(waitpid(ended->process, NULL, 0), ended->process);
  (void)close(ended->memory);
  (void)close(ended->alive);
}

static asc_status connected(const host *to, const char *path, double limit, asc_error *error) {
  return asc_plugin_connect(to->memory, to->alive, path, limit, error);
}

static asc_sampler *made(const char *spec, uint64_t samples) {
  asc_sampler *sampler = NULL;
  asc_error error;
  const asc_sampler_desc desc = {sizeof desc, spec, samples, 5, 3};
  if (asc_sampler_create(&desc, &sampler, &error)) fail_msg("%s", error.text);
  return sampler;
}

/* --- the same numbers -----------------------------------------------------------------------------------------------
 */

typedef struct asker {
  const asc_sampler *sampler;
  const asc_sampler_interface *table;
  const void *state;
  int wrong;
  asc_status status;
} asker;

#define PIXELS 6
#define SAMPLES 40

static void *ask(void *argument) {
  asker *self = argument;
  double points[PIXELS * SAMPLES * 5], expected[PIXELS * SAMPLES * 5];
  for (uint32_t i = 0; i < 60 && !self->status && !self->wrong; i++) {
    const asc_range range = {-3, (int32_t)i, i, SAMPLES - i % 2, i % 4, 5 - i % 4};
    const uint32_t columns = 1 + i % PIXELS;
    self->status = i % 3 ? asc_sampler_fill_area(self->sampler, &range, columns, 2, PIXELS, points)
                         : asc_sampler_fill_pixels(self->sampler, &range, PIXELS, points);
    const size_t each = range.sample_count * range.dimension_count;
    for (uint32_t pixel = 0; pixel < PIXELS; pixel++) {
      asc_range one = range;
      one.pixel_x += (int32_t)(i % 3 ? (2 + pixel) % columns : pixel);
      one.pixel_y += (int32_t)(i % 3 ? (2 + pixel) / columns : 0);
      (void)self->table->fill(self->state, &one, expected + pixel * each);
    }
    self->wrong = !self->status && memcmp(points, expected, PIXELS * each * sizeof *points) != 0;
  }
  return NULL;
}

static void a_host_gives_its_plugins_numbers_to_all_threads(void **unused) {
  (void)unused;
  host first = begin(serve);
  asc_error error;
  if (connected(&first, PATH, LIMIT, &error)) fail_msg("%s", error.text);
  asc_sampler *sampler = made("kronecker:shift=0.25", 1000);
  assert_true(asc_sampler_traits(sampler) & ASC_TRAIT_DISTANT);

  const asc_sampler_interface *table;
  assert_int_equal(asc_plugin_open(PATH, &table, &error), ASC_OK);
  const double shift = 0.25;
  const asc_sampler_config config = {sizeof config, 1000, 5, 3, &shift};
  asc_sampler_state own;
  assert_int_equal(table->create(&config, &own, &error), ASC_OK);
  pthread_t threads[THREADS];
  asker askers[THREADS];
  for (int i = 0; i < THREADS; i++) {
    askers[i] = (asker){sampler, table, own.state, 0, ASC_OK};
    assert_int_equal(pthread_create(&threads[i], NULL, ask, &askers[i]), 0);
  }
  for (int i = 0; i < THREADS; i++) {
    assert_int_equal(pthread_join(threads[i], NULL), 0);
    assert_int_equal(askers[i].status, ASC_OK);
    assert_false(askers[i].wrong);
  }
  table->destroy(own.state);

  double point[5];
  const asc_range far = {INT32_MAX, INT32_MAX, 0, 1, 0, 5};
  assert_int_equal(asc_sampler_fill_area(sampler, &far, 1, 0, 1, point), ASC_OK);
  assert_int_equal(asc_sampler_fill_area(sampler, &far, 2, 0, 1, point), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_sampler_fill_area(sampler, &far, 1, 1, 1, point), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_sampler_fill_area(sampler, &far, 0, 0, 1, point), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_sampler_fill_area(sampler, &far, 1, SIZE_MAX, 1, point), ASC_INVALID_ARGUMENT);
  asc_sampler_destroy(sampler);
  end(&first);
}

/* --- ends -----------------------------------------------------------------------------------------------------------
 */

static void *ask_until_it_ends(void *argument) {
  asker *self = argument;
  double points[10];
  const asc_range range = {0, 0, 0, 2, 0, 5};
  while (self->status == ASC_OK) self->status = asc_sampler_fill(self->sampler, &range, points);
  return NULL;
}

/* Of the plugin that the test before connected. */
static void a_host_that_ends_is_an_error_until_there_is_another(void **unused) {
  (void)unused;
  host first = begin(serve), second = begin(serve); /* before there are threads */
  asc_error error;
  assert_int_equal(connected(&first, PATH, LIMIT, &error), ASC_OK);
  asc_sampler *sampler = made("kronecker", 8);
  pthread_t threads[THREADS];
  asker askers[THREADS];
  for (int i = 0; i < THREADS; i++) {
    askers[i] = (asker){.sampler = sampler};
    assert_int_equal(pthread_create(&threads[i], NULL, ask_until_it_ends, &askers[i]), 0);
  }
  end(&first);
  for (int i = 0; i < THREADS; i++) {
    assert_int_equal(pthread_join(threads[i], NULL), 0);
    assert_int_equal(askers[i].status, ASC_ENDED);
  }
  const asc_sampler_desc desc = {sizeof desc, "kronecker", 8, 5, 3};
  asc_sampler *none = NULL;
  assert_int_equal(asc_sampler_create(&desc, &none, &error), ASC_ENDED);
  assert_non_null(strstr(error.text, PATH));

  assert_int_equal(connected(&second, PATH, LIMIT, &error), ASC_OK);
  asc_sampler *after = made("kronecker", 8);
  double points[10];
  const asc_range range = {0, 0, 0, 2, 0, 5};
  assert_int_equal(asc_sampler_fill(after, &range, points), ASC_OK);
  assert_int_equal(asc_sampler_fill(sampler, &range, points), ASC_ENDED); /* its state was the first host's */
  asc_sampler_destroy(sampler);
  end(&second);
  asc_sampler_destroy(after);
}

static void sleep_for_ever(int memory) {
  (void)memory;
  for (;;) (void)pause();
}

static void hosts_that_never_begin_are_none(void **unused) {
  (void)unused;
  host silent = begin(sleep_for_ever);
  asc_error error;
  assert_int_equal(connected(&silent, "silent", 0.2, &error), ASC_PLUGIN);
  end(&silent);
  assert_int_equal(connected(&(host){0, -1, -1}, "none", LIMIT, &error), ASC_PLUGIN);
  assert_int_equal(asc_plugin_connect(0, 0, NULL, LIMIT, &error), ASC_INVALID_ARGUMENT);
  assert_int_equal(asc_plugin_connect(0, 0, "none", 0.0, &error), ASC_INVALID_ARGUMENT);
}

/* --- lies -----------------------------------------------------------------------------------------------------------
 */

/* A table of its own, and answers that no plugin of ours gives: the status `lie`, with all else that is in an answer.
 */
static void answer(int memory, const char *name, uint32_t lie) {
  size_t bytes;
  asc_remote_table *table = asc_remote_map(memory, &bytes);
  memset(table->title, 'x', sizeof table->title); /* ends nowhere */
  memset(table->source, 'x', sizeof table->source);
  (void)strcpy(table->name, name);
  table->has_weights = 1;
  asc_remote_say(&table->turn, ASC_REMOTE_ANSWERED);
  asc_remote_channel *channels = asc_remote_channels(table);
  for (;;)
    for (int i = 0; i < CHANNELS; i++) {
      if (atomic_load(&channels[i].turn) != ASC_REMOTE_ASKED) continue;
      channels[i].status = channels[i].question == ASC_REMOTE_CREATE ? ASC_OK : lie;
      if (lie == ASC_NUMERIC && channels[i].question == ASC_REMOTE_CREATE) {
        channels[i].status = ASC_UNSUPPORTED;
        memset(&channels[i].error, 'e', sizeof channels[i].error);
      }
      channels[i].traits = UINT32_MAX;
      channels[i].index_end = UINT64_MAX;
      channels[i].seconds = HUGE_VAL;
      channels[i].pixels = channels[i].first = channels[i].range.sample_count = SIZE_MAX;
      for (size_t d = 0; d < 64; d++) channels[i].data[d] = -HUGE_VAL;
      asc_remote_say(&channels[i].turn, ASC_REMOTE_ANSWERED);
    }
}

static void lie_in_statuses(int memory) { answer(memory, "liar", 77); }
static void lie_in_values(int memory) { answer(memory, "fabulist", ASC_OK); }
static void lie_in_messages(int memory) { answer(memory, "babbler", ASC_NUMERIC); }

static void lie_in_counts(int memory) {
  size_t bytes;
  asc_remote_table *table = asc_remote_map(memory, &bytes);
  (void)strcpy(table->name, "counter");
  table->parameter_count = UINT32_MAX;
  asc_remote_say(&table->turn, ASC_REMOTE_ANSWERED);
}

static void hosts_that_lie_are_not_believed(void **unused) {
  (void)unused;
  asc_error error;
  double points[10];
  const asc_range range = {0, 0, 0, 2, 0, 5};

  host liar = begin(lie_in_statuses);
  assert_int_equal(connected(&liar, "liar.so", LIMIT, &error), ASC_OK);
  asc_sampler *sampler = made("liar", 8);
  assert_int_equal(asc_sampler_fill(sampler, &range, points), ASC_ENDED);
  asc_sampler_destroy(sampler);
  end(&liar);

  const double before = asc_plugin_seconds(), begun = asc_remote_now();
  host fabulist = begin(lie_in_values);
  assert_int_equal(connected(&fabulist, "fabulist.so", LIMIT, &error), ASC_OK);
  sampler = made("fabulist", 8);
  assert_int_equal(asc_sampler_fill(sampler, &range, points), ASC_OUT_OF_RANGE);
  assert_int_equal(asc_sampler_weights(sampler, 0, 8, points), ASC_NUMERIC);
  const size_t index = asc_sampler_count() - 1;
  asc_sampler_info info;
  assert_int_equal(asc_sampler_describe(index, &info), ASC_OK);
  assert_string_equal(info.name, "fabulist");
  assert_int_equal(strlen(info.title), sizeof((asc_remote_table *)NULL)->title - 1);
  assert_true(asc_plugin_seconds() > before);
  assert_true(asc_plugin_seconds() - before <= asc_remote_now() - begun);
  asc_sampler_destroy(sampler);
  end(&fabulist);

  host babbler = begin(lie_in_messages);
  assert_int_equal(connected(&babbler, "babbler.so", LIMIT, &error), ASC_OK);
  const asc_sampler_desc desc = {sizeof desc, "babbler", 8, 5, 3};
  assert_int_equal(asc_sampler_create(&desc, &sampler, &error), ASC_UNSUPPORTED);
  assert_int_equal(strlen(error.text), sizeof error.text - 1);
  end(&babbler);

  host counter = begin(lie_in_counts);
  assert_int_equal(connected(&counter, "counter.so", LIMIT, &error), ASC_PLUGIN);
  assert_non_null(strstr(error.text, "at most 64 parameters"));
  end(&counter);

  host other = begin(lie_in_values); /* another table than that of the path's plugin */
  assert_int_equal(connected(&other, PATH, LIMIT, &error), ASC_PLUGIN);
  assert_non_null(strstr(error.text, "another table"));
  end(&other);
}

int main(void) {
  take_threads_alone();
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_host_gives_its_plugins_numbers_to_all_threads),
      cmocka_unit_test(a_host_that_ends_is_an_error_until_there_is_another),
      cmocka_unit_test(hosts_that_never_begin_are_none),
      cmocka_unit_test(hosts_that_lie_are_not_believed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

/* OSMesa's contexts in several threads of one process, as a program has them that calls the Python interface from
 * threads of its own; the workers of the harness draw in one thread each. As the harness has it, LP_NUM_THREADS is 0,
 * and llvmpipe has no thread of its own. */
#define _POSIX_C_SOURCE 200112L /* setenv */

#include <dirent.h>
#include <pthread.h>
#include <stdio.h>

#include "raster_scenes.h"
#include "threads_alone.h"

enum { THREADS = 4, REPEATS = 3 };

typedef struct drawing {
  float pixels[REPEATS][3 * PIXELS];
  asc_status status;
} drawing;

static asc_status draw_once(const stage *s, float *pixels) {
  static const double offsets[][2] = {{0.3, 0.6}, {0.7, 0.1}};
  static const double weights[] = {0.5, 0.5};
  raster *made = NULL;
  asc_status status = raster_create(&s->scene, &made, NULL);
  for (uint32_t samples = 1; !status && samples <= 4; samples += 3) {
    const raster_desc desc = passes_of(samples, &offsets[0][0], weights, 2, samples == 4);
    status = raster_render(made, &desc, pixels, NULL, NULL);
  }
  raster_destroy(made);
  return status;
}

static stage *lit_stage(void) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t white = add_material(s, 0.1, 0.2, 0.3);
  for (int i = 0; i < 3; ++i) s->materials[white].albedo[i] = 0.8;
  add_disc(s, 8.3, 6.1, 4.7, white);
  add_sphere(s, 4.4, 1.2, 1.0, 2.3, white);
  (void)add_light(s, ASC_LIGHT_POINT, 3.0, 4.0, 9.0);
  return s;
}

/* Threads of this process that draw. It has others: of a sanitizer, and Mesa's "disk$0", which keeps shaders on disk.
 */
static int threads_of_llvmpipe(void) {
  int count = 0;
  DIR *tasks = opendir("/proc/self/task");
  assert_non_null(tasks);
  for (const struct dirent *each; (each = readdir(tasks));) {
    char path[300];
    char name[32] = "";
    (void)snprintf(path, sizeof path, "/proc/self/task/%s/comm", each->d_name);
    FILE *comm = each->d_name[0] == '.' ? NULL : fopen(path, "r");
    if (comm) {
      count += fgets(name, sizeof name, comm) && strstr(name, "llvmpipe") != NULL;
      (void)fclose(comm);
    }
  }
  (void)closedir(tasks);
  return count;
}

/* No assertion in here: cmocka's jump to the test's end, which is in another thread. */
static void *draw(void *argument) {
  drawing *self = argument;
  stage *s = lit_stage();
  for (int i = 0; i < REPEATS && !self->status; ++i) self->status = draw_once(s, self->pixels[i]);
  free(s);
  return NULL;
}

static void threads_with_contexts_of_their_own_draw_the_same(void **state) {
  (void)state;
  static drawing drawings[THREADS];
  static float alone[3 * PIXELS];
  pthread_t threads[THREADS];
  stage *s = lit_stage();
  assert_int_equal(draw_once(s, alone), ASC_OK);
  assert_int_equal(threads_of_llvmpipe(), 0);
  free(s);
  for (int t = 0; t < THREADS; ++t) assert_int_equal(pthread_create(&threads[t], NULL, draw, &drawings[t]), 0);
  for (int t = 0; t < THREADS; ++t) assert_int_equal(pthread_join(threads[t], NULL), 0);
  for (int t = 0; t < THREADS; ++t) {
    assert_int_equal(drawings[t].status, ASC_OK);
    for (int i = 0; i < REPEATS; ++i) assert_memory_equal(drawings[t].pixels[i], alone, sizeof alone);
  }
  assert_true(red_sum(alone) > 1.0);
}

int main(void) {
  (void)setenv("LP_NUM_THREADS", "0", 1);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_with_contexts_of_their_own_draw_the_same),
  };
  take_threads_alone();
  return cmocka_run_group_tests_name("raster, threads", tests, NULL, NULL);
}

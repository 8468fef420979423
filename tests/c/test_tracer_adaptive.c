/* Adaptive pictures in several threads: the same bits and counts as in one, and the same error. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "threads_alone.h"
#include "tracer.h"

/* Six tiles of 64, of which four are cut off. */
enum { W = 150, H = 70 };

static const char *const methods[] = {
    "whitted:depth=2", "kajiya:unbiased=1", "mitchell", "student-t:cells=2,margin=1", "chi-squared",
};

typedef struct picture {
  float pixels[H][W][3];
  uint32_t counts[H][W];
  tracer_cost cost;
} picture;

static asc_material zones(void) {
  return (asc_material){
      .emission = {1, 1, 1},
      .pattern = {ASC_PATTERN_ZONE_PLATE, 0.02, {30.1, 37.7, 0}, {0, 0.1, 0.2}, {1, 0.9, 0.5}},
  };
}

static asc_view view(void) {
  return (asc_view){.projection = ASC_ORTHOGRAPHIC,
                    .width = W,
                    .height = H,
                    .eye = {W / 2.0, H / 2.0, 10},
                    .right = {1, 0, 0},
                    .up = {0, 1, 0},
                    .forward = {0, 0, -1},
                    .half_width = W / 2.0,
                    .half_height = H / 2.0};
}

static tracer *traced(const asc_scene *scene) {
  tracer *made = NULL;
  asc_error error = {{0}};
  if (tracer_create(scene, &made, &error)) fail_msg("%s", error.text);
  return made;
}

static asc_sampler *sampler_of(uint64_t samples) {
  const asc_sampler_desc pattern = {sizeof pattern, "sobol:scramble=owen", samples, 2, 7};
  asc_sampler *sampler = NULL;
  assert_int_equal(asc_sampler_create(&pattern, &sampler, NULL), ASC_OK);
  return sampler;
}

static asc_estimator *estimator_of(const char *spec, const asc_sampler *sampler) {
  const asc_estimator_desc desc = {sizeof desc, spec, sampler, 3};
  asc_estimator *estimator = NULL;
  asc_error error = {{0}};
  if (asc_estimator_create(&desc, &estimator, &error)) fail_msg("%s: %s", spec, error.text);
  return estimator;
}

static void draw(tracer *made, const asc_estimator *estimator, uint32_t threads, picture *drawn) {
  const tracer_adaptive_desc desc = {sizeof desc, estimator, threads};
  asc_error error = {{0}};
  memset(drawn, 0xff, sizeof *drawn);
  if (tracer_render_adaptive(made, &desc, &drawn->pixels[0][0][0], &drawn->counts[0][0], &drawn->cost, &error))
    fail_msg("%s", error.text);
}

static bool differ(const uint32_t (*counts)[W]) {
  for (size_t i = 1; i < (size_t)W * H; i++)
    if (counts[i / W][i % W] != counts[0][0]) return true;
  return false;
}

static void threads_change_no_bit_and_no_count(void **state) {
  (void)state;
  static picture one, many;
  const asc_material material = zones();
  const asc_disc plate = {{75, 35, 0}, {0, 0, 1}, 60, 0};
  const asc_sphere ball = {{110, 20, 2}, 14.4, 0};
  const asc_scene scene = {.struct_size = sizeof scene,
                           .view = view(),
                           .materials = &material,
                           .material_count = 1,
                           .discs = &plate,
                           .disc_count = 1,
                           .spheres = &ball,
                           .sphere_count = 1};
  tracer *made = traced(&scene);
  asc_sampler *sampler = sampler_of(64);
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
    asc_estimator *estimator = estimator_of(methods[i], sampler);
    draw(made, estimator, 1, &one);
    assert_true(differ((const uint32_t(*)[W])one.counts));
    for (uint32_t threads = 2; threads <= 5; threads += 3) {
      draw(made, estimator, threads, &many);
      assert_memory_equal(one.pixels, many.pixels, sizeof one.pixels);
      assert_memory_equal(one.counts, many.counts, sizeof one.counts);
      assert_int_equal(one.cost.samples, many.cost.samples);
      assert_int_equal(one.cost.primary_rays, many.cost.primary_rays);
    }
    asc_estimator_destroy(estimator);
  }
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

/* Samples of 1e308 overflow the sums of all tiles: the first pixel is named, whichever thread met one first. */
static void threads_that_fail_name_the_first_pixel(void **state) {
  (void)state;
  static float pixels[H][W][3];
  asc_scene scene = {.struct_size = sizeof scene, .view = view()};
  scene.view.background[1] = 1e308;
  tracer *made = traced(&scene);
  asc_sampler *sampler = sampler_of(64);
  asc_estimator *estimator = estimator_of("kajiya", sampler);
  char first[sizeof(asc_error)] = "";
  for (uint32_t threads = 1; threads <= 5; threads += 2) {
    const tracer_adaptive_desc desc = {sizeof desc, estimator, threads};
    asc_error error = {{0}};
    assert_int_equal(tracer_render_adaptive(made, &desc, &pixels[0][0][0], NULL, NULL, &error), ASC_NUMERIC);
    if (threads == 1) (void)snprintf(first, sizeof first, "%s", error.text);
    assert_string_equal(error.text, first);
  }
  assert_non_null(strstr(first, "(0, 0)"));
  asc_estimator_destroy(estimator);
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_change_no_bit_and_no_count),
      cmocka_unit_test(threads_that_fail_name_the_first_pixel),
  };
  take_threads_alone();
  return cmocka_run_group_tests_name("tracer, adaptive", tests, NULL, NULL);
}

/* What deciding costs: the rate of adaptive modes, of at most 64 samples a pixel, beside that of 64 in every pixel. */
#include <stdio.h>

#include "bench_terrain.h"
#include "tracer.h"

#define WIDTH 512u
#define HEIGHT 384u

/* Samples a second, the best of a few rounds, and the samples a pixel. */
static int adapt(const asc_scene *scene, const char *spec) {
  static float pixels[WIDTH * HEIGHT * 3];
  const asc_sampler_desc pattern = {sizeof pattern, "sobol:scramble=owen", 64, 2, 1};
  asc_sampler *sampler = NULL;
  asc_estimator *estimator = NULL;
  tracer *made = NULL;
  if (asc_sampler_create(&pattern, &sampler, NULL)) return 1;
  const asc_estimator_desc wanted = {sizeof wanted, spec, sampler, 3};
  int failed = spec && asc_estimator_create(&wanted, &estimator, NULL);
  failed = failed || tracer_create(scene, &made, NULL);
  const tracer_desc uniform = {.struct_size = sizeof uniform, .sampler = sampler};
  const tracer_adaptive_desc adaptive = {.struct_size = sizeof adaptive, .estimator = estimator};
  tracer_cost cost = {0};
  double least = 1e9;
  for (int round = 0; round < 3 && !failed; round++) {
    failed = spec ? tracer_render_adaptive(made, &adaptive, pixels, NULL, &cost, NULL) != ASC_OK
                  : tracer_render(made, &uniform, pixels, &cost, NULL) != ASC_OK;
    if (cost.cpu_seconds < least) least = cost.cpu_seconds;
  }
  if (!failed)
    printf("  %-40s %6.1f Msample/s %6.1f samples a pixel %7.3f s a picture\n", spec ? spec : "uniform",
           (double)cost.samples / least / 1e6, (double)cost.samples / (WIDTH * HEIGHT), least);
  tracer_destroy(made);
  asc_estimator_destroy(estimator);
  asc_sampler_destroy(sampler);
  return failed;
}

int main(void) {
  static const char *const methods[] = {NULL,       "whitted",   "kajiya",
                                        "mitchell", "student-t", "student-t:batch=2,cells=4,margin=1.25,minimum=4"};
  asc_scene scene = make_terrain(WIDTH, HEIGHT);
  scene.lights = &terrain_sun;
  scene.light_count = 1;
  int failed = 0;
  printf("adaptive, with shadows, at most 64 samples a pixel\n");
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) failed |= adapt(&scene, methods[i]);
  return failed;
}

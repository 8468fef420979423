/* The tracer's rate as a share of a bare loop over Embree on the same rays, for each thing that a scene can ask for: a
 * generated mesh of 10^5 triangles, perspective, box filter, 16 samples a pixel, one thread. The rays of a picture are
 * kept as the tracer gives them to Embree, and the bare loop gives them to it again, to the same structure in the same
 * packets: rtcIntersect16 and, where there are shadows, rtcOccluded16. Both are measured in turn, in one run. */
#include <stdio.h>
#include <stdlib.h>

#include "bench_terrain.h"
#include "kept_rays.h"
#include "tracer.h"

#define WIDTH 320u
#define HEIGHT 240u
#define SAMPLES 16u
#define ROUNDS 11

static int by_value(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Renders and loops in turn, and prints the share: the median over rounds, and the extremes. */
static int compare(const char *what, const asc_scene *scene) {
  static float pixels[WIDTH * HEIGHT * 3];
  tracer *made = NULL;
  asc_sampler *sampler = NULL;
  asc_error error;
  if (tracer_create(scene, &made, &error)) return 1;
  const asc_sampler_desc pattern = {sizeof pattern, "sobol:scramble=owen", SAMPLES, tracer_dimensions(made), 1};
  if (asc_sampler_create(&pattern, &sampler, &error)) return 1;
  const tracer_desc desc = {.struct_size = sizeof desc, .sampler = sampler, .threads = 1};
  tracer_cost cost;
  if (!kept_begin()) return 1;
  if (tracer_render(made, &desc, pixels, &cost, &error)) return 1;
  kept_end();
  double shares[ROUNDS], bare_least = 1e9, tracer_least = 1e9;
  kept_counts kept;
  for (int round = 0; round < ROUNDS; round++) {
    const double bare_seconds = kept_loop(&kept);
    if (tracer_render(made, &desc, pixels, &cost, &error)) return 1;
    shares[round] = bare_seconds / cost.cpu_seconds;
    if (bare_seconds < bare_least) bare_least = bare_seconds;
    if (cost.cpu_seconds < tracer_least) tracer_least = cost.cpu_seconds;
  }
  qsort(shares, ROUNDS, sizeof *shares, by_value);
  const double rays = (double)(kept.intersected + kept.occluded);
  printf("  %-34s %2u %6.2f %5.0f %% %5.0f %% %8.1f %8.1f %7.1f %% (%.1f to %.1f)\n", what, tracer_dimensions(made),
         rays / 1e6, 100.0 * (double)kept.occluded / rays, 100.0 * (double)kept.hits / (double)kept.intersected,
         rays / bare_least / 1e6, rays / tracer_least / 1e6, 100.0 * shares[ROUNDS / 2], 100.0 * shares[0],
         100.0 * shares[ROUNDS - 1]);
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
  return 0;
}

/* --- the scenes ------------------------------------------------------------------------------------------------- */

static uint32_t all_move[TRIANGLES];

static asc_scene with_lens(asc_scene scene, uint32_t blades) {
  scene.view.lens_radius = 0.02;
  scene.view.focus_distance = 2.3;
  scene.view.blades = blades;
  return scene;
}

static asc_scene with_motion(asc_scene scene, const asc_motion *motion) {
  scene.view.shutter_close = 1.0;
  scene.motions = motion;
  scene.motion_count = 1;
  for (size_t i = 0; i < TRIANGLES; i++) all_move[i] = 1;
  scene.triangle_motion = all_move;
  return scene;
}

static asc_scene with_light(asc_scene scene, const asc_light *light) {
  scene.lights = light;
  scene.light_count = 1;
  return scene;
}

int main(void) {
  static const asc_motion translate = {.kind = ASC_MOTION_TRANSLATE, .by = {0.05, 0.01, 0.03}};
  static const asc_motion rotate = {.kind = ASC_MOTION_ROTATE, .axis = {0, 1, 0}, .angle = 0.1};
  static const asc_light square = {.kind = ASC_LIGHT_PARALLELOGRAM,
                                   .place = {-1.3, 0.8, -1.1},
                                   .intensity = {1, 1, 1},
                                   .inverse_square = 1,
                                   .edges = {{0.5, 0.1, 0}, {0, 0.2, 0.5}}};
  static const asc_light disc = {
      .kind = ASC_LIGHT_DISC, .place = {-1.3, 0.8, -1.1}, .intensity = {1, 1, 1}, .edges = {{0.3, 0, 0}, {0, 0, 0.3}}};
  static const asc_light ball = {
      .kind = ASC_LIGHT_SPHERE, .place = {-1.3, 0.8, -1.1}, .intensity = {1, 1, 1}, .inverse_square = 1, .radius = 0.3};
  const asc_scene plain = make_terrain(WIDTH, HEIGHT);
  printf("the tracer beside a bare loop over rtcIntersect16 and rtcOccluded16 on the same rays: %u triangles, %ux%u, "
         "%u samples a pixel,\nmedian of %d rounds and extremes\n"
         "  %-34s %2s %6s %7s %7s %8s %8s %9s\n",
         TRIANGLES, WIDTH, HEIGHT, SAMPLES, ROUNDS, "", "d", "Mrays", "shadow", "hit", "bare", "tracer", "share");
  int failed = compare("unlit", &plain);
  const asc_scene sunny = with_light(plain, &terrain_sun), lens = with_lens(plain, 0), blades = with_lens(plain, 6);
  failed |= compare("a lens", &lens) | compare("a lens of 6 blades", &blades);
  const asc_scene going = with_motion(plain, &translate), turning = with_motion(plain, &rotate);
  failed |= compare("translation", &going) | compare("rotation", &turning) | compare("a sun", &sunny);
  const asc_scene squared = with_light(plain, &square), round = with_light(plain, &disc),
                  bulb = with_light(plain, &ball);
  failed |= compare("a square light", &squared) | compare("a disc light", &round) | compare("a sphere light", &bulb);
  const asc_scene both = with_light(going, &square), all = with_lens(both, 0);
  failed |= compare("translation, a square light", &both) | compare("lens, translation, square light", &all);
  kept_free();
  return failed;
}

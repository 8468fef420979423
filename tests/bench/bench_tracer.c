/* The tracer's rate as a share of a bare loop over Embree on the same rays, for each thing that a scene can ask for: a
 * generated mesh of 10^5 triangles, perspective, box filter, 16 samples a pixel, one thread. The rays of a picture are
 * kept as the tracer gives them to Embree, and the bare loop gives them to it again, to the same structure in the same
 * packets: rtcIntersect16 and, where there are shadows, rtcOccluded16. Both are measured in turn, in one run. */
#define _GNU_SOURCE /* RTLD_NEXT */
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <stdalign.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench_terrain.h"
#include "tracer.h"

#define WIDTH 320u
#define HEIGHT 240u
#define SAMPLES 16u
#define ROUNDS 11

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* --- Embree's functions stand here in between, while a picture's rays are kept ---------------------------------- */

typedef void intersect_function(const int *, RTCScene, struct RTCIntersectContext *, struct RTCRayHit16 *);
typedef void occluded_function(const int *, RTCScene, struct RTCIntersectContext *, struct RTCRay16 *);

static intersect_function *embree_intersect;
static occluded_function *embree_occluded;

/* Origins, directions, tnear, tfar and time, in the order of `fields`. */
#define FIELDS 9

/* What all lanes share is one number, or reading what was kept would cost more than making it did. */
typedef struct kept_packet {
  float shared[FIELDS];
  uint16_t varies, valid; /* bits: fields, lanes */
  uint8_t shadows, coherent;
  size_t values; /* where those of the fields that vary begin, 16 each */
} kept_packet;

static struct {
  int keeping;
  RTCScene scene;
  kept_packet *packets;
  size_t count, room;
  float *values;
  size_t value_count, value_room;
  uint64_t rays[2]; /* of rtcIntersect16, of rtcOccluded16 */
} kept;

static void fields(struct RTCRay16 *ray, float *found[FIELDS]) {
  float *const all[FIELDS] = {ray->org_x, ray->org_y, ray->org_z, ray->dir_x, ray->dir_y,
                              ray->dir_z, ray->tnear, ray->tfar,  ray->time};
  memcpy(found, all, sizeof all);
}

static void *grown(void *from, size_t *room, size_t count, size_t size) {
  if (count <= *room) return from;
  *room = 2 * count;
  void *made = realloc(from, *room * size);
  if (!made) abort();
  return made;
}

static void keep(const int *valid, RTCScene scene, const struct RTCIntersectContext *context, struct RTCRay16 *ray,
                 uint8_t shadows) {
  float *from[FIELDS];
  fields(ray, from);
  kept.packets = grown(kept.packets, &kept.room, kept.count + 1, sizeof *kept.packets);
  kept.values = grown(kept.values, &kept.value_room, kept.value_count + FIELDS * 16u, sizeof *kept.values);
  kept_packet *into = &kept.packets[kept.count++];
  kept.scene = scene;
  *into = (kept_packet){.shadows = shadows, .values = kept.value_count};
  into->coherent = (context->flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT) != 0;
  int first = 15;
  for (int i = 15; i >= 0; i--) {
    if (!valid[i]) continue;
    into->valid |= (uint16_t)(1u << i);
    first = i;
  }
  kept.rays[shadows] += (uint64_t)__builtin_popcount(into->valid);
  for (int k = 0; k < FIELDS; k++) {
    into->shared[k] = from[k][first];
    for (int i = 0; i < 16; i++)
      if (valid[i] && from[k][i] != from[k][first]) into->varies |= (uint16_t)(1u << k);
    if (!((into->varies >> k) & 1)) continue;
    memcpy(kept.values + kept.value_count, from[k], 16 * sizeof(float));
    kept.value_count += 16;
  }
}

void rtcIntersect16(const int *valid, RTCScene scene, struct RTCIntersectContext *context, struct RTCRayHit16 *rays) {
  if (kept.keeping) keep(valid, scene, context, &rays->ray, 0);
  embree_intersect(valid, scene, context, rays);
}

void rtcOccluded16(const int *valid, RTCScene scene, struct RTCIntersectContext *context, struct RTCRay16 *rays) {
  if (kept.keeping) keep(valid, scene, context, rays, 1);
  embree_occluded(valid, scene, context, rays);
}

static int find_embree(void) {
  void *intersect = dlsym(RTLD_NEXT, "rtcIntersect16"), *occluded = dlsym(RTLD_NEXT, "rtcOccluded16");
  memcpy(&embree_intersect, &intersect, sizeof intersect);
  memcpy(&embree_occluded, &occluded, sizeof occluded);
  return intersect && occluded;
}

/* --- the bare loop ---------------------------------------------------------------------------------------------- */

static void take(const kept_packet *from, struct RTCRay16 *ray, int *valid) {
  const float *values = kept.values + from->values;
  float *to[FIELDS];
  fields(ray, to);
  for (int i = 0; i < 16; i++) valid[i] = -((from->valid >> i) & 1);
  for (int k = 0; k < FIELDS; k++) {
    if ((from->varies >> k) & 1) {
      memcpy(to[k], values, 16 * sizeof(float));
      values += 16;
    } else
      for (int i = 0; i < 16; i++) to[k][i] = from->shared[k];
  }
}

/* CPU seconds. The light's distances are as they were: tfar goes in again for each packet. */
static double bare_loop(uint64_t *hits) {
  alignas(64) static struct RTCRayHit16 rays;
  alignas(64) static struct RTCRay16 shadows;
  alignas(64) static int valid[16];
  struct RTCIntersectContext contexts[2];
  for (int i = 0; i < 2; i++) rtcInitIntersectContext(&contexts[i]);
  contexts[1].flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (int i = 0; i < 16; i++) {
    rays.ray.mask[i] = shadows.mask[i] = UINT32_MAX;
    rays.ray.flags[i] = shadows.flags[i] = 0;
  }
  *hits = 0;
  const double begun = now();
  for (size_t i = 0; i < kept.count; i++) {
    const kept_packet *from = &kept.packets[i];
    if (from->shadows) {
      take(from, &shadows, valid);
      embree_occluded(valid, kept.scene, &contexts[from->coherent], &shadows);
      continue;
    }
    take(from, &rays.ray, valid);
    for (int k = 0; k < 16; k++) rays.hit.geomID[k] = rays.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    embree_intersect(valid, kept.scene, &contexts[from->coherent], &rays);
    for (int k = 0; k < 16; k++) *hits += valid[k] && rays.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
  }
  return now() - begun;
}

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
  kept.keeping = 1;
  kept.count = kept.value_count = 0;
  kept.rays[0] = kept.rays[1] = 0;
  if (tracer_render(made, &desc, pixels, &cost, &error)) return 1;
  kept.keeping = 0;
  double shares[ROUNDS], bare_least = 1e9, tracer_least = 1e9;
  uint64_t hits = 0;
  for (int round = 0; round < ROUNDS; round++) {
    const double bare_seconds = bare_loop(&hits);
    if (tracer_render(made, &desc, pixels, &cost, &error)) return 1;
    shares[round] = bare_seconds / cost.cpu_seconds;
    if (bare_seconds < bare_least) bare_least = bare_seconds;
    if (cost.cpu_seconds < tracer_least) tracer_least = cost.cpu_seconds;
  }
  qsort(shares, ROUNDS, sizeof *shares, by_value);
  const double rays = (double)(kept.rays[0] + kept.rays[1]);
  printf("  %-34s %2u %6.2f %5.0f %% %5.0f %% %8.1f %8.1f %7.1f %% (%.1f to %.1f)\n", what, tracer_dimensions(made),
         rays / 1e6, 100.0 * (double)kept.rays[1] / rays, 100.0 * (double)hits / (double)kept.rays[0],
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
  if (!find_embree()) return 1;
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
  free(kept.packets);
  free(kept.values);
  return failed;
}

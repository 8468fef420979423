/* The tracer's rate as a share of a bare loop over Embree on the same rays: a generated mesh of 10^5 triangles,
 * perspective, box filter, 16 samples a pixel, one thread. Unlit against rtcIntersect16; under a sun with hard shadows
 * against rtcIntersect16 and rtcOccluded16. Both are measured in turn, in one run. Then what deciding costs: the rate
 * of adaptive modes, of at most 64 samples a pixel, beside that of 64 in every pixel. */
#define _POSIX_C_SOURCE 200809L
#include <embree3/rtcore.h>
#include <math.h>
#include <stdalign.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "tracer.h"

#define WIDTH 512u
#define HEIGHT 384u
#define SAMPLES 16u
#define CELLS 224u /* a side: 2 * 224^2 = 100,352 triangles */
#define TRIANGLES (2u * CELLS * CELLS)
#define PACKETS (WIDTH * HEIGHT * SAMPLES / 16u)
#define ROUNDS 9

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double height_at(double x, double y) {
  return 0.21 * sin(5.1 * x + 0.3) * cos(4.3 * y) + 0.07 * sin(17.7 * x + 9.1 * y) + 0.02 * cos(41.0 * y - 13.0 * x);
}

static double vertices[TRIANGLES * 9];
static uint32_t materials_of[TRIANGLES];

static void corner(size_t at, uint32_t i, uint32_t j) {
  const double x = 2.0 * i / CELLS - 1.0, y = 2.0 * j / CELLS - 1.0;
  vertices[at] = x;
  vertices[at + 1] = height_at(x, y);
  vertices[at + 2] = y;
}

static void make_mesh(void) {
  size_t at = 0;
  for (uint32_t j = 0; j < CELLS; j++) {
    for (uint32_t i = 0; i < CELLS; i++) {
      const uint32_t order[6][2] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j}, {i + 1, j + 1}, {i, j + 1}};
      for (int k = 0; k < 6; k++, at += 3) corner(at, order[k][0], order[k][1]);
    }
  }
  for (size_t i = 0; i < TRIANGLES; i++) materials_of[i] = (uint32_t)(i % 7);
}

/* The same directions in the same packets as the tracer's: blocks of 4 x 4 pixels, 16 samples each. */
static float directions[PACKETS][2][16];

static void make_directions(const asc_view *view, const asc_sampler *sampler) {
  size_t packet = 0;
  for (uint32_t block_y = 0; block_y < HEIGHT; block_y += 4) {
    for (uint32_t block_x = 0; block_x < WIDTH; block_x += 4) {
      for (uint32_t pixel = 0; pixel < 16; pixel++, packet++) {
        const uint32_t x = block_x + pixel % 4, y = block_y + pixel / 4;
        double points[16][2];
        const asc_range range = {(int32_t)x, (int32_t)y, 0, 16, 0, 2};
        (void)asc_sampler_fill(sampler, &range, &points[0][0]);
        for (int i = 0; i < 16; i++) {
          directions[packet][0][i] = (float)((2.0 * (x + points[i][0]) / WIDTH - 1.0) * view->half_width);
          directions[packet][1][i] = (float)((1.0 - 2.0 * (y + points[i][1]) / HEIGHT) * view->half_height);
        }
      }
    }
  }
}

/* The mesh again, in the camera's frame, with the tracer's flags. */
static RTCScene bare_scene(RTCDevice device, const asc_view *view) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float *corners = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * TRIANGLES);
  uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, TRIANGLES);
  const double *axes[3] = {view->right, view->up, view->forward};
  for (size_t i = 0; i < 3 * (size_t)TRIANGLES; i++) {
    for (size_t axis = 0; axis < 3; axis++) {
      double sum = 0.0;
      for (size_t k = 0; k < 3; k++) sum += (vertices[3 * i + k] - view->eye[k]) * axes[axis][k];
      corners[3 * i + axis] = (float)sum;
    }
    indices[i] = (uint32_t)i;
  }
  rtcCommitGeometry(geometry);
  (void)rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

/* Shadow rays of the hits, toward the sun; `lit` says which lanes have one. */
static float shadow_origins[PACKETS][3][16];
static alignas(64) int lit[PACKETS][16];
static double toward_sun[3]; /* in the camera's frame, of length 1 */

static void begin_packet(struct RTCRayHit16 *rays, size_t packet) {
  for (int i = 0; i < 16; i++) {
    rays->ray.org_x[i] = rays->ray.org_y[i] = rays->ray.org_z[i] = 0.0f;
    rays->ray.dir_x[i] = directions[packet][0][i];
    rays->ray.dir_y[i] = directions[packet][1][i];
    rays->ray.dir_z[i] = 1.0f;
    rays->ray.tnear[i] = 0.0f;
    rays->ray.tfar[i] = INFINITY;
    rays->ray.mask[i] = UINT32_MAX;
    rays->ray.flags[i] = 0;
    rays->ray.time[i] = 0.0f;
    rays->hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    rays->hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
}

static void begin_shadows(struct RTCRay16 *shadows, size_t packet) {
  for (int i = 0; i < 16; i++) {
    shadows->org_x[i] = shadow_origins[packet][0][i];
    shadows->org_y[i] = shadow_origins[packet][1][i];
    shadows->org_z[i] = shadow_origins[packet][2][i];
    shadows->dir_x[i] = (float)toward_sun[0];
    shadows->dir_y[i] = (float)toward_sun[1];
    shadows->dir_z[i] = (float)toward_sun[2];
    shadows->tnear[i] = 0.0f;
    shadows->tfar[i] = INFINITY;
    shadows->mask[i] = UINT32_MAX;
    shadows->flags[i] = 0;
    shadows->time[i] = 0.0f;
  }
}

/* The shadow rays of one packet that was traced: from the hit, lifted to the viewer's side, where the sun is there. */
static void make_shadows(const struct RTCRayHit16 *rays, size_t packet) {
  for (int i = 0; i < 16; i++) {
    lit[packet][i] = 0;
    if (rays->hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    double normal[3] = {rays->hit.Ng_x[i], rays->hit.Ng_y[i], rays->hit.Ng_z[i]};
    const double direction[3] = {rays->ray.dir_x[i], rays->ray.dir_y[i], 1.0};
    double length = 0.0, facing = 0.0, cosine = 0.0;
    for (int k = 0; k < 3; k++) {
      length += normal[k] * normal[k];
      facing += normal[k] * direction[k];
    }
    for (int k = 0; k < 3; k++) {
      normal[k] *= (facing > 0.0 ? -1.0 : 1.0) / sqrt(length);
      cosine += normal[k] * toward_sun[k];
    }
    if (cosine <= 0.0) continue;
    lit[packet][i] = -1;
    for (int k = 0; k < 3; k++)
      shadow_origins[packet][k][i] = (float)(rays->ray.tfar[i] * direction[k] + 1e-5 * normal[k]);
  }
}

typedef enum bare_kind { PRIMARY_ALONE, WITH_SHADOWS, RECORD_SHADOWS } bare_kind;

/* CPU seconds of the loop; `hits` counts the primary rays that hit. */
static double bare_loop(RTCScene scene, bare_kind kind, uint64_t *hits) {
  alignas(64) static struct RTCRayHit16 rays;
  alignas(64) static struct RTCRay16 shadows;
  alignas(64) static int valid[16];
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (int i = 0; i < 16; i++) valid[i] = -1;
  *hits = 0;
  volatile float sink = 0.0f;
  const double begun = now();
  for (size_t packet = 0; packet < PACKETS; packet++) {
    begin_packet(&rays, packet);
    rtcIntersect16(valid, scene, &context, &rays);
    for (int i = 0; i < 16; i++) *hits += rays.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    if (kind == RECORD_SHADOWS) make_shadows(&rays, packet);
    if (kind == WITH_SHADOWS) {
      begin_shadows(&shadows, packet);
      rtcOccluded16(lit[packet], scene, &context, &shadows);
      sink = shadows.tfar[0];
    }
  }
  (void)sink;
  return now() - begun;
}

static int by_value(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Renders and loops in turn, and prints the share: the median over rounds, and the extremes. */
static int compare(const char *what, const asc_scene *scene, const asc_sampler *sampler, RTCScene bare,
                   bare_kind kind) {
  static float pixels[WIDTH * HEIGHT * 3];
  const tracer_desc desc = {.struct_size = sizeof desc, .sampler = sampler, .threads = 1};
  tracer *made = NULL;
  asc_error error;
  if (tracer_create(scene, &made, &error)) return 1;
  double shares[ROUNDS], bare_least = 1e9, tracer_least = 1e9;
  uint64_t hits = 0;
  tracer_cost cost;
  for (int round = 0; round < ROUNDS; round++) {
    const double bare_seconds = bare_loop(bare, kind, &hits);
    if (tracer_render(made, &desc, pixels, &cost, &error)) return 1;
    shares[round] = bare_seconds / cost.cpu_seconds;
    if (bare_seconds < bare_least) bare_least = bare_seconds;
    if (cost.cpu_seconds < tracer_least) tracer_least = cost.cpu_seconds;
  }
  qsort(shares, ROUNDS, sizeof *shares, by_value);
  const double rays = (double)(cost.primary_rays + cost.shadow_rays);
  printf("%s: %u triangles, %.1f million rays, %.0f %% of the primary ones hit\n", what, TRIANGLES, rays / 1e6,
         100.0 * (double)hits / (double)cost.primary_rays);
  printf("  bare    %6.1f Mray/s\n  tracer  %6.1f Mray/s\n", rays / bare_least / 1e6, rays / tracer_least / 1e6);
  printf("  share   %6.1f %% (median of %d rounds, %.1f to %.1f)\n", 100.0 * shares[ROUNDS / 2], ROUNDS,
         100.0 * shares[0], 100.0 * shares[ROUNDS - 1]);
  tracer_destroy(made);
  return 0;
}

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
  make_mesh();
  /* Looking down at 37 degrees, so that the mesh fills about half of the picture. */
  const double slope = 0.6457718232379019; /* 37 degrees, in radians */
  asc_view view = {.projection = ASC_PERSPECTIVE, .width = WIDTH, .height = HEIGHT, .eye = {0.05, 1.5, 1.9}};
  const double right[3] = {1, 0, 0}, up[3] = {0, cos(slope), -sin(slope)}, forward[3] = {0, -sin(slope), -cos(slope)};
  const double sun[3] = {0.8137, -0.4371, -0.3919};
  double length = 0.0;
  for (int i = 0; i < 3; i++) {
    view.right[i] = right[i];
    view.up[i] = up[i];
    view.forward[i] = forward[i];
    length += sun[i] * sun[i];
  }
  const double *axes[3] = {right, up, forward};
  for (int axis = 0; axis < 3; axis++)
    for (int i = 0; i < 3; i++) toward_sun[axis] -= sun[i] * axes[axis][i] / sqrt(length);
  view.half_height = 0.42;
  view.half_width = view.half_height * WIDTH / HEIGHT;
  asc_material materials[7] = {{.emission = {0, 0, 0}}};
  for (int i = 0; i < 7; i++) {
    materials[i].emission[i % 3] = 0.1 + 0.1 * i;
    materials[i].albedo[i % 3] = 0.5;
  }
  const asc_light light = {.kind = ASC_LIGHT_DIRECTIONAL, .place = {sun[0], sun[1], sun[2]}, .intensity = {1, 1, 1}};
  asc_scene scene = {.struct_size = sizeof scene,
                     .view = view,
                     .materials = materials,
                     .material_count = 7,
                     .vertices = vertices,
                     .triangle_material = materials_of,
                     .triangle_count = TRIANGLES};
  const asc_sampler_desc pattern = {sizeof pattern, "sobol:scramble=owen", SAMPLES, 2, 1};
  asc_sampler *sampler = NULL;
  if (asc_sampler_create(&pattern, &sampler, NULL)) return 1;
  make_directions(&view, sampler);
  RTCDevice device = rtcNewDevice("threads=1");
  RTCScene bare = bare_scene(device, &view);
  uint64_t hits;
  (void)bare_loop(bare, RECORD_SHADOWS, &hits);

  int failed = compare("unlit, against rtcIntersect16", &scene, sampler, bare, PRIMARY_ALONE);
  scene.lights = &light;
  scene.light_count = 1;
  failed |= compare("with shadows, against rtcIntersect16 and rtcOccluded16", &scene, sampler, bare, WITH_SHADOWS);
  printf("adaptive, with shadows, at most 64 samples a pixel\n");
  static const char *const methods[] = {NULL,       "whitted",   "kajiya",
                                        "mitchell", "student-t", "student-t:batch=2,cells=4,margin=1.25,minimum=4"};
  for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) failed |= adapt(&scene, methods[i]);
  rtcReleaseScene(bare);
  rtcReleaseDevice(device);
  asc_sampler_destroy(sampler);
  return failed;
}

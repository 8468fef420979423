/* The tracer: geometry, pixels, sums, filters, and the same bits for every division of the work. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "filtered.h"
#include "threads_alone.h"
#include "tracer.h"

/* A world unit is a pixel, (0, 0) the picture's lower left corner, seen from z = 10 along -z. */
static asc_view flat_view(uint32_t width, uint32_t height) {
  return (asc_view){.projection = ASC_ORTHOGRAPHIC,
                    .width = width,
                    .height = height,
                    .eye = {width / 2.0, height / 2.0, 10.0},
                    .right = {1, 0, 0},
                    .up = {0, 1, 0},
                    .forward = {0, 0, -1},
                    .half_width = width / 2.0,
                    .half_height = height / 2.0,
                    .background = {0, 0, 0}};
}

static asc_material glow(double red, double green, double blue) {
  return (asc_material){.emission = {red, green, blue}};
}

static asc_sampler *sampler_of(const char *spec, uint64_t samples) {
  const asc_sampler_desc pattern = {sizeof pattern, spec, samples, 2, 7};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  if (asc_sampler_create(&pattern, &sampler, &error)) fail_msg("%s", error.text);
  return sampler;
}

static asc_filter *filter_of(const char *spec) {
  const asc_filter_desc desc = {sizeof desc, spec};
  asc_filter *filter = NULL;
  asc_error error = {{0}};
  if (asc_filter_create(&desc, &filter, &error)) fail_msg("%s", error.text);
  return filter;
}

/* filter: NULL for none. */
static void render_filtered(const asc_scene *scene, const char *spec, uint64_t samples, const char *filter,
                            uint32_t threads, float *pixels, tracer_cost *cost) {
  asc_sampler *sampler = sampler_of(spec, samples);
  asc_filter *profile = filter ? filter_of(filter) : NULL;
  tracer *made = NULL;
  asc_error error = {{0}};
  if (tracer_create(scene, &made, &error)) fail_msg("%s", error.text);
  const tracer_desc desc = {sizeof desc, sampler, threads, profile};
  if (tracer_render(made, &desc, pixels, cost, &error)) fail_msg("%s", error.text);
  tracer_destroy(made);
  asc_filter_destroy(profile);
  asc_sampler_destroy(sampler);
}

static void render(const asc_scene *scene, const char *spec, uint64_t samples, uint32_t threads, float *pixels,
                   tracer_cost *cost) {
  render_filtered(scene, spec, samples, NULL, threads, pixels, cost);
}

static void it_says_how_it_traces(void **state) {
  (void)state;
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(6, 4)};
  tracer *made = NULL;
  assert_int_equal(tracer_create(&scene, &made, NULL), ASC_OK);
  tracer_kernel kernel = {0, 0, 0, 0};
  tracer_describe(made, &kernel);
  assert_int_equal(kernel.version, tracer_embree_version());
  assert_int_equal(kernel.packet, 16);
  assert_true(kernel.native == 4 || kernel.native == 8 || kernel.native == 16);
  assert_int_equal(kernel.robust, 1);
  tracer_destroy(made);
}

/* A red triangle that covers pixel (1, 0) wholly and pixel (0, 3) not at all: a picture that is mirrored, transposed or
 * upside down shows it. */
static void pixels_are_where_they_should_be(void **state) {
  (void)state;
  const double vertices[] = {0.9, 4.1, 0, 2.1, 4.1, 0, 2.1, 2.9, 0, 0.9, 4.1, 0, 2.1, 2.9, 0, 0.9, 2.9, 0};
  const uint32_t indices[] = {0, 0};
  const asc_material materials[] = {glow(1, 0.5, 0.25)};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(6, 4), .materials = materials};
  scene.material_count = 1;
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = 2;
  float pixels[4][6][3];
  render(&scene, "regular", 1, 1, &pixels[0][0][0], NULL);
  for (int y = 0; y < 4; y++) {
    for (int x = 0; x < 6; x++) {
      const float lit = x == 1 && y == 0 ? 1.0f : 0.0f;
      assert_true(pixels[y][x][0] == lit && pixels[y][x][1] == 0.5f * lit && pixels[y][x][2] == 0.25f * lit);
    }
  }
}

/* 31 x 17 is no multiple of the block of 4; counts below, at and above a packet, and no multiple of it. */
static void threads_do_not_change_a_bit(void **state) {
  (void)state;
  enum { W = 31, H = 17 };
  const double vertices[] = {-2, 3, 0, 33, 9, 0, 20, -4, 0, 4, 20, -1, 28, 2, -1, 30, 19, -1};
  const uint32_t indices[] = {0, 1};
  asc_material materials[] = {glow(0.9, 0.5, 0.1), glow(0.2, 0.8, 1.0)};
  materials[1].pattern = (asc_pattern){ASC_PATTERN_ZONE_PLATE, 0.7, {15, 9, -1}, {0, 0, 0}, {1, 1, 1}};
  const asc_disc discs[] = {{{8, 8, 1}, {0, 0.2, 2}, 3.3, 1}};
  const asc_sphere spheres[] = {{{22, 6, 2}, 4.4, 0}};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(W, H), .materials = materials};
  scene.material_count = 2;
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = 2;
  scene.discs = discs;
  scene.disc_count = 1;
  scene.spheres = spheres;
  scene.sphere_count = 1;
  const uint64_t counts[] = {1, 3, 16, 50, 2000};
  for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
    static float one[H][W][3], many[H][W][3];
    tracer_cost cost;
    render(&scene, "sobol:scramble=owen", counts[k], 1, &one[0][0][0], &cost);
    assert_int_equal(cost.samples, counts[k] * W * H);
    assert_int_equal(cost.primary_rays, counts[k] * W * H);
    assert_true(cost.cpu_seconds > 0.0 && cost.wall_seconds > 0.0);
    for (uint32_t threads = 2; threads <= 5; threads += 3) {
      render(&scene, "sobol:scramble=owen", counts[k], threads, &many[0][0][0], NULL);
      assert_memory_equal(one, many, sizeof one);
    }
  }
}

/* Mean over the picture of a lit surface, times its pixels: the area, in pixels. */
static double lit_area(const asc_scene *scene, uint64_t samples) {
  const size_t count = (size_t)scene->view.width * scene->view.height;
  float *pixels = malloc(count * 3 * sizeof *pixels);
  assert_non_null(pixels);
  render(scene, "sobol:scramble=owen", samples, 1, pixels, NULL);
  double sum = 0.0;
  for (size_t i = 0; i < count; i++) sum += pixels[3 * i];
  free(pixels);
  return sum;
}

/* About 100 pixels are crossed by the outline, each known to 0.36 * 1024^-3/4 = 0.002 (the jittered rate, which Sobol
 * does not exceed): 0.02 in the sum, of which the bound is five. */
static void discs_and_spheres_have_their_areas(void **state) {
  (void)state;
  const asc_material materials[] = {glow(1, 1, 1)};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(32, 32), .materials = materials};
  scene.material_count = 1;
  const asc_disc tilted = {{15.7, 16.2, 0}, {0, 0.6, 0.8}, 12.0, 0};
  scene.discs = &tilted;
  scene.disc_count = 1;
  assert_true(fabs(lit_area(&scene, 1024) - 3.14159265358979 * 144.0 * 0.8) < 0.1);
  scene.disc_count = 0;
  const asc_sphere sphere = {{15.7, 16.2, -20}, 12.0, 0};
  scene.spheres = &sphere;
  scene.sphere_count = 1;
  assert_true(fabs(lit_area(&scene, 1024) - 3.14159265358979 * 144.0) < 0.1);
}

/* A sphere of radius R at distance d on the axis has a silhouette of tangent R / sqrt(d^2 - R^2). */
static void perspective_keeps_its_angles(void **state) {
  (void)state;
  const asc_material materials[] = {glow(1, 1, 1)};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(32, 32), .materials = materials};
  scene.material_count = 1;
  scene.view.projection = ASC_PERSPECTIVE;
  scene.view.half_width = scene.view.half_height = 0.5;
  const asc_sphere sphere = {{16, 16, 10 - 7.0}, 2.0, 0};
  scene.spheres = &sphere;
  scene.sphere_count = 1;
  const double radius = 2.0 / sqrt(45.0) / 0.5 * 16.0;
  assert_true(fabs(lit_area(&scene, 1024) - 3.14159265358979 * radius * radius) < 0.1);
}

/* What lies behind an orthographic or a perspective eye is not seen. */
static void nothing_behind_the_eye_is_seen(void **state) {
  (void)state;
  const asc_material materials[] = {glow(1, 1, 1)};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(8, 8), .materials = materials};
  scene.material_count = 1;
  const asc_disc behind = {{4, 4, 11}, {0, 0, 1}, 3.0, 0};
  scene.discs = &behind;
  scene.disc_count = 1;
  assert_true(lit_area(&scene, 4) == 0.0);
  scene.view.projection = ASC_PERSPECTIVE;
  assert_true(lit_area(&scene, 4) == 0.0);
}

/* The pattern's phase is right in double where float has lost it: 10^7 units from the origin, with a phase of up to
 * 60 radians, each sample equals the formula. The coordinates themselves have 2^-30 there, so the phase 1e-7. */
static void patterns_are_evaluated_in_double(void **state) {
  (void)state;
  enum { W = 16, H = 12 };
  const double far = 1e7;
  asc_material materials[] = {glow(1, 1, 1)};
  materials[0].pattern =
      (asc_pattern){ASC_PATTERN_ZONE_PLATE, 0.4, {far + 3.3, far + 4.4, 0}, {0.1, 0.2, 0.3}, {0.9, 0.8, 0.7}};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(W, H), .materials = materials};
  scene.material_count = 1;
  for (int axis = 0; axis < 2; axis++) scene.view.eye[axis] += far;
  const double a = far - 50, b = far + 50;
  const double vertices[] = {a, a, 0, b, a, 0, b, b, 0, a, a, 0, b, b, 0, a, b, 0};
  const uint32_t indices[] = {0, 0};
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = 2;
  float pixels[H][W][3];
  render(&scene, "regular", 1, 1, &pixels[0][0][0], NULL);
  for (int y = 0; y < H; y++) {
    for (int x = 0; x < W; x++) {
      const double dx = x + 0.5 - 3.3, dy = H - y - 0.5 - 4.4;
      const double mix = 0.5 * (1.0 + cos(0.4 * (dx * dx + dy * dy)));
      assert_true(fabs(pixels[y][x][0] - (0.1 + 0.8 * mix)) < 1e-6);
      assert_true(fabs(pixels[y][x][2] - (0.3 + 0.4 * mix)) < 1e-6);
    }
  }
}

/* 10^6 rays into a closed fan of triangles find no gap along the edges that they share. */
static void shared_edges_do_not_leak(void **state) {
  (void)state;
  enum { SIDES = 61, W = 64 };
  static double vertices[SIDES * 9];
  static uint32_t indices[SIDES];
  for (int i = 0; i < SIDES; i++) {
    const double a = 6.283185307179586 * i / SIDES, b = 6.283185307179586 * ((i + 1) % SIDES) / SIDES;
    const double fan[] = {
        31.3, 32.7, 0, 31.3 + 200 * cos(a), 32.7 + 200 * sin(a), 0, 31.3 + 200 * cos(b), 32.7 + 200 * sin(b), 0};
    memcpy(vertices + 9 * i, fan, sizeof fan);
  }
  const asc_material materials[] = {glow(1, 1, 1)};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(W, W), .materials = materials};
  scene.material_count = 1;
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = SIDES;
  static float pixels[W * W * 3];
  render(&scene, "random", 256, 2, pixels, NULL);
  for (size_t i = 0; i < W * W * 3; i++) assert_true(pixels[i] == 1.0f);
}

static void broken_scenes_are_refused(void **state) {
  (void)state;
  asc_material materials[] = {glow(1, 1, 1)};
  double vertices[] = {0, 0, 0, 1, 0, 0, NAN, 1, 0};
  uint32_t indices[] = {0};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(8, 8), .materials = materials};
  scene.material_count = 1;
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = 1;
  tracer *made = NULL;
  asc_error error = {{0}};
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "triangle 0"));
  vertices[6] = 0;
  indices[0] = 3;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "material 3"));
  indices[0] = 0;
  materials[0].emission[1] = INFINITY;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  materials[0].emission[1] = 1;
  const double shares[] = {-0.1, 0.7, NAN};
  for (int i = 0; i < 3; i++) {
    materials[0].albedo[2] = 0.5;
    materials[0].reflection[2] = shares[i];
    assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
    assert_non_null(strstr(error.text, i == 2 ? "not finite" : "reflection"));
  }
  materials[0].reflection[2] = 0;
  scene.transport.mirror_bounces = 65;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "64 mirror bounces"));
  scene.transport.mirror_bounces = 0;
  scene.view.width = 0;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  scene.view.width = 8;
  scene.view.shift[1] = NAN;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "not finite"));
  scene.view.shift[1] = 0;
  scene.view.lens_radius = 0.5; /* orthographic, and not focused */
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "focused"));
  scene.view.projection = ASC_PERSPECTIVE;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  scene.view.focus_distance = 1;
  scene.view.blades = 2;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "3 to 64 blades"));
  scene.view.lens_radius = -1;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  scene.view = flat_view(8, 8);
  asc_light lamp = {.kind = ASC_LIGHT_PARALLELOGRAM, .edges = {{1, 2, 3}, {2, 4, 6}}};
  scene.lights = &lamp;
  scene.light_count = 1;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "light 0 has no area"));
  lamp.kind = ASC_LIGHT_SPHERE;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "light 0 has no radius"));
  lamp.kind = (asc_light_kind)9;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  scene.light_count = 0;
  asc_motion turn = {.kind = ASC_MOTION_ROTATE, .angle = 1};
  const uint32_t second = 2;
  scene.motions = &turn;
  scene.motion_count = 1;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "open for no time"));
  scene.view.shutter_close = -1;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  scene.view.shutter_close = 1;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "axis"));
  turn.axis[1] = 2;
  turn.angle = 7;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_UNSUPPORTED);
  turn.angle = 1;
  scene.triangle_motion = &second;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "motion 2 of 1"));
  scene.triangle_motion = NULL;
  scene.motion_count = 0;
  scene.view = flat_view(8, 8);
  const asc_disc flat = {{0, 0, 0}, {0, 0, 0}, 1, 0};
  scene.discs = &flat;
  scene.disc_count = 1;
  assert_int_equal(tracer_create(&scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "disc 0"));
  scene.struct_size = 1;
  assert_int_equal(tracer_create(&scene, &made, NULL), ASC_INVALID_ARGUMENT);
  assert_null(made);
}

/* A lens, a shutter, a light of each kind, and of each kind of surface one that moves. */
static void all_that_a_scene_can_ask_for(void **state) {
  (void)state;
  enum { W = 21, H = 14 };
  asc_material materials[] = {glow(0.1, 0.2, 0.3)};
  materials[0].albedo[0] = 0.5;
  const double vertices[] = {2, 2, 1, 19, 3, 1, 9, 12, 1};
  const uint32_t material = 0, second = 2, first = 1;
  const asc_disc disc = {{14, 9, 3}, {0.2, 0.1, 1}, 3, 0};
  const asc_sphere sphere = {{5, 8, 4}, 2, 0};
  const asc_plane floor = {{0, 0, -3}, {0.1, 0.2, 1}, 0};
  const asc_motion motions[] = {{.kind = ASC_MOTION_TRANSLATE, .by = {3, 1, 0}},
                                {.kind = ASC_MOTION_ROTATE, .axis = {0.1, 0, 2}, .centre = {10, 7, 0}, .angle = -2}};
  const asc_light lights[] = {
      {.kind = ASC_LIGHT_POINT, .place = {3, 20, 30}, .intensity = {1, 1, 1}},
      {.kind = ASC_LIGHT_DIRECTIONAL, .place = {0.1, 0.2, -1}, .intensity = {1, 1, 1}},
      {.kind = ASC_LIGHT_PARALLELOGRAM, .place = {3, 2, 20}, .intensity = {1, 1, 1}, .edges = {{4, 0, 0}, {0, 5, 1}}},
      {.kind = ASC_LIGHT_DISC, .place = {9, 2, 20}, .intensity = {1, 1, 1}, .edges = {{3, 0, 0}, {0, 3, 0}}},
      {.kind = ASC_LIGHT_SPHERE, .place = {9, 9, 15}, .intensity = {9, 9, 9}, .inverse_square = 1, .radius = 2}};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(W, H), .materials = materials};
  scene.material_count = scene.triangle_count = scene.disc_count = scene.sphere_count = scene.plane_count = 1;
  scene.vertices = vertices;
  scene.triangle_material = &material;
  scene.discs = &disc;
  scene.spheres = &sphere;
  scene.planes = &floor;
  scene.lights = lights;
  scene.light_count = 5;
  scene.motions = motions;
  scene.motion_count = 2;
  scene.triangle_motion = scene.disc_motion = scene.sphere_motion = &second;
  scene.plane_motion = &first;
  scene.view.projection = ASC_PERSPECTIVE;
  scene.view.eye[2] = 25;
  scene.view.half_width = 0.6;
  scene.view.half_height = 0.4;
  scene.view.lens_radius = 0.8;
  scene.view.focus_distance = 24;
  scene.view.blades = 5;
  scene.view.shutter_close = 1;
  scene.view.response = ASC_RESPONSE_TRIANGLE;
  tracer *made = NULL;
  assert_int_equal(tracer_create(&scene, &made, NULL), ASC_OK);
  assert_int_equal(tracer_dimensions(made), 2 + 1 + 2 + 3 * 2);
  const uint32_t sizes[] = {2, 1, 2, 2, 2, 2};
  uint32_t groups[6];
  size_t count;
  tracer_groups(made, NULL, &count);
  assert_int_equal(count, 6);
  tracer_groups(made, groups, &count);
  assert_memory_equal(groups, sizes, sizeof sizes);
  const asc_sampler_desc few = {
      .struct_size = sizeof few, .spec = "sobol:scramble=owen", .samples = 5, .dimensions = 10};
  asc_sampler_desc enough = few;
  enough.dimensions = 11;
  asc_sampler *samplers[2] = {NULL, NULL};
  assert_int_equal(asc_sampler_create(&few, &samplers[0], NULL), ASC_OK);
  assert_int_equal(asc_sampler_create(&enough, &samplers[1], NULL), ASC_OK);
  float pixels[2][W * H * 3];
  asc_error error = {{0}};
  tracer_desc desc = {.struct_size = sizeof desc, .sampler = samplers[0], .threads = 1};
  assert_int_equal(tracer_render(made, &desc, pixels[0], NULL, &error), ASC_INVALID_ARGUMENT);
  assert_non_null(strstr(error.text, "11 dimensions"));
  desc.sampler = samplers[1];
  assert_int_equal(tracer_render(made, &desc, pixels[0], NULL, NULL), ASC_OK);
  desc.threads = 3;
  assert_int_equal(tracer_render(made, &desc, pixels[1], NULL, NULL), ASC_OK);
  assert_memory_equal(pixels[0], pixels[1], sizeof pixels[0]);
  for (int i = 0; i < W * H * 3; i++) assert_true(pixels[0][i] >= 0.0F && pixels[0][i] < 10.0F);
  asc_sampler_destroy(samplers[0]);
  asc_sampler_destroy(samplers[1]);
  tracer_destroy(made);
}

static void an_empty_scene_is_background(void **state) {
  (void)state;
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(5, 3)};
  scene.view.background[1] = 0.25;
  float pixels[15][3];
  render(&scene, "random", 3, 1, &pixels[0][0], NULL);
  for (int i = 0; i < 15; i++) assert_true(pixels[i][0] == 0.0f && pixels[i][1] == 0.25f);
}

/* Radii below and at half pixels and whole ones, and the largest. */
static const char *const filters[] = {"tent",    "tent:radius=0.5", "gaussian",        "gaussian:radius=8", "mitchell",
                                      "lanczos", "catmull-rom",     "blackman-harris", "box:radius=1.3"};
#define FILTERS (sizeof filters / sizeof *filters)

/* At the borders too, and for pictures smaller than a tile. Sums in double of up to 289 * 5 terms leave a relative
 * error of 1e-12, so that the result is the float next to the constant at most. */
static void filters_keep_a_constant(void **state) {
  (void)state;
  enum { MOST = 19 * 37 };
  const uint32_t sizes[][2] = {{1, 1}, {19, 37}};
  const double colour[3] = {0.3, 0.7, 4.1};
  for (size_t k = 0; k < FILTERS * 4; k++) {
    const uint32_t width = sizes[k % 2][0], height = sizes[k % 2][1];
    asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(width, height)};
    memcpy(scene.view.background, colour, sizeof colour);
    float pixels[MOST][3];
    render_filtered(&scene, "random", k / 2 % 2 ? 1 : 5, filters[k / 4], 1, &pixels[0][0], NULL);
    for (size_t i = 0; i < (size_t)width * height; i++)
      for (int c = 0; c < 3; c++) assert_true(fabs(pixels[i][c] - colour[c]) <= FLT_EPSILON * colour[c]);
  }
}

/* A zone plate over the whole picture. */
static const asc_disc plate = {{25, 20, 0}, {0, 0, 1}, 200, 0};

static asc_scene plate_scene(uint32_t width, uint32_t height) {
  static asc_material zones;
  zones = glow(1, 1, 1);
  zones.pattern = (asc_pattern){ASC_PATTERN_ZONE_PLATE, 0.02, {3.1, 7.7, 0}, {0, 0.1, 0.2}, {1, 0.9, 0.5}};
  return (asc_scene){.struct_size = sizeof(asc_scene),
                     .view = flat_view(width, height),
                     .materials = &zones,
                     .material_count = 1,
                     .discs = &plate,
                     .disc_count = 1};
}

/* 53 x 41 and its border are no multiple of the tile of 16. Bands of one row of tiles, of two, and all at once. */
static void filters_give_the_same_bits_for_threads_and_bands(void **state) {
  (void)state;
  enum { W = 53, H = 41 };
  const asc_scene scene = plate_scene(W, H);
  asc_sampler *sampler = sampler_of("sobol:scramble=owen", 3);
  tracer *made = NULL;
  assert_int_equal(tracer_create(&scene, &made, NULL), ASC_OK);
  for (size_t k = 0; k < FILTERS; k++) {
    static float one[H][W][3], other[H][W][3];
    asc_filter *filter = filter_of(filters[k]);
    for (uint32_t threads = 1; threads <= 5; threads++) {
      const tracer_desc desc = {sizeof desc, sampler, threads, filter};
      memset(other, 0xff, sizeof other);
      assert_int_equal(tracer_render(made, &desc, threads == 1 ? &one[0][0][0] : &other[0][0][0], NULL, NULL), ASC_OK);
      if (threads > 1) assert_memory_equal(one, other, sizeof one);
    }
    for (uint32_t rows = 1; rows <= 2; rows++) {
      film target;
      crew_cost cost = {0};
      assert_int_equal(film_make(&target, TRACER_FILM_DOUBLE, filter, W, H, 3), ASC_OK);
      assert_true(target.rows == target.down);
      target.rows = rows;
      memset(other, 0xff, sizeof other);
      assert_int_equal(filtered_render(made, sampler, &target, 2, &other[0][0][0], &cost), ASC_OK);
      assert_memory_equal(one, other, sizeof one);
      film_free(&target);
    }
    asc_filter_destroy(filter);
  }
  tracer_destroy(made);
  asc_sampler_destroy(sampler);
}

static void filters_count_their_borders_and_the_box_has_none(void **state) {
  (void)state;
  enum { W = 21, H = 18 };
  const asc_scene scene = plate_scene(W, H);
  static float plain[H][W][3], box[H][W][3], other[H][W][3];
  tracer_cost cost;
  render_filtered(&scene, "random", 8, NULL, 1, &plain[0][0][0], NULL);
  render_filtered(&scene, "random", 8, "box", 1, &box[0][0][0], &cost);
  assert_memory_equal(plain, box, sizeof box);
  assert_int_equal(cost.samples, 8 * W * H);
  render_filtered(&scene, "random", 8, "box:radius=0.500001", 1, &other[0][0][0], &cost);
  assert_int_equal(cost.samples, 8 * (W + 2) * (H + 2));
  /* No sample is so near a border that it counts twice, so only the order of additions and the float differ. */
  for (int i = 0; i < W * H * 3; i++) {
    const float expected = (&box[0][0][0])[i];
    assert_true(expected > 0.0f && fabs((&other[0][0][0])[i] - expected) <= FLT_EPSILON * expected);
  }
  render_filtered(&scene, "random", 8, "mitchell", 1, &other[0][0][0], &cost);
  assert_int_equal(cost.samples, 8 * (W + 4) * (H + 4));
  assert_int_equal(cost.primary_rays, cost.samples);
}

/* Endless light in a corner of a tile: where it is added, with whatever weight, the cell is no number or endless too.
 */
static void samples_stay_within_reach(void **state) {
  (void)state;
  for (size_t k = 0; k < FILTERS; k++) {
    asc_filter *filter = filter_of(filters[k]);
    film target;
    assert_int_equal(film_make(&target, TRACER_FILM_DOUBLE, filter, 40, 40, 1), ASC_OK);
    for (int place = 0; place < 20; place++) {
      (void)film_begin(&target, 0, 0);
      const film_pixel first = film_at(&target, 0, 0, 0, 0), last = film_at(&target, 0, 0, 15, 15);
      const film_sample sample = {last, 0.05 * place, 0.05 * place, 1.0};
      const double light[1][4] = {{INFINITY, INFINITY, INFINITY, 0.0}};
      film_add(&target, 1, &sample, light);
      const int32_t side = (int32_t)target.side, least = side - 2 * target.reach - 1;
      const film_cell *cells = (film_cell *)first.weighted - (ptrdiff_t)target.reach * (side + 1), *plain = first.plain;
      for (int32_t i = 0; i < side * side; i++)
        assert_true(isfinite(cells[i][0]) || (i % side >= least && i / side >= least));
      for (int i = 0; i < 255; i++) assert_true(plain[i][0] == 0.0);
      assert_true(isinf((*(film_cell *)last.plain)[0]));
    }
    film_free(&target);
    asc_filter_destroy(filter);
  }
}

/* The background of 1e40 is a double, and no pixel of floats: the first is named, whatever the filter and the threads.
 */
static void what_float_does_not_hold_is_an_error_of_all_threads(void **state) {
  (void)state;
  const double vertices[] = {-9, 9, 0, 90, 9, 0, -9, 1.8, 0}; /* row 0, and of row 1 the first centre */
  const uint32_t indices[] = {0};
  const asc_material materials[] = {glow(1, 1, 1)};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(6, 4), .materials = materials};
  scene.material_count = 1;
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = 1;
  scene.view.background[1] = 1e40;
  tracer *made = NULL;
  asc_error error = {{0}};
  if (tracer_create(&scene, &made, &error)) fail_msg("%s", error.text);
  asc_sampler *sampler = sampler_of("regular", 1);
  const char *two[] = {NULL, "tent"};
  for (int i = 0; i < 2; i++) {
    asc_filter *profile = two[i] ? filter_of(two[i]) : NULL;
    float pixels[6 * 4 * 3];
    const tracer_desc desc = {sizeof desc, sampler, 3, profile};
    assert_int_equal(tracer_render(made, &desc, pixels, NULL, &error), ASC_NUMERIC);
    assert_string_equal(error.text, "pixel (1, 1) is not finite: a colour is too large for float");
    assert_int_equal(tracer_render(made, &desc, pixels, NULL, NULL), ASC_NUMERIC);
    asc_filter_destroy(profile);
  }
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_says_how_it_traces),
      cmocka_unit_test(pixels_are_where_they_should_be),
      cmocka_unit_test(threads_do_not_change_a_bit),
      cmocka_unit_test(discs_and_spheres_have_their_areas),
      cmocka_unit_test(perspective_keeps_its_angles),
      cmocka_unit_test(nothing_behind_the_eye_is_seen),
      cmocka_unit_test(patterns_are_evaluated_in_double),
      cmocka_unit_test(shared_edges_do_not_leak),
      cmocka_unit_test(broken_scenes_are_refused),
      cmocka_unit_test(all_that_a_scene_can_ask_for),
      cmocka_unit_test(an_empty_scene_is_background),
      cmocka_unit_test(filters_keep_a_constant),
      cmocka_unit_test(filters_give_the_same_bits_for_threads_and_bands),
      cmocka_unit_test(samples_stay_within_reach),
      cmocka_unit_test(filters_count_their_borders_and_the_box_has_none),
      cmocka_unit_test(what_float_does_not_hold_is_an_error_of_all_threads),
  };
  take_threads_alone();
  return cmocka_run_group_tests_name("tracer", tests, NULL, NULL);
}

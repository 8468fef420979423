/* What the tracer keeps at the extremes of geometry: far from the world's origin, at any scale, seen from far away,
 * with triangles much larger than they are far, and rays through the corners of meshes. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "corners.h"
#include "tracer.h"

enum { SIDE = 40, VALUES = SIDE * SIDE * 3 };

/* From (0, 0, distance) along -z. */
static asc_view view_along_z(asc_projection projection, double half, double distance) {
  return (asc_view){.projection = projection,
                    .width = SIDE,
                    .height = SIDE,
                    .eye = {0.0, 0.0, distance},
                    .right = {1, 0, 0},
                    .up = {0, 1, 0},
                    .forward = {0, 0, -1},
                    .half_width = half,
                    .half_height = half};
}

static void draw_with(const asc_scene *scene, tracer_options options, const char *spec, uint64_t samples,
                      float *pixels) {
  tracer *made = NULL;
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  options.struct_size = sizeof options;
  if (tracer_create_with(scene, &options, &made, &error)) fail_msg("%s", error.text);
  const asc_sampler_desc pattern = {sizeof pattern, spec, samples, tracer_dimensions(made), 7};
  if (asc_sampler_create(&pattern, &sampler, &error)) fail_msg("%s", error.text);
  const tracer_desc desc = {sizeof desc, sampler, 1, NULL};
  if (tracer_render(made, &desc, pixels, NULL, &error)) fail_msg("%s", error.text);
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

static void draw(const asc_scene *scene, float *pixels) { draw_with(scene, (tracer_options){0}, "random", 9, pixels); }

/* A ball, a disc, a checked triangle under them, a lamp that falls off and another with an area. */
typedef struct table {
  double vertices[9];
  uint32_t triangle_material;
  asc_disc disc;
  asc_sphere sphere;
  asc_material materials[2];
  asc_light lights[2];
  asc_scene scene;
} table;

static void times(double by, double *numbers, size_t count) {
  for (size_t i = 0; i < count; i++) numbers[i] *= by;
}

static void plus(double by, double place[3]) {
  for (int i = 0; i < 3; i++) place[i] += by;
}

/* All lengths times `scale`, then all coordinates plus `away`. */
static void set_table(double scale, double away, table *of) {
  *of = (table){
      .vertices = {-3, -2.5, -1, 3.25, -2.5, -0.5, 0.5, 3, -2},
      .disc = {{-0.75, 0.5, 0.25}, {0.25, 0.5, 1}, 0.5, 1},
      .sphere = {{0.5, -0.25, 0.5}, 0.75, 1},
      .materials = {{.albedo = {0.7, 0.6, 0.5},
                     .pattern = {ASC_PATTERN_CHECKER, 2.0 / scale, {0.25, 0.5, 0.125}, {1, 1, 1}, {0.25, 0.5, 0.75}}},
                    {.albedo = {0.5, 0.4, 0.3}, .emission = {0.1, 0.2, 0.3}, .reflection = {0.25, 0.25, 0.25}}},
      .lights = {{.kind = ASC_LIGHT_POINT, .place = {2, 3, 4}, .intensity = {9, 8, 7}, .inverse_square = 1},
                 {.kind = ASC_LIGHT_PARALLELOGRAM,
                  .place = {-2, 2, 4},
                  .intensity = {0.5, 0.5, 0.5},
                  .edges = {{1, 0, 0}, {0, 0.5, 0}}}}};
  asc_view view = view_along_z(ASC_PERSPECTIVE, 0.5, 6.0);
  times(scale, view.eye, 3);
  plus(away, view.eye);
  times(scale, of->vertices, 9);
  for (int i = 0; i < 3; i++) plus(away, of->vertices + (size_t)(3 * i));
  double *places[] = {of->disc.centre, of->sphere.centre, of->materials[0].pattern.origin, of->lights[0].place,
                      of->lights[1].place};
  for (size_t i = 0; i < 5; i++) {
    times(scale, places[i], 3);
    plus(away, places[i]);
  }
  of->disc.radius *= scale;
  of->sphere.radius *= scale;
  times(scale * scale, of->lights[0].intensity, 3);
  times(scale, of->lights[1].edges[0], 6);
  of->scene = (asc_scene){.struct_size = sizeof of->scene,
                          .view = view,
                          .materials = of->materials,
                          .material_count = 2,
                          .vertices = of->vertices,
                          .triangle_material = &of->triangle_material,
                          .triangle_count = 1,
                          .discs = &of->disc,
                          .disc_count = 1,
                          .spheres = &of->sphere,
                          .sphere_count = 1,
                          .lights = of->lights,
                          .light_count = 2,
                          .transport = {.mirror_bounces = 1}};
}

/* Coordinates are multiples of 2^-4, so that 2^40 more, or a scale of a power of two, round none of them. */
static void far_away_or_scaled_no_bit_changes(void **state) {
  (void)state;
  static float here[VALUES], there[VALUES];
  table of;
  set_table(1.0, 0.0, &of);
  draw(&of.scene, here);
  const struct {
    double scale, away;
  } cases[] = {{1.0, 0x1p40}, {1.0, -0x1p30}, {0x1p-100, 0.0}, {0x1p90, 0.0}, {0x1p-40, 0.0}, {0x1p40, 0.0}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    set_table(cases[i].scale, cases[i].away, &of);
    draw(&of.scene, there);
    for (size_t k = 0; k < VALUES; k++)
      if (here[k] != there[k]) fail_msg("by %g, %g: %zu", cases[i].scale, cases[i].away, k);
  }
}

static double mean_difference(const float *a, const float *b) {
  double sum = 0.0;
  for (size_t i = 0; i < VALUES; i++) sum += fabs((double)a[i] - (double)b[i]);
  return sum / VALUES;
}

/* In float of the world, coordinates of 2^30 are multiples of 64: eye and surfaces fall together. At home the switch
 * changes no bit that is not rounding. */
static void without_the_switch_what_is_far_away_is_lost(void **state) {
  (void)state;
  static float here[VALUES], there[VALUES];
  table of;
  set_table(1.0, 0.0, &of);
  draw(&of.scene, here);
  draw_with(&of.scene, (tracer_options){.not_relative = 1}, "random", 9, there);
  assert_true(mean_difference(here, there) < 1e-6);
  set_table(1.0, 0x1p30, &of);
  draw_with(&of.scene, (tracer_options){.not_relative = 1}, "random", 9, there);
  assert_true(mean_difference(here, there) > 0.05);
}

static asc_scene of_triangles(asc_view view, const double *vertices, const uint32_t *material, size_t count,
                              const asc_material *materials, size_t material_count) {
  return (asc_scene){.struct_size = sizeof(asc_scene),
                     .view = view,
                     .materials = materials,
                     .material_count = material_count,
                     .vertices = vertices,
                     .triangle_material = material,
                     .triangle_count = count};
}

/* A face 1/8 before another, in the order that rounding would prefer and in the other, from 2^30 away: there float
 * parts 64. A black face stands before the right half. */
static void from_far_away_depths_are_told_apart(void **state) {
  (void)state;
  const double vertices[] = {-9,     -9, 0,  9,      -9,  0, 0,   18, 0, -9,  -9,  -0.125, 9,     -9,
                             -0.125, 0,  18, -0.125, 0.0, 8, 1.0, 8,  8, 1.0, 0.0, -40,    1.0625};
  const uint32_t order[2][3] = {{0, 1, 1}, {1, 0, 1}};
  const asc_material materials[] = {{.emission = {1, 0.5, 0.25}}, {.emission = {0, 0, 0}}};
  static float pixels[VALUES];
  for (int k = 0; k < 2; k++) {
    double turned[27];
    memcpy(turned, vertices, sizeof turned);
    if (k == 1)
      for (int i = 0; i < 9; i++) {
        turned[i] = vertices[9 + i];
        turned[9 + i] = vertices[i];
      }
    for (int orthographic = 0; orthographic < 2; orthographic++) {
      const asc_view view =
          orthographic ? view_along_z(ASC_ORTHOGRAPHIC, 1.0, 0x1p30) : view_along_z(ASC_PERSPECTIVE, 0x1p-30, 0x1p30);
      const asc_scene scene = of_triangles(view, turned, order[k], 3, materials, 2);
      draw(&scene, pixels);
      for (size_t i = 0; i < (size_t)SIDE * SIDE; i++) {
        const float expected = i % SIDE < SIDE / 2 ? 1.0f : 0.0f;
        if (pixels[3 * i] != expected) fail_msg("pixel %zu of order %d", i, k);
      }
    }
  }
}

/* A floor 1 under the eye, to 10^9 ahead and to the left, 1/4 to the right, lit straight from above: each sample is
 * that of double. */
static void triangles_larger_than_far_keep_their_edges(void **state) {
  (void)state;
  const double far = 1e9;
  const double vertices[] = {-far, -1, -0.5, 0.25, -1, -0.5, 0.25, -1, -far,
                             -far, -1, -0.5, 0.25, -1, -far, -far, -1, -far};
  const uint32_t material[2] = {0, 0};
  const asc_material chalk = {.albedo = {1, 1, 1}};
  const asc_light sun = {.kind = ASC_LIGHT_DIRECTIONAL, .place = {0, -1, 0}, .intensity = {1, 1, 1}};
  asc_scene scene = of_triangles(view_along_z(ASC_PERSPECTIVE, 1.0, 0.0), vertices, material, 2, &chalk, 1);
  scene.lights = &sun;
  scene.light_count = 1;
  static float pixels[VALUES];
  draw_with(&scene, (tracer_options){0}, "regular", 1, pixels);
  for (int y = 0; y < SIDE; y++)
    for (int x = 0; x < SIDE; x++) {
      const double u = (2.0 * x + 1.0) / SIDE - 1.0, v = 1.0 - (2.0 * y + 1.0) / SIDE, ahead = -1.0 / v;
      const int seen = v < 0.0 && ahead > 0.5 && ahead < far && u * ahead < 0.25 && u * ahead > -far;
      const float got = pixels[3 * ((size_t)y * SIDE + (size_t)x)];
      if (fabsf(got - (seen ? 1.0f : 0.0f)) > 1e-6f) fail_msg("pixel %d, %d: %g", x, y, (double)got);
    }
}

/* Fewer than one in a hundred of PIECES_MOST for any triangle through or near the eye: it ends. */
static void triangles_through_the_eye_are_drawn(void **state) {
  (void)state;
  const double vertices[] = {-1e9, 0, 1e9, 1e9, 0, 1e9, 0, 0, -1e9, -1e30, -1, -1e30, 1e30, -1, -1e30, 0, 1, -1e-30};
  const uint32_t material[2] = {0, 0};
  const asc_material white = {.emission = {1, 1, 1}};
  const asc_scene scene = of_triangles(view_along_z(ASC_PERSPECTIVE, 1.0, 0.0), vertices, material, 2, &white, 1);
  static float pixels[VALUES];
  draw(&scene, pixels);
  for (size_t i = 0; i < VALUES; i++) assert_true(isfinite(pixels[i]));
}

enum { CORNERS = SIDE + 3, SQUARES = (CORNERS - 1) * (CORNERS - 1) };

/* A rough face beyond the picture's border, each of whose corners lies on a ray through the middle of a pixel. */
static void fill_aimed(double vertices[SQUARES][2][3][3]) {
  static double corner[CORNERS][CORNERS][3];
  uint32_t random = 1;
  for (int y = 0; y < CORNERS; y++)
    for (int x = 0; x < CORNERS; x++) {
      random = random * 1664525U + 1013904223U;
      const double away = 1.0 + 0.5 * (double)random / 0x1p32;
      corner[y][x][0] = away * 0.7 * ((2.0 * x - 1.0) / SIDE - 1.0);
      corner[y][x][1] = away * 0.7 * (1.0 - (2.0 * y - 1.0) / SIDE);
      corner[y][x][2] = -away;
    }
  for (int i = 0; i < SQUARES; i++) {
    const int x = i % (CORNERS - 1), y = i / (CORNERS - 1);
    const double *const around[4] = {corner[y][x], corner[y + 1][x], corner[y + 1][x + 1], corner[y][x + 1]};
    for (int k = 0; k < 3; k++) {
      memcpy(vertices[i][0][k], around[k], sizeof vertices[i][0][k]);
      memcpy(vertices[i][1][k], around[k == 0 ? 0 : k + 1], sizeof vertices[i][1][k]);
    }
  }
}

/* 3 checks in a unit make 3 2^60 from there, an even number: as from 0. */
static void checks_that_begin_far_away_keep_their_places(void **state) {
  (void)state;
  static float here[VALUES], there[VALUES];
  table of;
  set_table(1.0, 0.0, &of);
  of.materials[0].pattern.scale = 3.0;
  memset(of.materials[0].pattern.origin, 0, sizeof of.materials[0].pattern.origin);
  draw(&of.scene, here);
  of.materials[0].pattern.origin[0] = 0x1p60;
  of.materials[0].pattern.origin[1] = -0x1p40;
  draw(&of.scene, there);
  for (size_t k = 0; k < VALUES; k++) assert_true(here[k] == there[k]);
}

static void rays_through_corners_are_not_lost(void **state) {
  (void)state;
  static double vertices[SQUARES][2][3][3];
  static uint32_t material[2 * SQUARES];
  static float pixels[VALUES];
  const asc_material white = {.emission = {1, 1, 1}};
  fill_aimed(vertices);
  const asc_scene scene = of_triangles(view_along_z(ASC_PERSPECTIVE, 0.7, 0.0), vertices[0][0][0], material,
                                       2 * (size_t)SQUARES, &white, 1);
  const struct {
    tracer_options options;
    int least, most;
  } cases[] = {{{0}, 0, 0}, {{.packet = 1}, 0, 0}, {{.packet = 8}, 0, 0}, {{.look_once = 1}, 5, 200}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    int lost = 0;
    draw_with(&scene, cases[i].options, "regular", 1, pixels);
    for (size_t k = 0; k < VALUES; k += 3) lost += pixels[k] != 1.0f;
    if (lost < cases[i].least || lost > cases[i].most) fail_msg("case %zu lost %d", i, lost);
  }
}

/* Round the middle of a square, and of fewer triangles than it takes; -0 is 0. */
static void corners_with_triangles_all_round_are_found(void **state) {
  (void)state;
  static const double fan[4][9] = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
                                   {0, 1, 0, -1, 0, 0, 0, 0, 0},
                                   {-1, 0, 0, 0, -1, 0, -0.0, 0, 0},
                                   {0, -1, 0, 0, -0.0, 0, 1, 0, 0}};
  asc_scene scene = {.struct_size = sizeof scene, .vertices = fan[0]};
  for (scene.triangle_count = 0; scene.triangle_count <= 4; scene.triangle_count++)
    assert_int_equal(corners_any_surrounded(&scene), scene.triangle_count == 4);
}

/* What misses by more than roundings, a silhouette's samples too, is not looked for: the picture is that of one look.
 */
static void looking_again_leaves_silhouettes(void **state) {
  (void)state;
  static float once[VALUES], again[VALUES];
  table of;
  set_table(1.0, 0.0, &of);
  draw_with(&of.scene, (tracer_options){.look_once = 1}, "random", 64, once);
  draw_with(&of.scene, (tracer_options){0}, "random", 64, again);
  assert_memory_equal(once, again, sizeof once);
}

static void switches_are_0_or_1(void **state) {
  (void)state;
  table of;
  set_table(1.0, 0.0, &of);
  const tracer_options wrong[] = {{.struct_size = sizeof(tracer_options), .not_relative = 2},
                                  {.struct_size = sizeof(tracer_options), .look_once = 2}};
  for (size_t i = 0; i < 2; i++) {
    tracer *made = NULL;
    asc_error error = {{0}};
    assert_int_equal(tracer_create_with(&of.scene, &wrong[i], &made, &error), ASC_INVALID_ARGUMENT);
    assert_non_null(strstr(error.text, "no such value"));
    assert_null(made);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(far_away_or_scaled_no_bit_changes),
      cmocka_unit_test(without_the_switch_what_is_far_away_is_lost),
      cmocka_unit_test(from_far_away_depths_are_told_apart),
      cmocka_unit_test(triangles_larger_than_far_keep_their_edges),
      cmocka_unit_test(triangles_through_the_eye_are_drawn),
      cmocka_unit_test(checks_that_begin_far_away_keep_their_places),
      cmocka_unit_test(rays_through_corners_are_not_lost),
      cmocka_unit_test(corners_with_triangles_all_round_are_found),
      cmocka_unit_test(looking_again_leaves_silhouettes),
      cmocka_unit_test(switches_are_0_or_1),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

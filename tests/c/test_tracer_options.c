/* What a tracer's options change, and what they leave: packets of other widths, Embree without its robust mode, sums in
 * float. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "film.h"
#include "tracer.h"

/* A world unit is a pixel, (0, 0) the picture's lower left corner, seen from z = 40 along -z. */
static asc_view flat_view(uint32_t width, uint32_t height) {
  return (asc_view){.projection = ASC_ORTHOGRAPHIC,
                    .width = width,
                    .height = height,
                    .eye = {width / 2.0, height / 2.0, 40.0},
                    .right = {1, 0, 0},
                    .up = {0, 1, 0},
                    .forward = {0, 0, -1},
                    .half_width = width / 2.0,
                    .half_height = height / 2.0,
                    .background = {0.02, 0.03, 0.05}};
}

static tracer *create(const asc_scene *scene, tracer_options options) {
  tracer *made = NULL;
  asc_error error = {{0}};
  options.struct_size = sizeof options;
  if (tracer_create_with(scene, &options, &made, &error)) fail_msg("%s", error.text);
  return made;
}

static void draw(tracer *made, const char *spec, uint64_t samples, const char *filter, float *pixels) {
  const asc_sampler_desc pattern = {sizeof pattern, spec, samples, tracer_dimensions(made), 7};
  const asc_filter_desc shape = {sizeof shape, filter};
  asc_sampler *sampler = NULL;
  asc_filter *profile = NULL;
  asc_error error = {{0}};
  if (asc_sampler_create(&pattern, &sampler, &error)) fail_msg("%s", error.text);
  if (asc_filter_create(&shape, &profile, &error)) fail_msg("%s", error.text);
  const tracer_desc desc = {sizeof desc, sampler, 1, profile};
  if (tracer_render(made, &desc, pixels, NULL, &error)) fail_msg("%s", error.text);
  asc_filter_destroy(profile);
  asc_sampler_destroy(sampler);
}

static void draw_with(const asc_scene *scene, tracer_options options, uint64_t samples, float *pixels) {
  tracer *made = create(scene, options);
  draw(made, "random", samples, "box", pixels);
  tracer_destroy(made);
}

enum { W = 37, H = 22, VALUES = W * H * 3 };

/* Surfaces of each kind that Embree holds, one that moves, a mirror, shadows, and light from surface to surface. */
typedef struct room {
  double vertices[3][9];
  uint32_t triangle_material[3], triangle_motion[3];
  asc_disc disc;
  asc_sphere sphere;
  asc_material materials[3];
  asc_motion motion;
  asc_light light;
  asc_scene scene;
} room;

static room *make_room(void) {
  room *made = calloc(1, sizeof *made);
  assert_non_null(made);
  const double vertices[3][9] = {
      {-9, -9, 0, 60, -8, -4, 5, 70, 3}, {3, 3, 5, 15, 4, 6, 9, 15, 5}, {20, 2, 7, 33, 6, 9, 25, 12, 8}};
  memcpy(made->vertices, vertices, sizeof vertices);
  made->triangle_material[1] = 1;
  made->triangle_material[2] = 2;
  made->triangle_motion[2] = 1;
  made->motion = (asc_motion){.kind = ASC_MOTION_TRANSLATE, .by = {3, 1, 0}};
  made->disc = (asc_disc){{14, 14, 9}, {0.2, 0.3, 1}, 5, 1};
  made->sphere = (asc_sphere){{28, 13, 6}, 5, 2};
  made->light = (asc_light){.kind = ASC_LIGHT_POINT, .place = {-9, 30, 60}, .intensity = {0.8, 0.7, 0.6}};
  made->materials[0] = (asc_material){.albedo = {0.7, 0.6, 0.5}};
  made->materials[1] = (asc_material){.emission = {0.1, 0.4, 0.9}, .albedo = {0.3, 0.3, 0.3}};
  made->materials[2] = (asc_material){.albedo = {0.2, 0.2, 0.2}, .reflection = {0.6, 0.5, 0.7}};
  made->scene = (asc_scene){.struct_size = sizeof made->scene,
                            .view = flat_view(W, H),
                            .materials = made->materials,
                            .material_count = 3,
                            .vertices = made->vertices[0],
                            .triangle_material = made->triangle_material,
                            .triangle_count = 3,
                            .triangle_motion = made->triangle_motion,
                            .motions = &made->motion,
                            .motion_count = 1,
                            .discs = &made->disc,
                            .disc_count = 1,
                            .spheres = &made->sphere,
                            .sphere_count = 1,
                            .lights = &made->light,
                            .light_count = 1,
                            .transport = {.mirror_bounces = 2, .diffuse_bounces = 1}};
  made->scene.view.shutter_close = 1.0;
  return made;
}

static void options_that_there_are_not_are_refused(void **state) {
  (void)state;
  const asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(6, 4)};
  const struct {
    tracer_options options;
    const char *told;
  } wrong[] = {{{.struct_size = 3}, "struct_size"},
               {{.struct_size = sizeof(tracer_options), .packet = 2}, "packets of 2 rays"},
               {{.struct_size = sizeof(tracer_options), .packet = 32}, "1, 4, 8 and 16"},
               {{.struct_size = sizeof(tracer_options), .not_robust = 2}, "no such value"},
               {{.struct_size = sizeof(tracer_options), .film = (tracer_film)3}, "no such value"}};
  for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
    tracer *made = NULL;
    asc_error error = {{0}};
    assert_int_equal(tracer_create_with(&scene, &wrong[i].options, &made, &error), ASC_INVALID_ARGUMENT);
    assert_non_null(strstr(error.text, wrong[i].told));
    assert_null(made);
  }
}

static void it_says_what_the_options_are(void **state) {
  (void)state;
  const asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(6, 4)};
  for (uint32_t width = 0; width <= 16; width = width < 2 ? 4 * width + (width == 0) : 2 * width) {
    tracer *made = create(&scene, (tracer_options){.packet = width, .not_robust = width == 4});
    tracer_kernel kernel = {0, 0, 0, 0};
    tracer_describe(made, &kernel);
    assert_int_equal(kernel.packet, width == 0 ? 16 : width);
    assert_int_equal(kernel.robust, width != 4);
    tracer_destroy(made);
  }
}

static void without_options_no_bit_changes(void **state) {
  (void)state;
  room *of = make_room();
  static float plain[VALUES], same[VALUES];
  tracer *made = NULL;
  assert_int_equal(tracer_create(&of->scene, &made, NULL), ASC_OK);
  draw(made, "random", 9, "box", plain);
  tracer_destroy(made);
  draw_with(&of->scene, (tracer_options){0}, 9, same);
  assert_memory_equal(plain, same, sizeof plain);
  draw_with(&of->scene, (tracer_options){.packet = 16, .film = TRACER_FILM_DOUBLE}, 9, same);
  assert_memory_equal(plain, same, sizeof plain);
  free(of);
}

/* The same rays meet the same surfaces; only where one passes within some roundings of an edge, 2^-24 of 40 pixels, may
 * the kernels of two widths not agree: of 7,326 paths of up to eight rays no more than a few. Elsewhere shading is in
 * double, at the surface that was met, so that the values are the same but for the float distance of what moves. */
static void packets_of_other_widths_agree_but_for_edges(void **state) {
  (void)state;
  room *of = make_room();
  static float all[VALUES], fewer[VALUES];
  const uint32_t widths[] = {1, 4, 8};
  draw_with(&of->scene, (tracer_options){0}, 9, all);
  double light = 0.0;
  for (size_t i = 0; i < VALUES; i++) light += (double)all[i];
  assert_true(light > 0.1 * VALUES);
  for (size_t k = 0; k < 3; k++) {
    int differ = 0;
    draw_with(&of->scene, (tracer_options){.packet = widths[k]}, 9, fewer);
    for (size_t i = 0; i < VALUES; i++) differ += !(fabs((double)all[i] - (double)fewer[i]) < 1e-5);
    if (differ > 3 * 3) fail_msg("packets of %u: %d values differ", widths[k], differ);
  }
  free(of);
}

enum { CELLS = 67, MESH = 128 };

/* A mesh without a hole before an eye, each of whose corners and edges lies on rays through the centres of pixels:
 * corners at every second pixel, at depths of their own. `from_eye`: 9 numbers a triangle. */
static void make_mesh_on_rays(const asc_view *view, double *from_eye) {
  static const int corners[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
  for (size_t i = 0; i < (size_t)2 * CELLS * CELLS * 3; i++) {
    const size_t cell = i / 6;
    const int x = (int)(cell % CELLS) + corners[i / 3 % 2][i % 3][0];
    const int y = (int)(cell / CELLS) + corners[i / 3 % 2][i % 3][1];
    const double depth = 40.0 + 5.0 * sin(1.3 * x) * cos(2.1 * y);
    from_eye[3 * i] = view->eye[0] + depth * view->half_width * ((2.0 * (2 * x - 2 + 0.5)) / MESH - 1.0);
    from_eye[3 * i + 1] = view->eye[1] + depth * view->half_height * (1.0 - (2.0 * (2 * y - 2 + 0.5)) / MESH);
    from_eye[3 * i + 2] = view->eye[2] - depth;
  }
}

/* One ray through the centre of each pixel, each along an edge that two triangles share or at a corner of six, to
 * within its roundings. Robust, none passes an edge, and one in a hundred passes a corner, where the signs of six edges
 * have to fit; otherwise one in ten passes an edge, and one in four a corner. So it is for each width of packets. */
static void without_robust_rays_slip_through_shared_edges(void **state) {
  (void)state;
  const size_t triangles = (size_t)2 * CELLS * CELLS;
  double *vertices = malloc(triangles * 9 * sizeof *vertices);
  uint32_t *indices = calloc(triangles, sizeof *indices);
  assert_true(vertices && indices);
  const asc_material materials[] = {{.emission = {1, 1, 1}}};
  asc_scene scene = {.struct_size = sizeof scene, .view = flat_view(MESH, MESH), .materials = materials};
  scene.view.projection = ASC_PERSPECTIVE;
  scene.view.half_width = scene.view.half_height = 0.8;
  make_mesh_on_rays(&scene.view, vertices);
  scene.material_count = 1;
  scene.vertices = vertices;
  scene.triangle_material = indices;
  scene.triangle_count = triangles;
  scene.view.background[0] = 0.0;
  static float pixels[MESH * MESH * 3];
  const uint32_t widths[] = {1, 4, 8, 16};
  const int corners = MESH * MESH / 4, edges = 3 * corners;
  for (size_t k = 0; k < 4; k++) {
    for (uint32_t off = 0; off < 2; off++) {
      tracer *made = create(&scene, (tracer_options){.packet = widths[k], .not_robust = off});
      draw(made, "regular", 1, "box", pixels);
      tracer_destroy(made);
      int missed[2] = {0, 0};
      for (size_t i = 0; i < (size_t)MESH * MESH; i++) missed[i % 2 == 0 && i / MESH % 2 == 0] += pixels[3 * i] == 0.0f;
      if (off) {
        assert_true(missed[0] > edges / 50 && missed[1] > corners / 20);
        assert_true(missed[0] < edges / 4 && missed[1] < corners / 2);
      } else {
        assert_int_equal(missed[0], 0);
        assert_true(missed[1] < corners / 20);
      }
    }
  }
  free(vertices);
  free(indices);
}

/* A gradient over a few pixels, seen 2^20 times in each. */
static void draw_gradient(tracer_film kept, const char *filter, uint64_t samples, float pixels[4 * 3]) {
  asc_material material = {.emission = {1, 1, 1}};
  material.pattern = (asc_pattern){ASC_PATTERN_ZONE_PLATE, 0.9, {0.3, 0.4, 0}, {0, 0.1, 0.2}, {1, 0.9, 0.5}};
  const asc_disc plate = {{1, 1, 0}, {0, 0, 1}, 40, 0};
  const asc_scene scene = {.struct_size = sizeof scene,
                           .view = flat_view(2, 2),
                           .materials = &material,
                           .material_count = 1,
                           .discs = &plate,
                           .disc_count = 1};
  tracer *made = create(&scene, (tracer_options){.film = kept});
  draw(made, "random", samples, filter, pixels);
  tracer_destroy(made);
}

/* A sum of n numbers that are not negative, in an arithmetic with unit roundoff u, is off by (n - 1) u of itself at
 * most (Higham 2002, section 4.2), here 6 %. (Not by the root of n: like samples are rounded alike to the last place of
 * a large sum.) It is off by more than the last bit of the result, or it was not added in float. With one sample
 * nothing is added. */
static void float_sums_are_as_far_off_as_theory_says(void **state) {
  (void)state;
  const uint64_t samples = 1 << 20;
  const double unit = 0.5 * (double)FLT_EPSILON, n = (double)samples;
  float exact[12], kept[12];
  draw_gradient(TRACER_FILM_DOUBLE, "box", samples, exact);
  draw_gradient(TRACER_FILM_FLOAT, "box", samples, kept);
  double largest = 0.0;
  for (size_t i = 0; i < 12; i++) {
    const double off = fabs((double)kept[i] - (double)exact[i]) / (double)exact[i];
    assert_true(off <= (n - 1.0) * unit);
    largest = fmax(largest, off);
  }
  assert_true(largest > 100.0 * unit);
  draw_gradient(TRACER_FILM_DOUBLE, "box", 1, exact);
  draw_gradient(TRACER_FILM_FLOAT, "box", 1, kept);
  for (size_t i = 0; i < 12; i++) assert_true(kept[i] == exact[i]);
}

/* The same of a wide filter, whose weights are partly negative: the sum of their magnitudes bounds the error then,
 * below 1.7 for mitchell in two dimensions, over some 25 n samples that a pixel takes; and of its plain mean, n. */
static void float_sums_of_a_wide_filter_too(void **state) {
  (void)state;
  const uint64_t samples = 1 << 16;
  const double unit = 0.5 * (double)FLT_EPSILON, n = (double)samples;
  float exact[12], kept[12];
  draw_gradient(TRACER_FILM_DOUBLE, "mitchell", samples, exact);
  draw_gradient(TRACER_FILM_FLOAT, "mitchell", samples, kept);
  double largest = 0.0;
  for (size_t i = 0; i < 12; i++) {
    const double off = fabs((double)kept[i] - (double)exact[i]);
    assert_true(off <= 1.7 * 25.0 * n * unit);
    largest = fmax(largest, off);
  }
  assert_true(largest > 100.0 * unit);
}

/* Off by 2 n u^2 of the sum at most, for the box's 2^20 samples u/8, beside a rounding of each sample and one of the
 * mean, as the double's has; a plain sum of floats is off by thousands of u. Negative lobes: of 1.7 times as much, with
 * 25 pixels' samples, as above, so 3/16 u. */
static void compensated_sums_are_those_of_double(void **state) {
  (void)state;
  const double unit = 0.5 * (double)FLT_EPSILON;
  float exact[12], kept[12];
  draw_gradient(TRACER_FILM_DOUBLE, "box", 1 << 20, exact);
  draw_gradient(TRACER_FILM_COMPENSATED, "box", 1 << 20, kept);
  for (size_t i = 0; i < 12; i++)
    assert_true(fabs((double)kept[i] - (double)exact[i]) <= 3.2 * unit * (double)exact[i]);
  draw_gradient(TRACER_FILM_DOUBLE, "mitchell", 1 << 16, exact);
  draw_gradient(TRACER_FILM_COMPENSATED, "mitchell", 1 << 16, kept);
  for (size_t i = 0; i < 12; i++) assert_true(fabs((double)kept[i] - (double)exact[i]) <= 3.2 * 1.7 * unit);
  draw_gradient(TRACER_FILM_DOUBLE, "box", 1, exact);
  draw_gradient(TRACER_FILM_COMPENSATED, "box", 1, kept);
  for (size_t i = 0; i < 12; i++) assert_true(kept[i] == exact[i]);
}

/* Where it is hard: what is smaller than the sum's last place, past 2^24 times; a sample that outshines the sum, and
 * one that takes it away; the largest float passed. */
static void compensated_sums_lose_nothing_that_returns(void **state) {
  (void)state;
  film_cell_compensated sum = {{0}, {0}};
  film_cell read;
  for (uint32_t i = 0; i < 40000000; i++) film_add_compensated(&sum, (film_cell_single){1.0f, 0.25f, 0.0f, 0.0f});
  film_read_compensated(&sum, &read);
  assert_true(read[0] == 4e7 && read[1] == 1e7);
  sum = (film_cell_compensated){{0}, {0}};
  for (int i = 0; i < 1000; i++) film_add_compensated(&sum, (film_cell_single){1.0f, 3.0f, FLT_MAX, 0.0f});
  film_add_compensated(&sum, (film_cell_single){1e10f, -1e10f, 1.0f, 0.0f});
  for (int i = 0; i < 1000; i++) film_add_compensated(&sum, (film_cell_single){1.0f, 3.0f, 1.0f, 0.0f});
  film_add_compensated(&sum, (film_cell_single){-1e10f, 1e10f, 1.0f, 0.0f});
  film_read_compensated(&sum, &read);
  assert_true(read[0] == 2000.0 && read[1] == 6000.0 && isinf(read[2]) && read[2] > 0.0);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(options_that_there_are_not_are_refused),
      cmocka_unit_test(it_says_what_the_options_are),
      cmocka_unit_test(without_options_no_bit_changes),
      cmocka_unit_test(packets_of_other_widths_agree_but_for_edges),
      cmocka_unit_test(without_robust_rays_slip_through_shared_edges),
      cmocka_unit_test(float_sums_are_as_far_off_as_theory_says),
      cmocka_unit_test(float_sums_of_a_wide_filter_too),
      cmocka_unit_test(compensated_sums_are_those_of_double),
      cmocka_unit_test(compensated_sums_lose_nothing_that_returns),
  };
  return cmocka_run_group_tests_name("tracer's options", tests, NULL, NULL);
}

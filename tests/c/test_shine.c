/* Shading in rows: its arithmetic, and the same bits as of lanes that are followed one by one. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "arithmetic.h"
#include "hash.h"
#include "scene.h"

static double random_unit(uint64_t *state) { return (double)(asc_mix64((*state)++ * ASC_GOLDEN) >> 11) * 0x1p-53; }

/* By mpmath with 300 bits; the first five are the doubles nearest to zeros of the cosine, up to HAVERCOSINE_MOST. */
static void havercosines_are_those_of_mpmath(void **state) {
  (void)state;
  static const struct {
    double x;
    long double havercosine;
  } known[] = {{0x1.6c6cbc45dc8dep+5, 0.49999999999999999969L},
               {0x1.39c6fd67805a7p+18, 0.49999999999999997785L},
               {0x1.921fb54442d18p+0, 0.50000000000000003062L},
               {0x1.67e57cdd4dc54p+15, 0.50000000000000006797L},
               {0x1.635e3d74befcap+14, 0.49999999999999990951L},
               {0.5, 0.93879128094518635806L},
               {1.0, 0.7701511529340698587L},
               {2.0, 0.2919265817264288065L},
               {300.25, 0.61296693209122378157L},
               {98.43, 0.24716060349692202555L},
               {125000.0, 0.16259668773088275438L},
               {HAVERCOSINE_MOST, 0.92038222410280589179L}};
  for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
    for (int sign = -1; sign <= 1; sign += 2) {
      const long double off = havercosine(sign * known[i].x) - known[i].havercosine;
      if (!(fabsl(off) <= 3e-16L)) fail_msg("of %.17g: off by %Lg", known[i].x, off);
    }
  }
  assert_true(havercosine(0.0) == 1.0 && isnan(havercosine(NAN)));
  assert_true(havercosine_of_any(1e300) == 0.5 * (1.0 + cos(1e300)));
}

/* The C library's, of 64 bits, is off by 2^-64 at most. The largest of 10^8 such differences was 2.75e-16. */
static void havercosines_are_within_what_is_said(void **state) {
  (void)state;
  uint64_t numbers = 1;
  for (int i = 0; i < 300000; i++) {
    const double x = (2.0 * random_unit(&numbers) - 1.0) * HAVERCOSINE_MOST * pow(2.0, -(i % 30));
    const long double off = fabsl(havercosine(x) - 0.5L * (1.0L + cosl(x)));
    if (!(off <= 3e-16L)) fail_msg("of %.17g: off by %Lg", x, off);
  }
}

/* --- pictures -------------------------------------------------------------------------------------------------------
 */

enum { WIDTH = 37, HEIGHT = 26, NUMBERS = WIDTH * HEIGHT * 3 };

/* Patterned surfaces of every kind: two triangles of one square, which share packets, a disc, a sphere, and endless
 * planes, one of which cuts the others. */
typedef struct subject {
  double vertices[27];
  uint32_t materials_of[3];
  asc_material materials[4];
  asc_disc discs[1];
  asc_sphere spheres[1];
  asc_plane planes[3];
  asc_scene scene;
} subject;

static asc_material patterned(asc_pattern_kind kind, double scale) {
  return (asc_material){.emission = {0.9, 0.7, 1.3},
                        .pattern = {kind, scale, {0.31, -0.17, 0.23}, {0.1, 0.2, 0.3}, {0.9, 0.8, 0.7}}};
}

static void set_scene(subject *of, asc_projection projection, double lens_radius) {
  *of = (subject){.vertices = {-2.1, -1.2, 0.1, 1.3, -1.1, 0.3, 1.2, 1.4, 0.2, -2.1, -1.2, 0.1, 1.2, 1.4,
                               0.2,  -1.9, 1.3, 0,   0.1,  0.2, 0.9, 0.6, 0.3, 0.8,  0.3,  0.9, 0.7},
                  .materials_of = {0, 0, 2},
                  .materials = {patterned(ASC_PATTERN_ZONE_PLATE, 31.0), patterned(ASC_PATTERN_CHECKER, 3.7),
                                patterned(ASC_PATTERN_NONE, 1.0), patterned(ASC_PATTERN_ZONE_PLATE, 1.3e6)},
                  .discs = {{{0.9, 0.4, 0.5}, {0.1, 0.2, 1.0}, 0.5, 1}},
                  .spheres = {{{-1.1, 0.7, 0.4}, 0.3, 0}},
                  .planes = {{{0, -0.9, 0}, {0.0, 1.0, 0.1}, 1},
                             {{0, 0, -1.2}, {0.1, 0.0, 1.0}, 3},
                             {{0, 0.9, 0}, {0.0, 1.0, -0.1}, 2}}};
  asc_scene *scene = &of->scene;
  *scene = (asc_scene){.struct_size = sizeof *scene,
                       .view = {.projection = projection,
                                .width = WIDTH,
                                .height = HEIGHT,
                                .eye = {0.1, 0.2, 4.0},
                                .right = {0.8, 0.0, 0.6},
                                .up = {0.0, 1.0, 0.0},
                                .forward = {0.6, 0.0, -0.8},
                                .half_width = projection == ASC_PERSPECTIVE ? 0.6 : 2.0,
                                .half_height = projection == ASC_PERSPECTIVE ? 0.42 : 1.4,
                                .background = {0.02, 0.03, 0.05},
                                .lens_radius = lens_radius,
                                .focus_distance = 4.0}};
  if (projection == ASC_ORTHOGRAPHIC) {
    memcpy(scene->view.right, (double[3]){1.0, 0.0, 0.0}, sizeof scene->view.right);
    memcpy(scene->view.forward, (double[3]){0.0, 0.0, -1.0}, sizeof scene->view.forward);
  }
  scene->materials = of->materials;
  scene->material_count = 4;
  scene->vertices = of->vertices;
  scene->triangle_material = of->materials_of;
  scene->triangle_count = 3;
  scene->discs = of->discs;
  scene->disc_count = 1;
}

/* Renders once by rows and once lane by lane. */
static void assert_same(const asc_scene *scene, const char *spec, const char *profile, uint64_t samples,
                        const char *what) {
  static float rows[NUMBERS], lanes[NUMBERS];
  tracer *made = NULL;
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  if (tracer_create(scene, &made, &error)) fail_msg("%s", error.text);
  const asc_sampler_desc pattern = {sizeof pattern, spec, samples, tracer_dimensions(made), 3};
  assert_int_equal(asc_sampler_create(&pattern, &sampler, &error), ASC_OK);
  asc_filter *filter = NULL;
  assert_int_equal(asc_filter_create(&(asc_filter_desc){sizeof(asc_filter_desc), profile}, &filter, &error), ASC_OK);
  const tracer_desc desc = {.struct_size = sizeof desc, .sampler = sampler, .threads = 1, .filter = filter};
  assert_true(made->shines_alone && !made->plain);
  assert_int_equal(tracer_render(made, &desc, rows, NULL, &error), ASC_OK);
  made->shines_alone = 0;
  assert_int_equal(tracer_render(made, &desc, lanes, NULL, &error), ASC_OK);
  for (size_t i = 0; i < NUMBERS; i++)
    if (rows[i] != lanes[i])
      fail_msg("%s, %d samples, number %zu: %.9g, %.9g", what, (int)samples, i, rows[i], lanes[i]);
  asc_filter_destroy(filter);
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

/* 16 samples are a packet of a pixel, 5 are of several pixels, 1100 are more than are drawn at a time. */
static void rows_give_the_bits_of_lanes(void **state) {
  (void)state;
  static const struct {
    const char *name;
    asc_projection projection;
    double lens_radius;
  } views[] = {
      {"orthographic", ASC_ORTHOGRAPHIC, 0.0}, {"perspective", ASC_PERSPECTIVE, 0.0}, {"lens", ASC_PERSPECTIVE, 0.2}};
  static const uint64_t counts[] = {16, 5, 64, 1100};
  for (size_t k = 0; k < 3; k++) {
    for (size_t planes = 0; planes <= 3; planes++) {
      for (int with_sphere = 0; with_sphere < 2; with_sphere++) {
        for (size_t n = 0; n < (planes == 3 ? 4 : 2); n++) {
          subject of;
          set_scene(&of, views[k].projection, views[k].lens_radius);
          of.scene.planes = of.planes;
          of.scene.plane_count = planes;
          of.scene.spheres = of.spheres;
          of.scene.sphere_count = (size_t)with_sphere;
          assert_same(&of.scene, "sobol:scramble=owen", "box", counts[n], views[k].name);
        }
      }
    }
  }
}

/* Where samples have weights, and where they count in other pixels too. */
static void weighted_and_filtered_rows_give_the_bits_of_lanes(void **state) {
  (void)state;
  subject of;
  set_scene(&of, ASC_ORTHOGRAPHIC, 0.0);
  assert_same(&of.scene, "gauss-legendre", "box", 49, "weights");
  assert_same(&of.scene, "clenshaw-curtis", "box", 16, "weights");
  assert_same(&of.scene, "sobol:scramble=owen", "mitchell", 16, "filter");
}

/* A plane that is square to the view, at different distances of the eye, and one that is not. */
static void facing_planes_give_the_bits_of_lanes(void **state) {
  (void)state;
  for (int slant = 0; slant < 2; slant++) {
    subject of;
    set_scene(&of, ASC_ORTHOGRAPHIC, 0.0);
    for (int i = 0; i < 9; i++) of.vertices[3 * i + 2] = slant ? 0.07 * i : 0.3;
    assert_same(&of.scene, "sobol:scramble=owen", "box", 16, slant ? "slanting" : "facing");
  }
}

/* Planes that the rays run along are not met; nor is there anything but background beside. */
static void rays_along_a_plane_meet_none(void **state) {
  (void)state;
  subject of;
  set_scene(&of, ASC_ORTHOGRAPHIC, 0.0);
  of.planes[0] = (asc_plane){{0, -0.9, 0}, {0.0, 1.0, 0.0}, 1};
  of.scene.planes = of.planes;
  of.scene.plane_count = 1;
  of.scene.triangle_count = of.scene.disc_count = 0;
  static float pixels[NUMBERS];
  tracer *made = NULL;
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  assert_int_equal(tracer_create(&of.scene, &made, &error), ASC_OK);
  const asc_sampler_desc pattern = {sizeof pattern, "random", 16, 2, 3};
  assert_int_equal(asc_sampler_create(&pattern, &sampler, &error), ASC_OK);
  const tracer_desc desc = {.struct_size = sizeof desc, .sampler = sampler, .threads = 1};
  assert_int_equal(tracer_render(made, &desc, pixels, NULL, &error), ASC_OK);
  for (size_t i = 0; i < NUMBERS; i++) assert_true(pixels[i] == (float)of.scene.view.background[i % 3]);
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(havercosines_are_those_of_mpmath),
      cmocka_unit_test(havercosines_are_within_what_is_said),
      cmocka_unit_test(rows_give_the_bits_of_lanes),
      cmocka_unit_test(weighted_and_filtered_rows_give_the_bits_of_lanes),
      cmocka_unit_test(facing_planes_give_the_bits_of_lanes),
      cmocka_unit_test(rays_along_a_plane_meet_none),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

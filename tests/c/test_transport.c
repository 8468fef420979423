/* Light transport: estimates that weigh their parts otherwise have one mean, and bad numbers are refused. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene.h"
#include "tracer.h"

enum { SIDE = 8, SAMPLES = 64, ROUNDS = 60, WALLS = 10 };

/* A box of walls, a lamp of two triangles and one of a disc, a ball that shines and turns, a glossy and a mirror ball.
 */
typedef struct room {
  asc_material materials[6];
  double vertices[(WALLS + 2) * 9];
  uint32_t triangle_material[WALLS + 2];
  asc_disc disc;
  asc_sphere spheres[3];
  asc_motion motion;
  uint32_t sphere_motion[3];
  asc_scene scene;
} room;

static void set_quad(room *made, size_t first, const double corner[3], const double a[3], const double b[3],
                     uint32_t material) {
  const double along[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
  for (size_t k = 0; k < 6; k++)
    for (size_t i = 0; i < 3; i++)
      made->vertices[9 * first + 3 * k + i] = corner[i] + along[k][0] * a[i] + along[k][1] * b[i];
  made->triangle_material[first] = made->triangle_material[first + 1] = material;
}

/* 0 wall, 1 lamp, 2 glow, 3 glossy, 4 mirror, 5 board */
static void furnish(room *made) {
  *made = (room){.materials = {{.albedo = {0.7, 0.5, 0.3}},
                               {.emission = {4, 5, 6}, .albedo = {0.2, 0.2, 0.2}},
                               {.emission = {0.3, 1.5, 0.9}},
                               {.albedo = {0.3, 0.3, 0.1}, .reflection = {0.6, 0.5, 0.6}},
                               {.albedo = {0.1, 0.1, 0.1}, .reflection = {0.8, 0.9, 0.7}},
                               {.emission = {0.5, 0.2, 0.4}, .albedo = {0.5, 0.5, 0.5}}}};
  made->materials[3].gloss = (asc_lobe){.kind = ASC_LOBE_GGX, .roughness = 0.3};
  made->materials[5].pattern = (asc_pattern){ASC_PATTERN_CHECKER, 3.3, {0.1, 0.2, 0.3}, {0, 0, 0}, {1, 1, 1}};
  const double x[3] = {2, 0, 0}, y[3] = {0, 2, 0}, z[3] = {0, 0, 2}, low[3] = {-1, -1, -1};
  set_quad(made, 0, low, x, y, 3); /* the back is glossy */
  set_quad(made, 2, low, z, x, 5);
  set_quad(made, 4, low, y, z, 0);
  set_quad(made, 6, (const double[]){1, -1, -1}, y, z, 0);
  set_quad(made, 8, (const double[]){-1, 1, -1}, x, z, 0);
  set_quad(made, 10, (const double[]){-0.5, 0.9, -0.6}, (const double[]){0.7, 0, 0}, (const double[]){0, 0.05, 0.8}, 1);
  made->disc = (asc_disc){{0.9, 0.1, -0.3}, {1, 0.1, 0.2}, 0.3, 2};
  made->spheres[0] = (asc_sphere){{-0.3, 0.1, -0.4}, 0.2, 2};
  made->spheres[1] = (asc_sphere){{0.4, -0.6, -0.3}, 0.35, 3};
  made->spheres[2] = (asc_sphere){{-0.5, -0.7, -0.2}, 0.3, 4};
  made->motion = (asc_motion){.kind = ASC_MOTION_ROTATE, .axis = {0, 1, 0.2}, .centre = {0, 0, -0.5}, .angle = 1};
  made->sphere_motion[0] = 1;
  made->scene = (asc_scene){.struct_size = sizeof(asc_scene),
                            .view = {.projection = ASC_PERSPECTIVE,
                                     .width = SIDE,
                                     .height = SIDE,
                                     .eye = {0.1, 0.05, 2.4},
                                     .right = {1, 0, 0},
                                     .up = {0, 1, 0},
                                     .forward = {0, 0, -1},
                                     .half_width = 0.5,
                                     .half_height = 0.5,
                                     .background = {0.2, 0.1, 0.3},
                                     .shutter_close = 1},
                            .materials = made->materials,
                            .material_count = 6,
                            .vertices = made->vertices,
                            .triangle_material = made->triangle_material,
                            .triangle_count = WALLS + 2,
                            .discs = &made->disc,
                            .disc_count = 1,
                            .spheres = made->spheres,
                            .sphere_count = 3,
                            .motions = &made->motion,
                            .motion_count = 1,
                            .sphere_motion = made->sphere_motion,
                            .transport = {.mirror_bounces = 3, .diffuse_bounces = 4}};
}

static tracer *built(const room *of) {
  tracer *made = NULL;
  asc_error error = {{0}};
  if (tracer_create(&of->scene, &made, &error)) fail_msg("%s", error.text);
  return made;
}

/* The mean of a picture. */
static double mean_of(tracer *made, uint64_t seed) {
  const asc_sampler_desc pattern = {sizeof pattern, "random", SAMPLES, tracer_dimensions(made), seed};
  asc_sampler *sampler = NULL;
  assert_int_equal(asc_sampler_create(&pattern, &sampler, NULL), ASC_OK);
  const tracer_desc desc = {.struct_size = sizeof desc, .sampler = sampler, .threads = 1};
  float pixels[SIDE * SIDE * 3];
  assert_int_equal(tracer_render(made, &desc, pixels, NULL, NULL), ASC_OK);
  asc_sampler_destroy(sampler);
  double sum = 0.0;
  for (int i = 0; i < SIDE * SIDE * 3; i++) sum += pixels[i];
  return sum / (SIDE * SIDE * 3);
}

typedef struct estimate {
  double mean, variance; /* of the mean */
} estimate;

static estimate estimate_of(const double values[ROUNDS]) {
  double mean = 0.0, squares = 0.0;
  for (int i = 0; i < ROUNDS; i++) mean += values[i] / ROUNDS;
  for (int i = 0; i < ROUNDS; i++) squares += (values[i] - mean) * (values[i] - mean);
  return (estimate){mean, squares / (ROUNDS * (ROUNDS - 1.0))};
}

/* Ways to find emitters differ in variance alone: three pairs, each of two means of 60 pictures, at 4 standard errors:
 * 2e-4 that one fails by chance, and with these seeds none does. Of what they have in common, a share of 1 % would
 * show.
 */
static void ways_to_find_emitters_have_one_mean(void **state) {
  (void)state;
  static room of;
  furnish(&of);
  tracer *made = built(&of);
  assert_int_equal(tracer_dimensions(made), 2 + 1 + 2 + 7 * 3);
  estimate found[3];
  for (int way = 0; way < 3; way++) {
    double values[ROUNDS];
    made->transport.emission_from = (emission_from)way;
    for (uint64_t i = 0; i < ROUNDS; i++) values[i] = mean_of(made, 1000 * (uint64_t)way + i);
    found[way] = estimate_of(values);
    print_message("way %d: %.5f +- %.5f\n", way, found[way].mean, sqrt(found[way].variance));
  }
  for (int i = 0; i < 3; i++) {
    const estimate a = found[i], b = found[(i + 1) % 3];
    assert_true(fabs(a.mean - b.mean) < 4.0 * sqrt(a.variance + b.variance));
  }
  assert_true(sqrt(found[FROM_BOTH].variance) < 0.005 * found[FROM_BOTH].mean);
  assert_true(found[FROM_BOTH].variance < found[FROM_EMITTERS].variance);
  assert_true(found[FROM_BOTH].variance < found[FROM_RAYS].variance);
  tracer_destroy(made);
}

/* The same samples with paths that end by chance from the first bounce on, and with ones that never do: the difference
 * of the pairs at 4 standard errors, 6e-5 by chance. */
static void roulette_does_not_move_the_mean(void **state) {
  (void)state;
  static room of;
  furnish(&of);
  tracer *made = built(&of);
  double differences[ROUNDS], whole[ROUNDS];
  uint32_t other = 0;
  for (uint64_t i = 0; i < ROUNDS; i++) {
    made->transport.roulette_from = 64;
    whole[i] = mean_of(made, 70000 + i);
    made->transport.roulette_from = 0;
    differences[i] = mean_of(made, 70000 + i) - whole[i];
    other += differences[i] != 0.0;
  }
  const estimate off = estimate_of(differences), all = estimate_of(whole);
  print_message("roulette: %.5f +- %.5f of %.5f\n", off.mean, sqrt(off.variance), all.mean);
  assert_true(fabs(off.mean) < 4.0 * sqrt(off.variance));
  assert_true(sqrt(off.variance) < 0.01 * all.mean);
  assert_int_equal(other, ROUNDS);
  tracer_destroy(made);
}

/* Refused, by a message that has these words. */
static void refused(const room *of, const char *words) {
  tracer *made = NULL;
  asc_error error = {{0}};
  assert_int_equal(tracer_create(&of->scene, &made, &error), ASC_INVALID_ARGUMENT);
  if (!strstr(error.text, words)) fail_msg("\"%s\" does not say \"%s\"", error.text, words);
  assert_null(made);
}

static void broken_lobes_and_shares_are_refused(void **state) {
  (void)state;
  static room of;
  const double exponents[] = {NAN, -1.0, 0.5, INFINITY, 2e6}, roughnesses[] = {NAN, -0.1, 0.0, INFINITY, 1.5};
  for (int i = 0; i < 5; i++) {
    furnish(&of);
    of.materials[3].gloss = (asc_lobe){.kind = ASC_LOBE_PHONG, .exponent = exponents[i]};
    refused(&of, "material 3 has an exponent");
    of.materials[3].gloss = (asc_lobe){.kind = ASC_LOBE_GGX, .roughness = roughnesses[i]};
    refused(&of, "material 3 has a roughness");
  }
  of.materials[3].gloss.kind = (asc_lobe_kind)9;
  refused(&of, "unknown lobe");
  furnish(&of);
  of.materials[4].reflection[1] = -0.5;
  refused(&of, "material 4 has a reflection");
  of.materials[4].reflection[1] = 0.95;
  refused(&of, "material 4 has a reflection");
  of.materials[4].reflection[1] = NAN;
  refused(&of, "material 4 has a number that is not finite");
  furnish(&of);
  of.materials[0].albedo[0] = 1.2; /* scattered again and again it would grow */
  refused(&of, "material 0");
  of.materials[0].albedo[0] = -0.2;
  refused(&of, "negative albedo");
  furnish(&of);
  of.scene.transport.diffuse_bounces = 65;
  refused(&of, "at most 64");
}

/* What the surfaces do not ask for has no dimension. */
static void dimensions_follow_from_what_surfaces_have(void **state) {
  (void)state;
  static room of;
  furnish(&of);
  of.scene.motion_count = 0;
  of.scene.sphere_motion = NULL;
  const struct {
    uint32_t mirrors, scatters, glossy, dimensions;
  } cases[] = {{3, 4, 1, 2 + 2 + 21}, {3, 0, 1, 2 + 2 + 6}, {3, 0, 0, 2}, {0, 4, 1, 2 + 2 + 12}, {0, 0, 1, 2}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    of.scene.transport = (asc_transport){.mirror_bounces = cases[i].mirrors, .diffuse_bounces = cases[i].scatters};
    of.materials[3].gloss.kind = cases[i].glossy ? ASC_LOBE_GGX : ASC_LOBE_MIRROR;
    tracer *made = built(&of);
    assert_int_equal(tracer_dimensions(made), cases[i].dimensions);
    tracer_destroy(made);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ways_to_find_emitters_have_one_mean),
      cmocka_unit_test(roulette_does_not_move_the_mean),
      cmocka_unit_test(broken_lobes_and_shares_are_refused),
      cmocka_unit_test(dimensions_follow_from_what_surfaces_have),
  };
  return cmocka_run_group_tests_name("transport", tests, NULL, NULL);
}

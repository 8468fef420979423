/* What the rasteriser refuses, and with which words. */
#include "raster_scenes.h"

static stage *fine_stage(void) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const double quad[4][2] = {{3.3, 2.2}, {8.2, 2.2}, {8.2, 4.3}, {3.3, 4.3}};
  add_quad(s, quad, 0.0, add_material(s, 1.0, 1.0, 1.0));
  add_disc(s, 5.0, 5.0, 1.0, 0);
  add_sphere(s, 1.0, 1.0, 1.0, 1.0, 0);
  add_plane(s, s->spheres[0].centre, s->discs[0].normal, 0);
  add_light(s, ASC_LIGHT_DIRECTIONAL, 0.0, 0.0, -1.0);
  return s;
}

/* Expects that the stage is refused, with a text that has this word, and frees it. */
static void refused_as(stage *s, asc_status status, const char *word) {
  raster *made = NULL;
  asc_error error = {""};
  assert_int_equal(raster_create(&s->scene, &made, &error), status);
  assert_null(made);
  if (!strstr(error.text, word)) {
    fail_msg("\"%s\" does not speak of \"%s\"", error.text, word);
  }
  assert_int_equal(raster_create(&s->scene, &made, NULL), status);
  free(s);
}

static void refused(stage *s, const char *word) { refused_as(s, ASC_INVALID_ARGUMENT, word); }

#define REFUSED(change, word)                                                                                          \
  do {                                                                                                                 \
    stage *s = fine_stage();                                                                                           \
    change;                                                                                                            \
    refused(s, word);                                                                                                  \
  } while (0)

static void test_bad_scenes_are_refused(void **state) {
  (void)state;
  REFUSED(s->scene.struct_size = 0, "struct_size");
  REFUSED(s->scene.view.width = 0, "0 x 14");
  REFUSED(s->scene.view.height = 16385, "20 x 16385");
  REFUSED(s->scene.view.half_width = 0.0, "half_width");
  REFUSED(s->scene.view.half_height = (double)NAN, "half_height");
  REFUSED(s->scene.view.eye[1] = (double)INFINITY, "eye");
  REFUSED(s->scene.view.background[2] = (double)NAN, "background");
  REFUSED(s->scene.view.shift[0] = (double)NAN, "shift");
  REFUSED(s->scene.view.up[1] = 2.0, "orthonormal");
  REFUSED(s->scene.view.right[0] = (double)NAN, "orthonormal");
  REFUSED(s->scene.view.projection = (asc_projection)2, "projection");
  REFUSED(s->vertices[1][2][0] = (double)NAN, "triangle 1");
  REFUSED(s->vertices[1][2][0] = 2e30, "triangle 1");
  REFUSED(s->triangle_material[1] = 1, "triangle 1 names material 1");
  REFUSED(s->scene.vertices = NULL, "NULL");
  REFUSED(s->materials[0].emission[0] = (double)NAN, "material 0");
  REFUSED(s->materials[0].pattern.kind = (asc_pattern_kind)7, "pattern");
  REFUSED((s->materials[0].pattern.kind = ASC_PATTERN_ZONE_PLATE, s->materials[0].pattern.scale = (double)NAN),
          "material 0");
  REFUSED(s->discs[0].radius = 0.0, "disc 0");
  REFUSED(s->discs[0].normal[2] = 0.0, "disc 0");
  REFUSED(s->discs[0].material = 9, "disc 0 names material 9");
  REFUSED(s->spheres[0].centre[0] = (double)NAN, "sphere 0");
  REFUSED(s->spheres[0].radius = -1.0, "sphere 0");
  REFUSED(s->spheres[0].material = 1, "sphere 0 names");
  REFUSED(s->materials[0].albedo[1] = (double)NAN, "material 0");
  REFUSED(s->scene.planes = NULL, "NULL");
  REFUSED(s->planes[0].normal[2] = 0.0, "plane 0");
  REFUSED(s->planes[0].point[1] = (double)INFINITY, "plane 0");
  REFUSED(s->planes[0].material = 1, "plane 0 names");
  REFUSED(s->scene.lights = NULL, "NULL");
  REFUSED(s->lights[0].kind = (asc_light_kind)5, "light 0");
  REFUSED(s->lights[0].place[2] = 0.0, "direction");
  REFUSED(s->lights[0].intensity[0] = (double)NAN, "light 0");
  REFUSED(s->lights[0].inverse_square = 2, "inverse_square");
  asc_error error = {""};
  assert_int_equal(raster_create(NULL, NULL, &error), ASC_INVALID_ARGUMENT);
}

/* Spheres in a row behind the eye, at x = 0, 1, 2, ... */
static stage *crowd(asc_sphere *spheres, size_t count, size_t lights) {
  stage *s = fine_stage();
  for (size_t i = 0; i < count; ++i) {
    const asc_sphere one_more = {{(double)i, 0.0, 20.0}, 0.25, 0};
    spheres[i] = one_more;
  }
  s->scene.spheres = spheres;
  s->scene.sphere_count = count;
  while (s->scene.light_count < lights) {
    add_light(s, ASC_LIGHT_POINT, 0.0, 0.0, 30.0);
  }
  s->materials[0].albedo[2] = 0.5;
  return s;
}

/* As many surfaces as there may be, 2 triangles, a disc and a plane among them, and the last of them casts its shadow;
 * with one more, or with as many and a second light, there is no picture without shadows but none. */
static void test_more_shadows_than_can_be_tested_are_refused(void **state) {
  (void)state;
  static asc_sphere spheres[RASTER_MOST_SHADOW_TESTS];
  const size_t most = RASTER_MOST_SHADOW_TESTS - 4;
  stage *s = crowd(spheres, most, 1);
  const asc_sphere before_the_sun = {{-6.0, 3.0, 20.0}, 2.0, 0};
  spheres[most - 1] = before_the_sun;
  const double disc_behind[3] = {0.0, 0.0, -5.0};
  memcpy(s->planes[0].point, disc_behind, sizeof disc_behind);
  float pixels[3 * PIXELS];
  raster *made = made_of(s);
  free(s);
  render(made, 1, unmoved, one, 1, pixels);
  raster_destroy(made);
  const float *shaded = pixels + 3 * (3 * WIDTH + 3);
  const float *lit = pixels + 3 * (9 * WIDTH + 3);
  assert_true(shaded[2] == 1.0F && lit[2] == 1.125F);

  refused_as(crowd(spheres, most + 1, 1), ASC_UNSUPPORTED, "2 triangles, 1 discs, 1021 spheres, 1 planes");
  refused_as(crowd(spheres, most / 2 - 1, 2), ASC_UNSUPPORTED, "with 2 lights 512 surfaces");
  /* Nothing takes light: then there are no shadows either. */
  s = crowd(spheres, most + 1, 2);
  s->materials[0].albedo[2] = 0.0;
  raster_destroy(made_of(s));
  free(s);
}

static asc_status try_render(raster *made, uint32_t samples, const double *offset, const double *weight, size_t count) {
  const raster_desc desc = passes_of(samples, offset, weight, count, 0);
  return try_desc(made, &desc);
}

static void test_what_only_the_tracer_draws_is_refused(void **state) {
  (void)state;
  asc_sphere sphere;
  stage *s = crowd(&sphere, 1, 1);
  s->materials[0].reflection[1] = 0.1;
  refused_as(s, ASC_UNSUPPORTED, "mirrors");
  s = crowd(&sphere, 1, 1);
  s->scene.transport.diffuse_bounces = 1;
  refused_as(s, ASC_UNSUPPORTED, "bounces");
}

static void test_bad_requests_are_refused(void **state) {
  (void)state;
  stage *s = fine_stage();
  raster *made = made_of(s);
  free(s);
  const double outside[2] = {0.5, 1.0};
  const double nowhere[2] = {(double)NAN, 0.5};
  const double infinite[1] = {(double)INFINITY};
  assert_int_equal(try_render(made, 1, unmoved, one, 1), ASC_OK);
  assert_int_equal(try_render(made, 2, unmoved, one, 1), ASC_UNSUPPORTED);
  assert_int_equal(try_render(made, 8, unmoved, one, 1), ASC_UNSUPPORTED);
  assert_int_equal(try_render(made, 1, unmoved, one, 0), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_render(made, 1, NULL, one, 1), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_render(made, 1, outside, one, 1), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_render(made, 1, nowhere, one, 1), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_render(made, 1, unmoved, infinite, 1), ASC_INVALID_ARGUMENT);
  const raster_desc shading = passes_of(4, unmoved, one, 1, 2);
  float pixels[3 * PIXELS];
  assert_int_equal(raster_render(made, &shading, pixels, NULL, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(raster_render(made, NULL, NULL, NULL, NULL), ASC_INVALID_ARGUMENT);
  raster_destroy(made);
  raster_destroy(NULL);
}

static void test_a_colour_beyond_float_is_reported(void **state) {
  (void)state;
  stage *s = fine_stage();
  s->materials[0].emission[0] = 1e30;
  const asc_pattern plate = {ASC_PATTERN_ZONE_PLATE, 0.0, {0.0}, {1e30, 1.0, 1.0}, {1e30, 1.0, 1.0}};
  s->materials[0].pattern = plate;
  raster *made = made_of(s);
  free(s);
  assert_int_equal(try_render(made, 1, unmoved, one, 1), ASC_NUMERIC);
  raster_destroy(made);
}

static void test_it_says_what_it_is(void **state) {
  (void)state;
  char text[256];
  assert_int_equal(raster_describe(text, sizeof text), ASC_OK);
  assert_non_null(strstr(text, "; "));
  assert_int_equal(raster_describe(text, 4), ASC_OK);
  assert_int_equal(strlen(text), 3);
  assert_int_equal(raster_describe(NULL, 4), ASC_INVALID_ARGUMENT);
  assert_int_equal(raster_sample_positions(NULL, NULL), ASC_INVALID_ARGUMENT);
  raster_limits limits = {0, 0, 0};
  assert_int_equal(raster_ask_limits(&limits, NULL), ASC_OK);
  assert_true(limits.max_samples >= limits.samples);
  assert_int_equal(limits.samples, 4);
  assert_true(limits.subpixel_bits >= 4); /* OpenGL 4.5, table 23.54: the least that there may be */
  assert_int_equal(raster_ask_limits(NULL, NULL), ASC_INVALID_ARGUMENT);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_bad_scenes_are_refused),
      cmocka_unit_test(test_more_shadows_than_can_be_tested_are_refused),
      cmocka_unit_test(test_what_only_the_tracer_draws_is_refused),
      cmocka_unit_test(test_bad_requests_are_refused),
      cmocka_unit_test(test_a_colour_beyond_float_is_reported),
      cmocka_unit_test(test_it_says_what_it_is),
  };
  return cmocka_run_group_tests_name("raster requests", tests, NULL, NULL);
}

/* What differs from pass to pass: the point of the lens and the time; and what is refused of these and of lights. */
#include "raster_scenes.h"

static const double rounding = 5e-7; /* of a few float operations on numbers below 2 */

static asc_motion *add_motion(stage *s, asc_motion_kind kind) {
  const asc_motion fresh = {.kind = kind};
  s->motions[s->scene.motion_count] = fresh;
  return &s->motions[s->scene.motion_count++];
}

static stage *lens_stage(double focus) {
  stage *s = new_stage(ASC_PERSPECTIVE);
  s->scene.view.lens_radius = 2.5;
  s->scene.view.focus_distance = focus;
  return s;
}

/* The middle of what is seen, in pixels. */
static void middle_of(const float *pixels, double middle[2]) {
  double sum = 0.0;
  middle[0] = middle[1] = 0.0;
  for (int i = 0; i < PIXELS; ++i) {
    const double share = (double)pixels[3 * i];
    sum += share;
    middle[0] += share * (i % WIDTH + 0.5);
    middle[1] += share * (i / WIDTH + 0.5);
  }
  assert_true(sum > 5.0);
  middle[0] /= sum;
  middle[1] /= sum;
}

/* A disc, a sphere or a quadrilateral at a depth, seen through a point of the lens: by so much lies it off the place
 * that a pinhole shows, lens (1 / depth - 1 / focus), to the left and down. The outline of a sphere is an ellipse whose
 * middle lies depth^2 / (depth^2 - radius^2) times as steep. */
static void test_a_pass_looks_through_its_point_of_the_lens(void **state) {
  (void)state;
  enum { COUNT = 64 };
  const double lens[2] = {1.5, -2.0}; /* on the rim */
  double offsets[COUNT][2];
  double weights[COUNT];
  double lenses[COUNT][2];
  fill_lattice(COUNT, 19, &offsets[0][0], weights);
  for (int i = 0; i < COUNT; ++i) {
    memcpy(lenses[i], lens, sizeof lens);
  }
  for (int shape = 0; shape < 3; ++shape) {
    for (int far = 0; far < 3; ++far) {
      const double depth = far == 0 ? 2.5 : far == 1 ? 4.0 : 8.0;
      const double radius = 0.12 * depth;
      stage *s = lens_stage(4.0);
      const uint32_t white = add_material(s, 1.0, 1.0, 1.0);
      if (shape == 0) {
        const asc_disc disc = {{0.0, 0.0, 10.0 - depth}, {0.0, 0.0, 1.0}, radius, white};
        s->discs[s->scene.disc_count++] = disc;
      } else if (shape == 1) {
        add_sphere(s, 0.0, 0.0, 10.0 - depth, radius, white);
      } else {
        const double low = -radius;
        const double half[2][3][3] = {
            {{low, low, 10.0 - depth}, {radius, low, 10.0 - depth}, {radius, radius, 10.0 - depth}},
            {{low, low, 10.0 - depth}, {radius, radius, 10.0 - depth}, {low, radius, 10.0 - depth}}};
        add_triangle(s, half[0], white);
        add_triangle(s, half[1], white);
      }
      float pixels[3 * PIXELS];
      raster *made = made_of(s);
      raster_desc desc = passes_of(1, &offsets[0][0], weights, COUNT, 0);
      desc.lens = &lenses[0][0];
      render_desc(made, &desc, pixels);
      raster_destroy(made);
      double middle[2];
      middle_of(pixels, middle);
      const double steeper = shape == 1 ? 1.0 / (1.0 - 0.12 * 0.12) : 1.0;
      const double off = HEIGHT * (steeper / depth - 1.0 / 4.0); /* a pixel is 1 / HEIGHT of the tangents */
      /* Of 64 samples a pixel, some 500 see it: their mean is off by the border's, .01 pixel. */
      assert_true(fabs(middle[0] - (0.5 * WIDTH - lens[0] * off)) < 0.03);
      assert_true(fabs(middle[1] - (0.5 * HEIGHT + lens[1] * off)) < 0.03);
      free(s);
    }
  }
}

/* A plane that the middle of the lens does not see: z = -1 / (v + 0.8) there, behind the eye for every v of the
 * picture. From 2 above, slopes are lower by 2 / 4, and the plane is seen where v - 0.5 < -0.8: in the three lowest
 * rows. */
static void test_a_point_of_the_lens_sees_what_the_middle_does_not(void **state) {
  (void)state;
  const double places[2][2] = {{0.0, 0.0}, {0.0, 2.0}};
  for (int high = 0; high < 2; ++high) {
    stage *s = lens_stage(4.0);
    const double point[3] = {0.0, -1.0, 10.0};
    const double normal[3] = {0.0, 1.0, -0.8};
    add_plane(s, point, normal, add_material(s, 1.0, 1.0, 1.0));
    float pixels[3 * PIXELS];
    render_pass(s, NULL, places[high], NULL, pixels);
    free(s);
    for (int i = 0; i < PIXELS; ++i) {
      assert_true(pixels[3 * i] == (high && i / WIDTH >= HEIGHT - 3 ? 1.0F : 0.0F));
    }
  }
}

/* A plane aslant in rings, lit from near: each pixel against the ray from the point of the lens. */
static void test_shading_is_where_the_ray_from_the_lens_meets(void **state) {
  (void)state;
  stage *s = lens_stage(5.0);
  const asc_pattern rings = {ASC_PATTERN_ZONE_PLATE, 0.7, {0.3, -0.2, 4.0}, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
  const uint32_t plate = add_material(s, 0.25, 0.25, 0.25);
  s->materials[plate].pattern = rings;
  s->materials[plate].albedo[0] = 0.5;
  const double point[3] = {0.0, 0.0, 4.0};
  const double normal[3] = {0.3, 0.2, 1.0};
  add_plane(s, point, normal, plate);
  const asc_light *lamp = add_light(s, ASC_LIGHT_POINT, 1.3, 2.1, 7.7);
  const double lens[2] = {-0.23, 0.31};
  float pixels[3 * PIXELS];
  render_pass(s, NULL, lens, NULL, pixels);
  const double length = sqrt(0.3 * 0.3 + 0.2 * 0.2 + 1.0);
  for (int i = 0; i < PIXELS; ++i) {
    double way[3];
    ray_through(i % WIDTH + 0.5, i / WIDTH + 0.5, way);
    way[0] -= lens[0] / 5.0;
    way[1] -= lens[1] / 5.0;
    const double start = 0.3 * lens[0] + 0.2 * lens[1] + 10.0 - 4.0;
    const double t = -start / (0.3 * way[0] + 0.2 * way[1] + way[2]);
    const double p[3] = {lens[0] + t * way[0], lens[1] + t * way[1], 10.0 + t * way[2]};
    double square = 0.0;
    double far = 0.0;
    double cosine = 0.0;
    for (int k = 0; k < 3; ++k) {
      square += (p[k] - rings.origin[k]) * (p[k] - rings.origin[k]);
      far += (lamp->place[k] - p[k]) * (lamp->place[k] - p[k]);
      cosine += (lamp->place[k] - p[k]) * normal[k] / length;
    }
    const double expected = (0.25 + 0.5 * cosine / sqrt(far)) * 0.5 * (1.0 + cos(0.7 * square));
    assert_true(fabs((double)pixels[3 * i] - expected) < 2.0 * rounding);
  }
  free(s);
}

/* One of each kind before a plane, in rings and checks, lit. */
static stage *crowd(void) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const asc_pattern rings = {ASC_PATTERN_ZONE_PLATE, 0.1, {0.3, 0.2, 0.1}, {0.2, 0.2, 0.2}, {1.0, 1.0, 1.0}};
  const asc_pattern checks = {ASC_PATTERN_CHECKER, 0.37, {0.3, 0.2, 0.1}, {0.2, 0.2, 0.2}, {1.0, 1.0, 1.0}};
  const uint32_t plate = add_material(s, 0.25, 0.25, 0.25);
  const uint32_t board = add_material(s, 0.25, 0.25, 0.25);
  s->materials[plate].pattern = rings;
  s->materials[board].pattern = checks;
  s->materials[plate].albedo[0] = s->materials[board].albedo[0] = 0.5;
  const double quad[4][2] = {{2.3, 1.2}, {9.2, 1.7}, {8.7, 6.3}, {3.3, 6.1}};
  add_quad(s, quad, 0.5, plate);
  add_disc(s, 13.1, 4.2, 2.7, board);
  add_sphere(s, 0.3, -3.1, 1.2, 2.1, plate);
  const double point[3] = {0.0, 0.0, -3.0};
  const double normal[3] = {0.2, 0.1, 1.0};
  add_plane(s, point, normal, board);
  add_light(s, ASC_LIGHT_DIRECTIONAL, -0.3, 0.2, -1.0);
  return s;
}

static void shift(double point[3], const double by[3], double time) {
  for (int k = 0; k < 3; ++k) {
    point[k] += time * by[k];
  }
}

/* Everything moves by one translation, as sums of powers of two, so that the picture is to the bit that of surfaces
 * that were put there. The material is shared with a surface that stands still. */
static void test_a_pass_sees_surfaces_where_they_are_at_its_time(void **state) {
  (void)state;
  const double time = 0.75;
  stage *moving = crowd();
  asc_motion *motion = add_motion(moving, ASC_MOTION_TRANSLATE);
  const double by[3] = {2.0, -1.0, 0.5};
  memcpy(motion->by, by, sizeof by);
  for (int kind = 0; kind < 4; ++kind) {
    moving->motion_of[kind][0] = 1;
  }
  moving->motion_of[0][1] = 1;
  stage *still = crowd();
  stage *untouched = crowd();
  stage *const stages[3] = {moving, still, untouched};
  for (int i = 0; i < 3; ++i) {
    add_sphere(stages[i], -7.1, -4.2, 0.3, 1.7, 0);
  }
  for (size_t i = 0; i < 2; ++i) {
    for (int k = 0; k < 3; ++k) {
      shift(still->vertices[i][k], by, time);
    }
    shift(still->materials[i].pattern.origin, by, time);
  }
  shift(still->discs[0].centre, by, time);
  shift(still->spheres[0].centre, by, time);
  shift(still->planes[0].point, by, time);
  still->materials[2] = untouched->materials[0];
  still->spheres[1].material = (uint32_t)still->scene.material_count++;
  float seen[3 * PIXELS];
  float expected[3 * PIXELS];
  float before[3 * PIXELS];
  render_pass(moving, &time, NULL, NULL, seen);
  free(moving);
  render_once(still, 1, unmoved, expected);
  render_once(untouched, 1, unmoved, before);
  assert_memory_equal(seen, expected, sizeof seen);
  assert_memory_not_equal(seen, before, sizeof seen);
}

/* Two passes at two times are the mean of the two, whatever the last pass or picture was. */
static void test_passes_leave_nothing_behind(void **state) {
  (void)state;
  stage *s = crowd();
  asc_motion *motion = add_motion(s, ASC_MOTION_ROTATE);
  motion->axis[0] = 0.3;
  motion->axis[2] = -0.4;
  motion->centre[1] = 1.0;
  motion->angle = 1.3;
  for (int kind = 0; kind < 4; ++kind) {
    s->motion_of[kind][0] = 1;
  }
  const double times[2] = {0.25, 0.875};
  float each[2][3 * PIXELS];
  float both[3 * PIXELS];
  const double halves[2] = {0.5, 0.5};
  const double offsets[4] = {0.5, 0.5, 0.5, 0.5};
  raster *made = made_of(s);
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 2; ++i) {
      raster_desc one_pass = passes_of(1, unmoved, one, 1, 0);
      one_pass.times = times + i;
      render_desc(made, &one_pass, each[i]);
    }
    raster_desc two = passes_of(1, offsets, halves, 2, 0);
    two.times = times;
    render_desc(made, &two, both);
    for (int i = 0; i < 3 * PIXELS; ++i) {
      assert_true(fabs((double)both[i] - 0.5 * ((double)each[0][i] + (double)each[1][i])) < rounding);
    }
  }
  assert_memory_not_equal(each[0], each[1], sizeof each[0]);
  raster_destroy(made);
  free(s);
}

/* A board that turns about the axis of sight: each pixel against the check that it was at time 0. */
static void test_a_checker_turns_with_its_surface(void **state) {
  (void)state;
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t board = add_material(s, 1.0, 1.0, 1.0);
  const asc_pattern checks = {ASC_PATTERN_CHECKER, 0.313, {0.3, 0.2, 0.1}, {0.25, 0.25, 0.25}, {1.0, 1.0, 1.0}};
  s->materials[board].pattern = checks;
  const double point[3] = {0.0, 0.0, 0.5};
  const double normal[3] = {0.0, 0.0, 1.0};
  add_plane(s, point, normal, board);
  const asc_disc still = {{-6.0, 3.0, 2.0}, {0.0, 0.0, 1.0}, 2.5, board};
  s->discs[s->scene.disc_count++] = still;
  asc_motion *motion = add_motion(s, ASC_MOTION_ROTATE);
  const asc_motion turns = {
      .kind = ASC_MOTION_ROTATE, .axis = {0.0, 0.0, 2.0}, .centre = {1.7, -0.9, 0.0}, .angle = 1.1};
  *motion = turns;
  s->motion_of[3][0] = 1;
  const double time = 0.7;
  float pixels[3 * PIXELS];
  render_pass(s, &time, NULL, NULL, pixels);
  int close = 0;
  for (int i = 0; i < PIXELS; ++i) {
    const double x = i % WIDTH + 0.5 - 0.5 * WIDTH;
    const double y = 0.5 * HEIGHT - i / WIDTH - 0.5;
    const bool on_disc = hypot(x + 6.0, y - 3.0) < 2.5;
    const double c = cos(-1.1 * time);
    const double d = sin(-1.1 * time);
    const double rest[3] = {on_disc ? x : 1.7 + c * (x - 1.7) - d * (y + 0.9),
                            on_disc ? y : -0.9 + d * (x - 1.7) + c * (y + 0.9), on_disc ? 2.0 : 0.5};
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
      sum += floor(0.313 * (rest[k] - checks.origin[k]));
    }
    const double expected = fabs(fmod(sum, 2.0)) > 0.5 ? 1.0 : 0.25;
    close += fabs((double)pixels[3 * i] - expected) < rounding;
  }
  assert_int_equal(close, PIXELS); /* no pixel's centre lies on a border between checks */
  free(s);
}

/* What is refused */

static void refused_as(stage *s, asc_status status, const char *word) {
  raster *made = NULL;
  asc_error error = {""};
  assert_int_equal(raster_create(&s->scene, &made, &error), status);
  assert_null(made);
  if (!strstr(error.text, word)) {
    fail_msg("\"%s\" does not speak of \"%s\"", error.text, word);
  }
  free(s);
}

#define REFUSED(projection, change, word)                                                                              \
  do {                                                                                                                 \
    stage *s = new_stage(projection);                                                                                  \
    add_sphere(s, 0.0, 0.0, 0.0, 1.0, add_material(s, 1.0, 1.0, 1.0));                                                 \
    change;                                                                                                            \
    refused_as(s, ASC_INVALID_ARGUMENT, word);                                                                         \
  } while (0)

static void test_bad_lenses_motions_and_lights_are_refused(void **state) {
  (void)state;
  REFUSED(ASC_PERSPECTIVE, s->scene.view.lens_radius = -0.1, "lens");
  REFUSED(ASC_PERSPECTIVE, s->scene.view.lens_radius = (double)NAN, "lens");
  REFUSED(ASC_PERSPECTIVE, s->scene.view.lens_radius = 0.1, "positive distance");
  REFUSED(ASC_ORTHOGRAPHIC, s->scene.view.lens_radius = s->scene.view.focus_distance = 0.1, "perspective");
  REFUSED(ASC_PERSPECTIVE, add_motion(s, ASC_MOTION_ROTATE), "motion 0 needs an axis");
  REFUSED(ASC_PERSPECTIVE, add_motion(s, ASC_MOTION_TRANSLATE)->by[1] = (double)NAN, "motion 0");
  REFUSED(ASC_PERSPECTIVE, (add_motion(s, ASC_MOTION_ROTATE)->angle = (double)INFINITY, s->motions[0].axis[0] = 1.0),
          "motion 0");
  REFUSED(ASC_PERSPECTIVE, (add_motion(s, ASC_MOTION_TRANSLATE), s->motion_of[2][0] = 2), "motion 2 of 1");
  REFUSED(ASC_PERSPECTIVE, (s->scene.motion_count = 1, s->scene.motions = NULL), "NULL");
  REFUSED(ASC_PERSPECTIVE, add_light(s, ASC_LIGHT_PARALLELOGRAM, 0.0, 0.0, 5.0), "light 0 has no area");
  REFUSED(ASC_PERSPECTIVE, add_light(s, ASC_LIGHT_DISC, 0.0, 0.0, 5.0)->edges[0][0] = 1.0, "light 0 has no area");
  REFUSED(ASC_PERSPECTIVE, add_light(s, ASC_LIGHT_SPHERE, 0.0, 0.0, 5.0), "light 0 has no area");
  REFUSED(ASC_PERSPECTIVE, add_light(s, ASC_LIGHT_SPHERE, 0.0, 0.0, 5.0)->radius = (double)NAN, "light 0");
  static const double frames[9];
  REFUSED(ASC_PERSPECTIVE, (add_motion(s, ASC_MOTION_FRAMES)->frames = frames, s->motions[0].frame_triangles = 1),
          "0 name it");
  REFUSED(ASC_PERSPECTIVE, add_motion(s, ASC_MOTION_FRAMES)->frame_count = 1, "0 frames");
  REFUSED(ASC_PERSPECTIVE,
          (add_motion(s, ASC_MOTION_FRAMES)->frames = frames, s->motions[0].frame_count = 1, s->motion_of[2][0] = 1),
          "no other surface");
  stage *s = new_stage(ASC_PERSPECTIVE);
  add_motion(s, (asc_motion_kind)7);
  refused_as(s, ASC_UNSUPPORTED, "motion 0 is of a kind");
}

static asc_status try_pass(raster *made, const double *time, const double *lens, const double *light) {
  raster_desc desc = passes_of(1, unmoved, one, 1, 0);
  desc.times = time;
  desc.lens = lens;
  desc.lights = light;
  return try_desc(made, &desc);
}

static void test_passes_that_are_not_those_of_the_scene_are_refused(void **state) {
  (void)state;
  stage *s = lens_stage(4.0);
  add_sphere(s, 0.0, 0.0, 0.0, 1.0, add_material(s, 1.0, 1.0, 1.0));
  add_motion(s, ASC_MOTION_TRANSLATE);
  add_light(s, ASC_LIGHT_SPHERE, 0.0, 0.0, 5.0)->radius = 1.0;
  add_light(s, ASC_LIGHT_POINT, 0.0, 0.0, 5.0);
  raster *made = made_of(s);
  free(s);
  const double time[1] = {0.5};
  const double lens[2] = {1.5, 2.0}; /* on the rim */
  const double light[2] = {0.0, 0.875};
  assert_int_equal(try_pass(made, time, lens, light), ASC_OK);
  assert_int_equal(try_pass(made, NULL, lens, light), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, time, NULL, light), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, time, lens, NULL), ASC_INVALID_ARGUMENT);
  const double never[1] = {(double)NAN};
  const double beyond[2] = {1.5, 2.01};
  const double outside[2] = {0.5, 1.0};
  const double nowhere[2] = {(double)NAN, 0.5};
  assert_int_equal(try_pass(made, never, lens, light), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, time, beyond, light), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, time, nowhere, light), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, time, lens, outside), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, time, lens, nowhere), ASC_INVALID_ARGUMENT);
  raster_destroy(made);
  s = new_stage(ASC_PERSPECTIVE);
  made = made_of(s);
  free(s);
  assert_int_equal(try_pass(made, NULL, NULL, NULL), ASC_OK);
  assert_int_equal(try_pass(made, time, NULL, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, NULL, lens, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_pass(made, NULL, NULL, light), ASC_INVALID_ARGUMENT);
  raster_destroy(made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_pass_looks_through_its_point_of_the_lens),
      cmocka_unit_test(test_a_point_of_the_lens_sees_what_the_middle_does_not),
      cmocka_unit_test(test_shading_is_where_the_ray_from_the_lens_meets),
      cmocka_unit_test(test_a_pass_sees_surfaces_where_they_are_at_its_time),
      cmocka_unit_test(test_passes_leave_nothing_behind),
      cmocka_unit_test(test_a_checker_turns_with_its_surface),
      cmocka_unit_test(test_bad_lenses_motions_and_lights_are_refused),
      cmocka_unit_test(test_passes_that_are_not_those_of_the_scene_are_refused),
  };
  return cmocka_run_group_tests_name("raster passes", tests, NULL, NULL);
}

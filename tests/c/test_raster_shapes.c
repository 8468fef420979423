/* Discs, spheres and endless planes: outlines, and what lies before what. */
#include "raster_scenes.h"

static void test_areas_of_discs(void **state) {
  (void)state;
  static const double radii[3] = {0.25, 0.8, 4.7};
  for (int i = 0; i < 3; ++i) {
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
      stage *s = new_stage(ASC_ORTHOGRAPHIC);
      add_disc(s, 7.317, 5.831, radii[i], add_material(s, 1.0, 1.0, 1.0));
      const double area = 3.14159265358979 * radii[i] * radii[i];
      /* R2 of 4,096 points misses a convex area by about N^-3/4 of its perimeter's length, .002 of it; 2.5 times that.
       */
      assert_true(fabs(mean_area(s, samples, MOST_PASSES, 0) - area) <= 0.005 * 6.2831853 * radii[i]);
    }
  }
}

enum { DIRECTIONS = 41 };

/* On both sides of the outline, a hundred-thousandth of the radius apart from it. */
static void test_the_outline_of_a_disc_is_exact(void **state) {
  (void)state;
  static const double radii[2] = {0.25, 4.7};
  for (int i = 0; i < 2; ++i) {
    stage *s = new_stage(ASC_ORTHOGRAPHIC);
    add_disc(s, 7.317, 5.831, radii[i], add_material(s, 1.0, 1.0, 1.0));
    raster *made = made_of(s);
    free(s);
    for (int k = 0; k < DIRECTIONS; ++k) {
      const double x = radii[i] * cos(6.2831853 * k / DIRECTIONS);
      const double y = radii[i] * sin(6.2831853 * k / DIRECTIONS);
      assert_true(is_seen(made, 7.317 + 0.99999 * x, 5.831 + 0.99999 * y));
      assert_false(is_seen(made, 7.317 + 1.00001 * x, 5.831 + 1.00001 * y));
    }
    raster_destroy(made);
  }
}

/* The picture position of a point of the circle in which the cone from the eye touches a sphere around `c`. */
static void touching(const double c[3], double radius, double angle, double position[2]) {
  const double square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2];
  const double across[3] = {c[2] / hypot(c[0], c[2]), 0.0, -c[0] / hypot(c[0], c[2])};
  const double upward[3] = {c[1] * across[2], c[2] * across[0] - c[0] * across[2], -c[1] * across[0]};
  const double ring = radius * sqrt(1.0 - radius * radius / square);
  double p[3];
  for (int i = 0; i < 3; ++i) {
    p[i] = c[i] * (1.0 - radius * radius / square) +
           ring * (cos(angle) * across[i] + sin(angle) * upward[i] / sqrt(square));
  }
  position[0] = 0.5 * WIDTH * (1.0 + p[0] / -p[2] / (0.5 * WIDTH / HEIGHT));
  position[1] = 0.5 * HEIGHT * (1.0 - p[1] / -p[2] / 0.5);
}

/* Of a sphere away from the axis, whose outline is an ellipse that none of its great circles draws. */
static void test_the_outline_of_a_sphere_in_perspective_is_exact(void **state) {
  (void)state;
  stage *s = new_stage(ASC_PERSPECTIVE);
  const double centre[3] = {0.63, -0.21, -3.0}; /* from the eye */
  add_sphere(s, centre[0], centre[1], 10.0 + centre[2], 0.83, add_material(s, 1.0, 1.0, 1.0));
  raster *made = made_of(s);
  free(s);
  for (int k = 0; k < DIRECTIONS; ++k) {
    double inner[2];
    double outer[2];
    touching(centre, 0.83 * 0.99999, 6.2831853 * k / DIRECTIONS, inner);
    touching(centre, 0.83 * 1.00001, 6.2831853 * k / DIRECTIONS, outer);
    assert_true(is_seen(made, inner[0], inner[1]));
    assert_false(is_seen(made, outer[0], outer[1]));
  }
  raster_destroy(made);
}

static void test_a_sphere_is_seen_from_inside_and_not_from_behind(void **state) {
  (void)state;
  float pixels[3 * PIXELS];
  for (int projection = 0; projection < 2; ++projection) {
    stage *s = new_stage((asc_projection)projection);
    add_sphere(s, 0.3, 0.2, 10.1, 30.0, add_material(s, 1.0, 1.0, 1.0));
    render_once(s, 1, unmoved, pixels);
    assert_true(red_sum(pixels) == PIXELS);

    s = new_stage((asc_projection)projection);
    const uint32_t white = add_material(s, 1.0, 1.0, 1.0);
    add_sphere(s, 0.0, 0.0, 14.0, 3.9, white);
    const double behind[4][2] = {{-5.0, -5.0}, {40.0, -5.0}, {40.0, 30.0}, {-5.0, 30.0}};
    add_quad(s, behind, 10.1, white);
    s->scene.disc_count = 1;
    const asc_disc disc = {{0.0, 0.0, 11.0}, {0.1, 0.2, 1.0}, 3.0, white};
    s->discs[0] = disc;
    render_once(s, 1, unmoved, pixels);
    assert_true(red_sum(pixels) == 0.0);
  }
}

/* Surfaces that the plane of the eye cuts are seen from there on. */
static void test_what_reaches_behind_the_eye_is_cut(void **state) {
  (void)state;
  float pixels[3 * PIXELS];
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const asc_disc slope = {{0.0, 0.0, 10.0}, {1.0, 0.0, 1.0}, 50.0, add_material(s, 1.0, 1.0, 1.0)};
  s->discs[s->scene.disc_count++] = slope; /* before the eye to the right of the middle */
  render_once(s, 1, unmoved, pixels);
  assert_true(red_sum(pixels) == 0.5 * PIXELS && red(pixels, 10, 0) == 1.0 && red(pixels, 9, 0) == 0.0);

  s = new_stage(ASC_ORTHOGRAPHIC);
  add_sphere(s, 0.1, 0.2, 12.0, 3.0, add_material(s, 1.0, 1.0, 1.0));
  render_once(s, 1, unmoved, pixels);
  for (int i = 0; i < PIXELS; ++i) {
    const double distance = hypot(i % WIDTH + 0.5 - 10.1, i / WIDTH + 0.5 - 6.8);
    assert_true((pixels[3 * i] == 1.0F) == (distance < sqrt(5.0))); /* 3^2 - 2^2 */
  }

  s = new_stage(ASC_PERSPECTIVE);
  /* 2 x - z' = 1, z' the depth: rays that go by more than 1/2 to the right meet it, those beyond pixel 17 */
  const asc_disc wall = {{0.5, 0.0, 10.0}, {2.0, 0.0, 1.0}, 1000.0, add_material(s, 1.0, 1.0, 1.0)};
  s->discs[s->scene.disc_count++] = wall;
  render_once(s, 1, unmoved, pixels);
  assert_true(red_sum(pixels) == 3.0 * HEIGHT && red(pixels, 17, 0) == 1.0);
}

/* --- endless planes */

/* A floor below the perspective eye, a little askew. */
static const double floor_point[3] = {0.3, -1.0, 2.0};
static const double floor_normal[3] = {0.2, 2.0, 0.4};

/* How far down the floor's horizon is at px from the left: where the ray has a right angle with the normal. */
static double horizon(double px) {
  double d[3];
  ray_through(px, 0.0, d);
  const double up = -(floor_normal[0] * d[0] + floor_normal[2] * d[2]) / floor_normal[1];
  return 0.5 * HEIGHT * (1.0 - up / 0.5);
}

static void test_the_horizon_of_a_plane_is_exact(void **state) {
  (void)state;
  stage *s = new_stage(ASC_PERSPECTIVE);
  add_plane(s, floor_point, floor_normal, add_material(s, 1.0, 1.0, 1.0));
  raster *made = made_of(s);
  for (int k = 0; k < DIRECTIONS; ++k) {
    const double px = (k + 0.3) * WIDTH / DIRECTIONS;
    /* A picture position in float, as gl_FragCoord is, has a rounding of 2^-20 at these coordinates. */
    assert_true(is_seen(made, px, horizon(px) + 1e-5));
    assert_false(is_seen(made, px, horizon(px) - 1e-5));
  }
  raster_destroy(made);
  free(s);
}

/* Each of the four samples sees the plane or does not: the horizon is as smooth as any edge, shaded once or for each.
 */
static void test_the_horizon_of_a_plane_is_multisampled(void **state) {
  (void)state;
  double positions[POSITIONS][2];
  assert_int_equal(raster_sample_positions(&positions[0][0], NULL), ASC_OK);
  stage *s = new_stage(ASC_PERSPECTIVE);
  add_plane(s, floor_point, floor_normal, add_material(s, 1.0, 1.0, 1.0));
  raster *made = made_of(s);
  free(s);
  int partial = 0;
  for (uint32_t shading = 0; shading < 2; ++shading) {
    float pixels[3 * PIXELS];
    const raster_desc desc = passes_of(POSITIONS, unmoved, one, 1, shading);
    render_desc(made, &desc, pixels);
    for (int i = 0; i < PIXELS; ++i) {
      int seen = 0;
      for (int k = 0; k < POSITIONS; ++k) {
        seen += i / WIDTH + positions[k][1] > horizon(i % WIDTH + positions[k][0]);
      }
      partial += seen % POSITIONS != 0;
      assert_true(pixels[3 * i] == 0.25F * (float)seen);
    }
  }
  assert_true(partial > WIDTH);
  raster_destroy(made);
}

static void test_planes_that_are_not_in_the_picture(void **state) {
  (void)state;
  static const double at_eye[3] = {0.0, 0.0, 10.0};
  static const double behind[3] = {0.0, 0.0, 11.0};
  static const double across[3] = {0.0, 1.0, 0.0};
  static const double along[3] = {0.0, 0.0, 1.0};
  static const double *const planes[4][2] = {{behind, along}, {at_eye, along}, {at_eye, across}, {behind, across}};
  for (int i = 0; i < 8; ++i) {
    stage *s = new_stage((asc_projection)(i / 4));
    add_plane(s, planes[i % 4][0], planes[i % 4][1], add_material(s, 1.0, 1.0, 1.0));
    float pixels[3 * PIXELS];
    render_once(s, 1, unmoved, pixels);
    assert_true(red_sum(pixels) == 0.0);
  }
}

/* A plane through a sphere, aslant: of each the half that lies before the other is seen. */
static void test_a_plane_cuts_a_sphere(void **state) {
  (void)state;
  static const double centre[3] = {0.317, -0.229, 1.0};
  static const double normal[3] = {-0.6, 0.3, 1.0};
  for (uint32_t samples = 1; samples <= 4; samples += 3) {
    stage *s = new_stage(ASC_ORTHOGRAPHIC);
    add_plane(s, centre, normal, add_material(s, 0.0, 1.0, 0.0));
    add_sphere(s, centre[0], centre[1], centre[2], 5.3, add_material(s, 1.0, 0.0, 0.0));
    float pixels[3 * PIXELS];
    render_once(s, samples, unmoved, pixels);
    double positions[POSITIONS][2] = {{0.5, 0.5}};
    if (samples > 1) {
      assert_int_equal(raster_sample_positions(&positions[0][0], NULL), ASC_OK);
    }
    for (int i = 0; i < PIXELS; ++i) {
      int balls = 0;
      for (uint32_t k = 0; k < samples; ++k) {
        const double x = i % WIDTH + positions[k][0] - 0.5 * WIDTH - centre[0];
        const double y = 0.5 * HEIGHT - i / WIDTH - positions[k][1] - centre[1];
        const double inside = 5.3 * 5.3 - x * x - y * y;
        balls += inside >= 0.0 && sqrt(inside) > 0.6 * x - 0.3 * y;
      }
      assert_true(pixels[3 * i] == (float)balls / (float)samples && pixels[3 * i + 1] == 1.0F - pixels[3 * i]);
    }
  }
}

/* Two planes that cross in the picture, both seen in front of and behind the other, and a third behind the eye, whose
 * depths must not count. */
static void test_two_planes_cross(void **state) {
  (void)state;
  static const double points[3][3] = {{0.3, 0.2, 4.0}, {0.3, 0.2, 4.0}, {0.0, 0.0, 1000.0}};
  static const double normals[3][3] = {{0.7, 0.1, 1.0}, {-0.5, 0.2, 1.5}, {0.0, 0.0, 1.0}};
  for (int round = 0; round < 4; ++round) {
    const asc_projection projection = (asc_projection)(round / 2);
    stage *s = new_stage(projection);
    add_material(s, 1.0, 0.0, 0.0);
    add_material(s, 0.0, 1.0, 0.0);
    for (int k = 0; k < 3; ++k) {
      const int i = k == 2 ? 2 : (k + round) % 2; /* in either order: the depths decide */
      add_plane(s, points[i], normals[i], i == 1);
    }
    float pixels[3 * PIXELS];
    render_once(s, 1, unmoved, pixels);
    int first = 0;
    for (int y = 0; y < HEIGHT; ++y) {
      for (int x = 0; x < WIDTH; ++x) {
        double eye[3] = {0.0, 0.0, 10.0};
        double d[3] = {0.0, 0.0, -1.0};
        double t[2];
        if (projection == ASC_PERSPECTIVE) {
          ray_through(x + 0.5, y + 0.5, d);
        } else {
          eye[0] = x + 0.5 - 0.5 * WIDTH;
          eye[1] = 0.5 * HEIGHT - y - 0.5;
        }
        for (int i = 0; i < 2; ++i) {
          double above = 0.0;
          double slope = 0.0;
          for (int k = 0; k < 3; ++k) {
            above += normals[i][k] * (points[i][k] - eye[k]);
            slope += normals[i][k] * d[k];
          }
          t[i] = above / slope > 0.0 ? above / slope : (double)INFINITY;
        }
        first += t[0] < t[1];
        const float *p = pixels + 3 * (y * WIDTH + x);
        assert_true(p[0] == (t[0] < t[1] ? 1.0F : 0.0F) && p[1] == (t[1] < t[0] ? 1.0F : 0.0F));
      }
    }
    assert_true(first > PIXELS / 4 && first < 3 * PIXELS / 4);
  }
}

/* --- depth */

/* Four surfaces that fill the middle of the picture, one of them nearer to the eye by a five-thousandth. */
static void check_nearest(asc_projection projection, int nearest, uint32_t samples) {
  stage *s = new_stage(projection);
  double z[4] = {5.0, 5.0, 5.0, 5.0};
  z[nearest] += 1e-3;
  for (int i = 0; i < 4; ++i) {
    add_material(s, i == nearest ? 1.0 : 0.0, 0.0, 0.0);
  }
  const double quad[4][2] = {{-15.0, -15.0}, {40.0, -15.0}, {40.0, 30.0}, {-15.0, 30.0}};
  add_quad(s, quad, z[0], 0);
  add_quad(s, quad, z[1], 1);
  add_disc(s, 10.0, 7.0, 30.0, 2);
  s->discs[0].centre[2] = z[2];
  /* Its pole is where the ray through the centre of pixel (10, 7) passes. */
  const double off = projection == ASC_PERSPECTIVE ? (10.0 - z[3]) / 28.0 : 0.5;
  add_sphere(s, off, -off, z[3] - 300.0, 300.0, 3);
  float pixels[3 * PIXELS];
  render_once(s, samples, unmoved, pixels);
  assert_true(red(pixels, 10, 7) == 1.0);
}

static void test_the_nearest_is_seen(void **state) {
  (void)state;
  for (int nearest = 0; nearest < 4; ++nearest) {
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
      check_nearest(ASC_ORTHOGRAPHIC, nearest, samples);
      check_nearest(ASC_PERSPECTIVE, nearest, samples);
    }
  }
}

/* A floor from behind the eye to far away, and a wall that stands in it: where they meet is seen where it is, although
 * the far end is ten thousand times as far as the near one, or the floor has no end. */
static void test_a_wall_stands_in_a_floor(void **state) {
  (void)state;
  for (int round = 0; round < 4; ++round) {
    const uint32_t samples = round % 2 ? 4 : 1;
    stage *s = new_stage(ASC_PERSPECTIVE);
    const uint32_t floor_material = add_material(s, 0.0, 1.0, 0.0);
    const uint32_t wall_material = add_material(s, 1.0, 0.0, 0.0);
    const double f = 1e4;
    const double floor_corners[2][3][3] = {{{-f, -1.0, -f}, {f, -1.0, -f}, {f, -1.0, f}},
                                           {{-f, -1.0, -f}, {f, -1.0, f}, {-f, -1.0, f}}};
    static const double below[3] = {0.0, -1.0, 0.0};
    if (round < 2) {
      add_triangle(s, floor_corners[0], floor_material);
      add_triangle(s, floor_corners[1], floor_material);
    } else {
      add_plane(s, below, below, floor_material);
    }
    /* 8 before the eye, from far below the floor to far above: it is seen above y = -1, at 7 (1 + 1/4) = 8.75 down. */
    const double wall_corners[3][3] = {{-50.0, -50.0, 2.0}, {50.0, -50.0, 2.0}, {0.0, 90.0, 2.0}};
    add_triangle(s, wall_corners, wall_material);
    float pixels[3 * PIXELS];
    render_once(s, samples, unmoved, pixels);
    for (int y = 0; y < HEIGHT; ++y) {
      for (int x = 0; x < WIDTH; ++x) {
        const float *p = pixels + 3 * (y * WIDTH + x);
        /* Of the samples at .125, .375, .625 and .875, or the one at .5, those above .75 see the wall. */
        const float wall = y < 8 ? 1.0F : y > 8 ? 0.0F : samples == 1 ? 1.0F : 0.75F;
        assert_true(p[0] == wall && p[1] == 1.0F - wall);
      }
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_the_horizon_of_a_plane_is_exact),
      cmocka_unit_test(test_the_horizon_of_a_plane_is_multisampled),
      cmocka_unit_test(test_planes_that_are_not_in_the_picture),
      cmocka_unit_test(test_a_plane_cuts_a_sphere),
      cmocka_unit_test(test_two_planes_cross),
      cmocka_unit_test(test_areas_of_discs),
      cmocka_unit_test(test_the_outline_of_a_disc_is_exact),
      cmocka_unit_test(test_the_outline_of_a_sphere_in_perspective_is_exact),
      cmocka_unit_test(test_a_sphere_is_seen_from_inside_and_not_from_behind),
      cmocka_unit_test(test_what_reaches_behind_the_eye_is_cut),
      cmocka_unit_test(test_the_nearest_is_seen),
      cmocka_unit_test(test_a_wall_stands_in_a_floor),
  };
  return cmocka_run_group_tests_name("raster shapes", tests, NULL, NULL);
}

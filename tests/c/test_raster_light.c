/* Lambert's law and shadows, against the equation of scene.h. */
#include "raster_scenes.h"

/* Lit pixels differ from the equation by the rounding of a few float operations on numbers below 2. */
static const double rounding = 5e-7;

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Of a light's red on p with this unit normal, no shadow. */
static double red_light(const asc_light *light, const double p[3], const double n[3]) {
  double way[3];
  for (int i = 0; i < 3; ++i) {
    way[i] = light->kind == ASC_LIGHT_POINT ? light->place[i] - p[i] : -light->place[i];
  }
  const double square = dot(way, way);
  const double cosine = fmax(dot(n, way), 0.0) / sqrt(square);
  return light->intensity[0] * (light->kind == ASC_LIGHT_POINT && light->inverse_square ? cosine / square : cosine);
}

static uint32_t add_paper(stage *s, double albedo, double emission) {
  const uint32_t paper = add_material(s, emission, emission, emission);
  for (int i = 0; i < 3; ++i) {
    s->materials[paper].albedo[i] = albedo;
  }
  return paper;
}

/* The point at the centre of pixel i of the orthographic stage. */
static void set_point(double p[3], int i, double z) {
  p[0] = i % WIDTH + 0.5 - 0.5 * WIDTH;
  p[1] = 0.5 * HEIGHT - i / WIDTH - 0.5;
  p[2] = z;
}

/* Three lights, of each kind one that falls on what faces the eye; each nearer than any surface is large. */
static void add_three_lights(stage *s) {
  add_light(s, ASC_LIGHT_POINT, 3.1, 5.2, 9.7);
  add_light(s, ASC_LIGHT_POINT, -4.3, 1.2, 8.9)->inverse_square = 1;
  s->lights[1].intensity[0] = 40.0;
  add_light(s, ASC_LIGHT_DIRECTIONAL, -0.3, 0.2, -1.4);
}

static double three_lights(const stage *s, const double p[3], const double n[3]) {
  return red_light(&s->lights[0], p, n) + red_light(&s->lights[1], p, n) + red_light(&s->lights[2], p, n);
}

static void test_lambert_on_a_sphere(void **state) {
  (void)state;
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  add_sphere(s, 0.0, 0.0, 0.0, 5.0, add_paper(s, 0.7, 0.05));
  add_three_lights(s);
  raster *made = made_of(s);
  float pixels[3 * PIXELS];
  render(made, 1, unmoved, one, 1, pixels);
  raster_destroy(made);
  for (int i = 0; i < PIXELS; ++i) {
    double p[3];
    set_point(p, i, 0.0);
    const double inside = 25.0 - dot(p, p);
    if (inside < 0.0) {
      assert_true(pixels[3 * i] == 0.0F);
      continue;
    }
    p[2] = sqrt(inside);
    const double n[3] = {p[0] / 5.0, p[1] / 5.0, p[2] / 5.0};
    /* A light past the terminator gives 0, and not a shadow's edge. */
    assert_true(fabs((double)pixels[3 * i] - 0.05 - 0.7 * three_lights(s, p, n)) < rounding);
  }
  free(s);
}

enum { FLAT_KINDS = 3 };

/* A surface that fills the picture and rises to the left: a quadrilateral, a disc, a plane. `side` turns its normal. */
static stage *slope_stage(int kind, double side) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t paper = add_paper(s, 0.7, 0.05);
  const double normal[3] = {0.25 * side, 0.0, side};
  const double origin[3] = {0.0, 0.0, 0.0};
  if (kind == 0) {
    const double quad[4][2] = {{-30.0, -30.0}, {60.0, -30.0}, {60.0, 60.0}, {-30.0, 60.0}};
    add_quad(s, quad, 0.0, paper);
    for (size_t i = 0; i < s->scene.triangle_count; ++i) {
      for (int k = 0; k < 3; ++k) {
        s->vertices[i][k][2] = -0.25 * s->vertices[i][k][0];
      }
    }
  } else if (kind == 1) {
    const asc_disc disc = {{0.0, 0.0, 0.0}, {normal[0], normal[1], normal[2]}, 100.0, paper};
    s->discs[s->scene.disc_count++] = disc;
  } else {
    add_plane(s, origin, normal, paper);
  }
  return s;
}

static void test_lambert_on_flat_surfaces(void **state) {
  (void)state;
  const double n[3] = {0.25 / sqrt(1.0625), 0.0, 1.0 / sqrt(1.0625)};
  for (int round = 0; round < 2 * FLAT_KINDS; ++round) {
    stage *s = slope_stage(round % FLAT_KINDS, round < FLAT_KINDS ? 1.0 : -2.0);
    add_three_lights(s);
    /* So low that a step of rounding off the surface would have it in its own shadow, or its neighbour's. */
    add_light(s, ASC_LIGHT_DIRECTIONAL, -1.0, 0.5, 0.25 - 1e-6);
    raster *made = made_of(s);
    float pixels[3 * PIXELS];
    render(made, 1, unmoved, one, 1, pixels);
    raster_destroy(made);
    for (int i = 0; i < PIXELS; ++i) {
      double p[3];
      set_point(p, i, 0.0);
      p[2] = -0.25 * p[0];
      const double light = three_lights(s, p, n) + red_light(&s->lights[3], p, n);
      assert_true(fabs((double)pixels[3 * i] - 0.05 - 0.7 * light) < rounding);
    }
    free(s);
  }
}

static void test_light_from_behind_gives_nothing(void **state) {
  (void)state;
  float pixels[3 * PIXELS];
  for (int round = 0; round < 2 * FLAT_KINDS; ++round) {
    stage *s = slope_stage(round % FLAT_KINDS, round < FLAT_KINDS ? 1.0 : -1.0);
    add_light(s, ASC_LIGHT_POINT, 1.0, 2.0, -9.0);
    add_light(s, ASC_LIGHT_DIRECTIONAL, 0.3, 0.2, 1.0);
    render_once(s, 1, unmoved, pixels);
    for (int i = 0; i < PIXELS; ++i) {
      assert_true(pixels[3 * i] == 0.05F);
    }
  }
  /* From inside a sphere its normals point inward: a light inside shines on it, one outside does not. */
  for (int outside = 0; outside < 2; ++outside) {
    stage *s = new_stage(ASC_ORTHOGRAPHIC);
    add_sphere(s, 0.0, 0.0, 10.0, 30.0, add_paper(s, 0.7, 0.05));
    add_light(s, ASC_LIGHT_POINT, 0.0, 0.0, outside ? 45.0 : 10.0);
    render_once(s, 1, unmoved, pixels);
    for (int i = 0; i < PIXELS; ++i) {
      assert_true(fabs((double)pixels[3 * i] - (outside ? 0.05 : 0.75)) < rounding);
    }
  }
}

/* --- shadows ----------------------------------------------------------------------------------------------------- */

enum { BY_SPHERE = 0, BY_DISC = 1, BY_TRIANGLE = 2, BY_PLANE = 3, OCCLUDERS = 4 };

static const double lamp[3] = {1.3, -0.7, 14.0};
static const double blocker[3] = {0.9, -0.4, 12.0}; /* behind the eye at 10, out of the picture */
static const double blocking_radius = 0.83;
static const double corner_offsets[3][2] = {{-1.1, -0.6}, {0.9, -0.8}, {0.2, 0.97}};

static void add_occluder(stage *s, int kind) {
  const uint32_t paper = add_paper(s, 0.5, 0.0);
  if (kind == BY_SPHERE) {
    add_sphere(s, blocker[0], blocker[1], blocker[2], blocking_radius, paper);
  } else if (kind == BY_DISC) {
    const asc_disc disc = {{blocker[0], blocker[1], blocker[2]}, {0.0, 0.0, -3.0}, blocking_radius, paper};
    s->discs[s->scene.disc_count++] = disc;
  } else if (kind == BY_TRIANGLE) {
    double corners[3][3];
    for (int i = 0; i < 3; ++i) {
      corners[i][0] = blocker[0] + corner_offsets[i][0];
      corners[i][1] = blocker[1] + corner_offsets[i][1];
      corners[i][2] = blocker[2];
    }
    add_triangle(s, (const double(*)[3])corners, paper);
  } else {
    /* Between the eye and the lamp over the whole of the picture. */
    static const double point[3] = {0.0, 0.0, 12.1};
    static const double normal[3] = {0.1, 0.0, 1.0};
    add_plane(s, point, normal, paper);
  }
}

static bool inside_triangle(double x, double y) {
  for (int i = 0; i < 3; ++i) {
    const double *a = corner_offsets[i];
    const double *b = corner_offsets[(i + 1) % 3];
    if ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) < 0.0) {
      return false;
    }
  }
  return true;
}

/* Whether the way from p to the lamp, or from p along `toward`, is blocked. */
static bool is_blocked(int kind, const double p[3], const double way[3]) {
  const double t = (blocker[2] - p[2]) / way[2];
  const double x = p[0] + t * way[0] - blocker[0];
  const double y = p[1] + t * way[1] - blocker[1];
  switch (kind) {
  case BY_SPHERE: {
    const double to[3] = {blocker[0] - p[0], blocker[1] - p[1], blocker[2] - p[2]};
    return dot(to, to) - dot(to, way) * dot(to, way) / dot(way, way) < blocking_radius * blocking_radius;
  }
  case BY_DISC: return x * x + y * y < blocking_radius * blocking_radius;
  case BY_TRIANGLE: return inside_triangle(x, y);
  default: return true;
  }
}

/* A quadrilateral in the shadow of something that is not in the picture. */
static void check_shadow(int kind, asc_light_kind light) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const double quad[4][2] = {{-30.0, -30.0}, {60.0, -30.0}, {60.0, 60.0}, {-30.0, 60.0}};
  const double n[3] = {0.0, 0.0, 1.0};
  add_quad(s, quad, 0.0, add_paper(s, 0.7, 0.0));
  add_occluder(s, kind);
  if (light == ASC_LIGHT_POINT) {
    add_light(s, light, lamp[0], lamp[1], lamp[2]);
  } else {
    add_light(s, light, -0.03, 0.02, -1.0);
  }
  raster *made = made_of(s);
  float pixels[3 * PIXELS];
  render(made, 1, unmoved, one, 1, pixels);
  raster_destroy(made);
  int dark = 0;
  for (int i = 0; i < PIXELS; ++i) {
    double p[3];
    double way[3];
    set_point(p, i, 0.0);
    for (int k = 0; k < 3; ++k) {
      way[k] = light == ASC_LIGHT_POINT ? lamp[k] - p[k] : -s->lights[0].place[k];
    }
    const bool blocked = is_blocked(kind, p, way);
    dark += blocked;
    const double expected = blocked ? 0.0 : 0.7 * red_light(&s->lights[0], p, n);
    assert_true(fabs((double)pixels[3 * i] - expected) < rounding);
  }
  assert_true(kind == BY_PLANE ? dark == PIXELS : dark > 0 && dark < PIXELS);
  free(s);
}

static void test_everything_casts_shadows(void **state) {
  (void)state;
  for (int kind = 0; kind < OCCLUDERS; ++kind) {
    check_shadow(kind, ASC_LIGHT_POINT);
    check_shadow(kind, ASC_LIGHT_DIRECTIONAL);
  }
}

/* All of the occluders beyond the lamp, where they would be in the way of a ray that goes on. */
static void test_what_lies_beyond_a_light_casts_no_shadow(void **state) {
  (void)state;
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const double quad[4][2] = {{-30.0, -30.0}, {60.0, -30.0}, {60.0, 60.0}, {-30.0, 60.0}};
  const double n[3] = {0.0, 0.0, 1.0};
  add_quad(s, quad, 0.0, add_paper(s, 0.7, 0.0));
  for (int kind = 0; kind < OCCLUDERS; ++kind) {
    add_occluder(s, kind);
  }
  add_light(s, ASC_LIGHT_POINT, 0.9, -0.4, 9.0);
  s->spheres[0].centre[2] = 11.0;
  s->planes[0].normal[0] = 0.0;
  s->planes[0].point[2] = 11.0;
  raster *made = made_of(s);
  float pixels[3 * PIXELS];
  render(made, 1, unmoved, one, 1, pixels);
  raster_destroy(made);
  for (int i = 0; i < PIXELS; ++i) {
    double p[3];
    set_point(p, i, 0.0);
    assert_true(fabs((double)pixels[3 * i] - 0.7 * red_light(&s->lights[0], p, n)) < rounding);
  }
  free(s);
}

/* With sample shading each sample has its own shadow; without it the pixel's centre decides for all four. */
static void test_shadows_are_evaluated_where_it_is_said(void **state) {
  (void)state;
  for (uint32_t shading = 0; shading < 2; ++shading) {
    for (int kind = 0; kind < FLAT_KINDS; ++kind) {
      stage *s = slope_stage(kind, 1.0);
      s->materials[0].emission[0] = 0.0;
      add_occluder(s, BY_DISC);
      add_light(s, ASC_LIGHT_POINT, lamp[0], lamp[1], lamp[2]);
      raster *made = made_of(s);
      float pixels[3 * PIXELS];
      const raster_desc desc = passes_of(POSITIONS, unmoved, one, 1, shading);
      render_desc(made, &desc, pixels);
      double positions[POSITIONS][2];
      assert_int_equal(raster_sample_positions(&positions[0][0], NULL), ASC_OK);
      const double n[3] = {0.25 / sqrt(1.0625), 0.0, 1.0 / sqrt(1.0625)};
      for (int i = 0; i < PIXELS; ++i) {
        double expected = 0.0;
        for (int k = 0; k < POSITIONS; ++k) {
          const double px = i % WIDTH + (shading ? positions[k][0] : 0.5);
          const double py = i / WIDTH + (shading ? positions[k][1] : 0.5);
          const double p[3] = {px - 0.5 * WIDTH, 0.5 * HEIGHT - py, -0.25 * (px - 0.5 * WIDTH)};
          const double way[3] = {lamp[0] - p[0], lamp[1] - p[1], lamp[2] - p[2]};
          expected += is_blocked(BY_DISC, p, way) ? 0.0 : 0.25 * 0.7 * red_light(&s->lights[0], p, n);
        }
        assert_true(fabs((double)pixels[3 * i] - expected) < rounding);
      }
      raster_destroy(made);
      free(s);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_lambert_on_a_sphere),
      cmocka_unit_test(test_lambert_on_flat_surfaces),
      cmocka_unit_test(test_light_from_behind_gives_nothing),
      cmocka_unit_test(test_everything_casts_shadows),
      cmocka_unit_test(test_what_lies_beyond_a_light_casts_no_shadow),
      cmocka_unit_test(test_shadows_are_evaluated_where_it_is_said),
  };
  return cmocka_run_group_tests_name("raster light", tests, NULL, NULL);
}

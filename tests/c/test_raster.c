/* The rasteriser on OSMesa, on scenes made by hand. In the orthographic ones a world unit is a pixel. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

#include "raster.h"

enum { WIDTH = 20, HEIGHT = 14, PIXELS = WIDTH * HEIGHT, MOST = 8, POSITIONS = 4 };

static const double unmoved[2] = {0.5, 0.5};
static const double one[1] = {1.0};

typedef struct stage {
  asc_scene scene;
  asc_material materials[MOST];
  double vertices[MOST][3][3];
  uint32_t triangle_material[MOST];
  asc_disc discs[MOST];
  asc_sphere spheres[MOST];
} stage;

static stage *new_stage(asc_projection projection) {
  stage *s = calloc(1, sizeof *s);
  assert_non_null(s);
  const asc_view view = {.projection = projection,
                         .width = WIDTH,
                         .height = HEIGHT,
                         .eye = {0.0, 0.0, 10.0},
                         .right = {1.0, 0.0, 0.0},
                         .up = {0.0, 1.0, 0.0},
                         .forward = {0.0, 0.0, -1.0},
                         .half_width = projection == ASC_PERSPECTIVE ? 0.5 * WIDTH / HEIGHT : 0.5 * WIDTH,
                         .half_height = projection == ASC_PERSPECTIVE ? 0.5 : 0.5 * HEIGHT};
  s->scene.struct_size = sizeof s->scene;
  s->scene.view = view;
  s->scene.materials = s->materials;
  s->scene.vertices = &s->vertices[0][0][0];
  s->scene.triangle_material = s->triangle_material;
  s->scene.discs = s->discs;
  s->scene.spheres = s->spheres;
  return s;
}

static uint32_t add_material(stage *s, double red, double green, double blue) {
  const asc_material fresh = {.emission = {red, green, blue}};
  s->materials[s->scene.material_count] = fresh;
  return (uint32_t)s->scene.material_count++;
}

static void add_triangle(stage *s, const double p[3][3], uint32_t material) {
  memcpy(s->vertices[s->scene.triangle_count], p, sizeof s->vertices[0]);
  s->triangle_material[s->scene.triangle_count++] = material;
}

/* A quadrilateral, its corners in picture positions, at world depth z. */
static void add_quad(stage *s, const double p[4][2], double z, uint32_t material) {
  for (int half = 0; half < 2; ++half) {
    double corners[3][3];
    for (int i = 0; i < 3; ++i) {
      const double *from = p[i == 0 ? 0 : i + half];
      corners[i][0] = from[0] - 0.5 * WIDTH;
      corners[i][1] = 0.5 * HEIGHT - from[1];
      corners[i][2] = z;
    }
    add_triangle(s, (const double(*)[3])corners, material);
  }
}

static void add_disc(stage *s, double px, double py, double radius, uint32_t material) {
  const asc_disc fresh = {{px - 0.5 * WIDTH, 0.5 * HEIGHT - py, 0.0}, {0.0, 0.0, -2.0}, radius, material};
  s->discs[s->scene.disc_count++] = fresh;
}

static void add_sphere(stage *s, double x, double y, double z, double radius, uint32_t material) {
  const asc_sphere fresh = {{x, y, z}, radius, material};
  s->spheres[s->scene.sphere_count++] = fresh;
}

static raster *made_of(const stage *s) {
  raster *made = NULL;
  asc_error error = {""};
  if (raster_create(&s->scene, &made, &error) != ASC_OK) {
    fail_msg("%s", error.text);
  }
  return made;
}

static void render(raster *made, uint32_t samples, const double *offsets, const double *weights, size_t count,
                   float *pixels) {
  const raster_desc desc = {sizeof desc, samples, offsets, weights, count};
  asc_error error = {""};
  raster_cost cost;
  if (raster_render(made, &desc, pixels, &cost, &error) != ASC_OK) {
    fail_msg("%s", error.text);
  }
  assert_int_equal(cost.samples, count * samples * PIXELS);
  assert_true(cost.cpu_seconds > 0.0 && cost.wall_seconds > 0.0);
}

/* One picture of the scene, which is done with then. */
static void render_once(stage *s, uint32_t samples, const double offset[2], float *pixels) {
  raster *made = made_of(s);
  render(made, samples, offset, one, 1, pixels);
  raster_destroy(made);
  free(s);
}

static double red(const float *pixels, int x, int y) { return (double)pixels[3 * (y * WIDTH + x)]; }

static double red_sum(const float *pixels) {
  double sum = 0.0;
  for (int i = 0; i < PIXELS; ++i) {
    sum += (double)pixels[3 * i];
  }
  return sum;
}

/* Passes of the R2 sequence (Roberts 2018), equal weights. */
static void fill_passes(size_t count, double *offsets, double *weights) {
  for (size_t i = 0; i < count; ++i) {
    offsets[2 * i] = fmod(0.5 + 0.7548776662466927 * (double)i, 1.0);
    offsets[2 * i + 1] = fmod(0.5 + 0.5698402909980532 * (double)i, 1.0);
    weights[i] = 1.0 / (double)count;
  }
}

enum { MOST_PASSES = 4096 };

/* Passes of a rank-1 lattice, evenly spaced along both axes, equal weights. */
static void fill_lattice(size_t count, size_t generator, double *offsets, double *weights) {
  for (size_t i = 0; i < count; ++i) {
    offsets[2 * i] = ((double)i + 0.5) / (double)count;
    offsets[2 * i + 1] = ((double)(i * generator % count) + 0.5) / (double)count;
    weights[i] = 1.0 / (double)count;
  }
}

/* The sum over the red of the picture, of so many passes of R2, or of a lattice with this generator. */
static double mean_area(stage *s, uint32_t samples, size_t count, size_t generator) {
  static double offsets[MOST_PASSES][2];
  static double weights[MOST_PASSES];
  if (generator) {
    fill_lattice(count, generator, &offsets[0][0], weights);
  } else {
    fill_passes(count, &offsets[0][0], weights);
  }
  float pixels[3 * PIXELS];
  raster *made = made_of(s);
  render(made, samples, &offsets[0][0], weights, count, pixels);
  raster_destroy(made);
  free(s);
  return red_sum(pixels);
}

/* --- where things are -------------------------------------------------------------------------------------------- */

static void test_a_picture_is_not_mirrored_or_transposed(void **state) {
  (void)state;
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t white = add_material(s, 1.0, 0.25, 0.5);
  const double quad[4][2] = {{3.3, 2.2}, {8.2, 2.2}, {8.2, 4.3}, {3.3, 4.3}}; /* centres 3.5..7.5, 2.5..3.5 */
  add_quad(s, quad, 0.0, white);
  s->scene.view.background[1] = 0.75;
  float pixels[3 * PIXELS];
  render_once(s, 1, unmoved, pixels);
  for (int y = 0; y < HEIGHT; ++y) {
    for (int x = 0; x < WIDTH; ++x) {
      const bool inside = x >= 3 && x <= 7 && y >= 2 && y <= 3;
      const float *p = pixels + 3 * (y * WIDTH + x);
      assert_true(p[0] == (inside ? 1.0F : 0.0F) && p[1] == (inside ? 0.25F : 0.75F) && p[2] == (inside ? 0.5F : 0.0F));
    }
  }
}

static void test_an_offset_is_from_left_and_top(void **state) {
  (void)state;
  const double at[2] = {0.1875, 0.8125};
  for (int round = 0; round < 2; ++round) {
    stage *s = new_stage(ASC_ORTHOGRAPHIC);
    const uint32_t white = add_material(s, 1.0, 1.0, 1.0);
    const double x = 5.0 + at[0];
    const double y = 7.0 + at[1];
    const double r = 0.05;
    const double quad[4][2] = {{x - r, y - r}, {x + r, y - r}, {x + r, y + r}, {x - r, y + r}};
    if (round) {
      add_disc(s, x, y, r, white);
    } else {
      add_quad(s, quad, 0.0, white);
    }
    float pixels[3 * PIXELS];
    render_once(s, 1, at, pixels);
    assert_true(red(pixels, 5, 7) == 1.0 && red_sum(pixels) == 1.0);
  }
}

static void test_multisamples_lie_where_they_are_said_to(void **state) {
  (void)state;
  double positions[POSITIONS][2];
  assert_int_equal(raster_sample_positions(&positions[0][0], NULL), ASC_OK);
  for (int i = 0; i < 3 * POSITIONS; ++i) {
    stage *s = new_stage(ASC_ORTHOGRAPHIC);
    const uint32_t white = add_material(s, 1.0, 1.0, 1.0);
    const double x = 5.0 + positions[i % POSITIONS][0];
    const double y = 7.0 + positions[i % POSITIONS][1];
    const double r = 0.05; /* the samples are 1/4 pixel apart */
    const double quad[4][2] = {{x - r, y - r}, {x + r, y - r}, {x + r, y + r}, {x - r, y + r}};
    if (i < POSITIONS) {
      add_quad(s, quad, 0.0, white);
    } else if (i < 2 * POSITIONS) {
      add_disc(s, x, y, r, white);
    } else {
      add_sphere(s, x - 0.5 * WIDTH, 0.5 * HEIGHT - y, 0.0, r, white);
    }
    float pixels[3 * PIXELS];
    render_once(s, 4, unmoved, pixels);
    assert_true(red(pixels, 5, 7) == 0.25 && red_sum(pixels) == 0.25);
  }
}

static void test_a_resolved_pixel_is_the_mean(void **state) {
  (void)state;
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t bright = add_material(s, 1000.0, 1.0, 1.0);
  const double quad[4][2] = {{-5.0, -5.0}, {9.5, -5.0}, {9.5, 30.0}, {-5.0, 30.0}};
  add_quad(s, quad, 0.0, bright);
  s->scene.view.background[0] = 3.0;
  float pixels[3 * PIXELS];
  render_once(s, 4, unmoved, pixels);
  /* Two of the four lie left of the middle; all the numbers are exact in float, so the mean is. */
  assert_true(red(pixels, 8, 6) == 1000.0 && red(pixels, 9, 6) == 501.5 && red(pixels, 10, 6) == 3.0);
}

/* --- edges ------------------------------------------------------------------------------------------------------- */

/* A prime, so that no pass but one has its corners where another has them on the grid of 1/256 pixel. */
enum { PHASES = 8, EDGE_PASSES = 499 };

/* An edge across the whole picture: its position along `axis` is `at` in the middle of the picture, and grows by
 * `slope` a pixel. Returns how far from there it is seen, in pixels along the axis, by area. */
static double edge_error(int axis, double at, double slope, uint32_t samples) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t white = add_material(s, 1.0, 1.0, 1.0);
  const double extent[2] = {WIDTH, HEIGHT};
  const double along = extent[1 - axis];
  /* Corners at odd places, outside of the picture: a corner on the grid of snapping would be a special case. */
  const double low = -1.377;
  const double high = along + 1.713;
  double quad[4][2];
  const double edge[4] = {-3.19, -3.19, at + slope * (high - 0.5 * along), at + slope * (low - 0.5 * along)};
  const double other[4] = {low, high, high, low};
  for (int i = 0; i < 4; ++i) {
    quad[i][axis] = edge[i];
    quad[i][1 - axis] = other[i];
  }
  add_quad(s, (const double(*)[2])quad, 0.0, white);
  return mean_area(s, samples, EDGE_PASSES, 190) / along - at;
}

static void check_edges(double slope, double expected, double tolerance) {
  for (uint32_t samples = 1; samples <= 4; samples += 3) {
    for (int axis = 0; axis < 2; ++axis) {
      double sum = 0.0;
      for (int phase = 0; phase < PHASES; ++phase) {
        const double error = edge_error(axis, 6.0 + (phase + 0.3) / PHASES, slope, samples);
        /* The passes are this far apart: half of that is not resolved. */
        assert_true(fabs(error - expected) <= tolerance + 0.5 / EDGE_PASSES);
        sum += error;
      }
      /* Over the phases that cancels, but for a standard error of 1 / (499 sqrt(12 x 8)) = .0002. */
      assert_true(fabs(sum / PHASES - expected) <= 0.0004);
    }
  }
}

/* The compromise of raster.c: these are 1/512 pixel low, of which it takes 1/1024 back. */
static void test_edges_along_an_axis(void **state) {
  (void)state;
  check_edges(0.0, -1.0 / 1024.0, 0.0);
}

/* And these, right without it, it moves by (1 - slope) / 1024 along the axis. The edge's ends, snapped in each pass to
 * 1/256 pixel across it too, move it by a tenth of that. */
static void test_slanted_edges(void **state) {
  (void)state;
  check_edges(0.1231, (1.0 - 0.1231) / 1024.0, 0.1 / 256.0);
  check_edges(-0.3177, (1.0 + 0.3177) / 1024.0, 0.1 / 256.0);
}

/* --- round shapes ------------------------------------------------------------------------------------------------ */

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

/* Whether the picture position (px, py) is on the surface, by a pass that samples just there. */
static bool is_seen(raster *made, double px, double py) {
  const double offset[2] = {px - floor(px), py - floor(py)};
  float pixels[3 * PIXELS];
  render(made, 1, offset, one, 1, pixels);
  return red(pixels, (int)px, (int)py) == 1.0;
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

/* The ray through picture position (px, py) of the perspective stage. */
static void ray_through(double px, double py, double direction[3]) {
  direction[0] = (2.0 * px / WIDTH - 1.0) * 0.5 * WIDTH / HEIGHT;
  direction[1] = (1.0 - 2.0 * py / HEIGHT) * 0.5;
  direction[2] = -1.0;
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

/* --- depth ------------------------------------------------------------------------------------------------------- */

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
 * the far end is ten thousand times as far as the near one. */
static void test_a_wall_stands_in_a_floor(void **state) {
  (void)state;
  for (uint32_t samples = 1; samples <= 4; samples += 3) {
    stage *s = new_stage(ASC_PERSPECTIVE);
    const uint32_t floor_material = add_material(s, 0.0, 1.0, 0.0);
    const uint32_t wall_material = add_material(s, 1.0, 0.0, 0.0);
    const double f = 1e4;
    const double floor_corners[2][3][3] = {{{-f, -1.0, -f}, {f, -1.0, -f}, {f, -1.0, f}},
                                           {{-f, -1.0, -f}, {f, -1.0, f}, {-f, -1.0, f}}};
    add_triangle(s, floor_corners[0], floor_material);
    add_triangle(s, floor_corners[1], floor_material);
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

/* --- patterns and sums ------------------------------------------------------------------------------------------- */

static void test_a_zone_plate_follows_its_formula(void **state) {
  (void)state;
  const double at[2] = {0.3125, 0.71875};
  for (uint32_t samples = 1; samples <= 4; samples += 3) {
    stage *s = new_stage(ASC_PERSPECTIVE);
    const uint32_t rings = add_material(s, 0.9, 0.8, 0.7);
    const asc_pattern plate = {ASC_PATTERN_ZONE_PLATE, 97.0, {3.1, 4.7, 1.0}, {0.1, 0.2, 0.3}, {0.9, 1.0, 0.5}};
    s->materials[rings].pattern = plate;
    const double corners[3][3] = {{-500.0, -300.0, 2.0}, {500.0, -300.0, 2.0}, {0.0, 700.0, 2.0}};
    add_triangle(s, corners, rings);
    float pixels[3 * PIXELS];
    render_once(s, samples, at, pixels);
    for (int i = 0; i < PIXELS; ++i) {
      double d[3];
      ray_through(i % WIDTH + at[0], i / WIDTH + at[1], d);
      const double square = pow(8.0 * d[0] - 3.1, 2) + pow(8.0 * d[1] - 4.7, 2) + 1.0;
      const double wave = 0.5 + 0.5 * cos(97.0 * square); /* the phase reaches 15,000 radians */
      /* Rounding of four float operations on numbers up to 1, and of the driver's cosine. */
      assert_true(fabs((double)pixels[3 * i] - 0.9 * (0.1 + 0.8 * wave)) < 3e-7);
      assert_true(fabs((double)pixels[3 * i + 1] - 0.8 * (0.2 + 0.8 * wave)) < 3e-7);
      assert_true(fabs((double)pixels[3 * i + 2] - 0.7 * (0.3 + 0.2 * wave)) < 3e-7);
    }
  }
}

static void test_passes_are_summed_by_weight(void **state) {
  (void)state;
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const double quad[4][2] = {{-5.0, -5.0}, {9.5, -5.0}, {9.5, 30.0}, {-5.0, 30.0}};
  add_quad(s, quad, 0.0, add_material(s, 1.0, 1.0, 1.0));
  const double offsets[3][2] = {{0.1, 0.5}, {0.4, 0.2}, {0.7, 0.9}};
  const double weights[3] = {0.625, -0.25, 0.625};
  float pixels[3 * PIXELS];
  raster *made = made_of(s);
  render(made, 1, &offsets[0][0], weights, 3, pixels);
  assert_true(red(pixels, 9, 6) == 0.375 && red(pixels, 8, 6) == 1.0 && red(pixels, 10, 6) == 0.0);
  /* The same again, after another way of drawing in between. */
  float again[3 * PIXELS];
  render(made, 4, &offsets[0][0], weights, 3, again);
  assert_memory_not_equal(pixels, again, sizeof again);
  render(made, 1, &offsets[0][0], weights, 3, again);
  assert_memory_equal(pixels, again, sizeof again);
  raster_destroy(made);
  free(s);
}

static void test_an_empty_scene_is_background(void **state) {
  (void)state;
  for (int projection = 0; projection < 2; ++projection) {
    stage *s = new_stage((asc_projection)projection);
    s->scene.view.background[0] = 0.5;
    float pixels[3 * PIXELS];
    render_once(s, 4, unmoved, pixels);
    assert_true(red_sum(pixels) == 0.5 * PIXELS);
  }
}

/* --- bad input --------------------------------------------------------------------------------------------------- */

static stage *fine_stage(void) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const double quad[4][2] = {{3.3, 2.2}, {8.2, 2.2}, {8.2, 4.3}, {3.3, 4.3}};
  add_quad(s, quad, 0.0, add_material(s, 1.0, 1.0, 1.0));
  add_disc(s, 5.0, 5.0, 1.0, 0);
  add_sphere(s, 1.0, 1.0, 1.0, 1.0, 0);
  return s;
}

/* Expects that the stage is refused, with a text that has this word, and frees it. */
static void refused(stage *s, const char *word) {
  raster *made = NULL;
  asc_error error = {""};
  assert_int_equal(raster_create(&s->scene, &made, &error), ASC_INVALID_ARGUMENT);
  assert_null(made);
  if (!strstr(error.text, word)) {
    fail_msg("\"%s\" does not speak of \"%s\"", error.text, word);
  }
  assert_int_equal(raster_create(&s->scene, &made, NULL), ASC_INVALID_ARGUMENT);
  free(s);
}

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
  asc_error error = {""};
  assert_int_equal(raster_create(NULL, NULL, &error), ASC_INVALID_ARGUMENT);
}

static asc_status try_render(raster *made, uint32_t samples, const double *offset, const double *weight, size_t count) {
  float pixels[3 * PIXELS];
  const raster_desc desc = {sizeof desc, samples, offset, weight, count};
  asc_error error = {""};
  asc_status status = raster_render(made, &desc, pixels, NULL, &error);
  assert_int_equal(status == ASC_OK, error.text[0] == '\0');
  return status;
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
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_picture_is_not_mirrored_or_transposed),
      cmocka_unit_test(test_an_offset_is_from_left_and_top),
      cmocka_unit_test(test_multisamples_lie_where_they_are_said_to),
      cmocka_unit_test(test_a_resolved_pixel_is_the_mean),
      cmocka_unit_test(test_edges_along_an_axis),
      cmocka_unit_test(test_slanted_edges),
      cmocka_unit_test(test_areas_of_discs),
      cmocka_unit_test(test_the_outline_of_a_disc_is_exact),
      cmocka_unit_test(test_the_outline_of_a_sphere_in_perspective_is_exact),
      cmocka_unit_test(test_a_sphere_is_seen_from_inside_and_not_from_behind),
      cmocka_unit_test(test_what_reaches_behind_the_eye_is_cut),
      cmocka_unit_test(test_the_nearest_is_seen),
      cmocka_unit_test(test_a_wall_stands_in_a_floor),
      cmocka_unit_test(test_a_zone_plate_follows_its_formula),
      cmocka_unit_test(test_passes_are_summed_by_weight),
      cmocka_unit_test(test_an_empty_scene_is_background),
      cmocka_unit_test(test_bad_scenes_are_refused),
      cmocka_unit_test(test_bad_requests_are_refused),
      cmocka_unit_test(test_a_colour_beyond_float_is_reported),
      cmocka_unit_test(test_it_says_what_it_is),
  };
  return cmocka_run_group_tests_name("raster", tests, NULL, NULL);
}

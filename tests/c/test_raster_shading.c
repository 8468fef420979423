/* Patterns, and the sums of passes. */
#include "raster_scenes.h"

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

/* Turned about the vertical axis, so that the world's axes are not the camera's. */
static void turn_view(stage *s, double angle) {
  const double right[3] = {cos(angle), 0.0, -sin(angle)};
  const double forward[3] = {-sin(angle), 0.0, -cos(angle)};
  memcpy(s->scene.view.right, right, sizeof right);
  memcpy(s->scene.view.forward, forward, sizeof forward);
}

static int parity(const asc_pattern *pattern, const double p[3]) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    sum += floor(pattern->scale * (p[i] - pattern->origin[i]));
  }
  return (int)fmod(fabs(sum), 2.0);
}

static const asc_pattern board = {
    ASC_PATTERN_CHECKER, 1.7319, {0.1371, 0.2917, 0.0733}, {0.1, 0.2, 0.3}, {0.9, 1.0, 0.5}};

/* The colour of the board, times emission 0.9, on the floor y = -1 at a picture position; background above it. */
static double board_red(const stage *s, double px, double py) {
  double d[3];
  double p[3];
  ray_through(px, py, d);
  if (!(d[1] < 0.0)) {
    return 0.5;
  }
  const asc_view *view = &s->scene.view;
  for (int i = 0; i < 3; ++i) {
    p[i] = view->eye[i] + (d[0] * view->right[i] + d[1] * view->up[i] - d[2] * view->forward[i]) * (-1.0 / d[1]);
  }
  return 0.9 * (parity(&board, p) ? board.high[0] : board.low[0]);
}

static stage *board_stage(void) {
  static const double point[3] = {0.0, -1.0, 0.0};
  static const double up[3] = {0.0, 3.0, 0.0};
  stage *s = new_stage(ASC_PERSPECTIVE);
  turn_view(s, 0.43);
  s->scene.view.background[0] = 0.5;
  add_plane(s, point, up, add_material(s, 0.9, 0.8, 0.7));
  s->materials[0].pattern = board;
  return s;
}

static void test_a_checker_follows_its_formula(void **state) {
  (void)state;
  const double at[2] = {0.3125, 0.71875};
  stage *s = board_stage();
  raster *made = made_of(s);
  float pixels[3 * PIXELS];
  render(made, 1, at, one, 1, pixels);
  raster_destroy(made);
  for (int i = 0; i < PIXELS; ++i) {
    /* Rounding of four float operations on numbers up to 1. */
    assert_true(fabs((double)pixels[3 * i] - board_red(s, i % WIDTH + at[0], i / WIDTH + at[1])) < 3e-7);
  }
  free(s);
}

/* Cells are counted in double, past where an integer of 32 bits ends. All the numbers are exact. */
static void test_a_checker_of_tiny_cells(void **state) {
  (void)state;
  const asc_pattern tiny = {ASC_PATTERN_CHECKER, 4294967297.0 / 4.0, {0.25, -3.5, 0.0}, {0.0}, {1.0, 1.0, 1.0}};
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const double quad[4][2] = {{-5.0, -5.0}, {40.0, -5.0}, {40.0, 30.0}, {-5.0, 30.0}};
  add_quad(s, quad, 0.0, add_material(s, 1.0, 1.0, 1.0));
  s->materials[0].pattern = tiny;
  float pixels[3 * PIXELS];
  render_once(s, 1, unmoved, pixels);
  for (int i = 0; i < PIXELS; ++i) {
    const double p[3] = {i % WIDTH + 0.5 - 0.5 * WIDTH, 0.5 * HEIGHT - i / WIDTH - 0.5, 0.0};
    assert_true(pixels[3 * i] == (float)parity(&tiny, p));
  }
}

/* Shaded for each sample a pixel is the mean over their places; shaded once a pixel it is what its centre has. Where
 * the centre of a pixel at the horizon sees no plane, that is as the sample itself has it. */
static void test_patterns_are_evaluated_where_it_is_said(void **state) {
  (void)state;
  double positions[POSITIONS][2];
  assert_int_equal(raster_sample_positions(&positions[0][0], NULL), ASC_OK);
  stage *s = board_stage();
  raster *made = made_of(s);
  float once[3 * PIXELS];
  float each[3 * PIXELS];
  const raster_desc desc = passes_of(POSITIONS, unmoved, one, 1, 1);
  render(made, POSITIONS, unmoved, one, 1, once);
  render_desc(made, &desc, each);
  raster_destroy(made);
  int different = 0;
  for (int i = 0; i < PIXELS; ++i) {
    double mean = 0.0;
    for (int k = 0; k < POSITIONS; ++k) {
      mean += 0.25 * board_red(s, i % WIDTH + positions[k][0], i / WIDTH + positions[k][1]);
    }
    /* Rounding as above, and of a sum of four. */
    assert_true(fabs((double)each[3 * i] - mean) < 5e-7);
    if (i / WIDTH != HEIGHT / 2 - 1) { /* the row whose lower border is the horizon has only background */
      assert_true(fabs((double)once[3 * i] - board_red(s, i % WIDTH + 0.5, i / WIDTH + 0.5)) < 5e-7);
    }
    different += fabs((double)once[3 * i] - mean) > 0.1;
  }
  assert_true(different > WIDTH);
  free(s);
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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_checker_follows_its_formula),
      cmocka_unit_test(test_a_checker_of_tiny_cells),
      cmocka_unit_test(test_patterns_are_evaluated_where_it_is_said),
      cmocka_unit_test(test_a_zone_plate_follows_its_formula),
      cmocka_unit_test(test_passes_are_summed_by_weight),
      cmocka_unit_test(test_an_empty_scene_is_background),
  };
  return cmocka_run_group_tests_name("raster shading", tests, NULL, NULL);
}

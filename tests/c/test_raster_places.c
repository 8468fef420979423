/* Where the rasteriser samples, and where it puts edges. */
#include "raster_scenes.h"

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

/* --- edges */

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

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_picture_is_not_mirrored_or_transposed),
      cmocka_unit_test(test_an_offset_is_from_left_and_top),
      cmocka_unit_test(test_multisamples_lie_where_they_are_said_to),
      cmocka_unit_test(test_a_resolved_pixel_is_the_mean),
      cmocka_unit_test(test_edges_along_an_axis),
      cmocka_unit_test(test_slanted_edges),
  };
  return cmocka_run_group_tests_name("raster places", tests, NULL, NULL);
}

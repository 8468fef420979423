/* Lights with an area: the point of each that a pass chooses. */
#include "raster_scenes.h"

static const double rounding = 5e-7; /* of a few float operations on numbers below 2 */

/* Red paper without an end, seen from above. */
static stage *new_floor(void) {
  stage *s = new_stage(ASC_ORTHOGRAPHIC);
  const uint32_t paper = add_material(s, 0.0, 0.0, 0.0);
  s->materials[paper].albedo[0] = 1.0;
  const double origin[3] = {0.0, 0.0, 0.0};
  const double normal[3] = {0.0, 0.0, 1.0};
  add_plane(s, origin, normal, paper);
  return s;
}

/* The floor below a light, one pass: against the equation of scene.h at the point that the numbers choose. */
static void light_case(asc_light_kind kind, uint32_t inverse_square, double side) {
  stage *s = new_floor();
  asc_light *lamp = add_light(s, kind, 1.5, -2.0, 6.0);
  lamp->inverse_square = inverse_square;
  lamp->intensity[0] = inverse_square ? 30.0 : 1.0;
  lamp->radius = 2.5;
  const double edges[2][3] = {{3.0, 0.5, 0.75}, {-0.5 * side, 3.0 * side, 0.0}};
  memcpy(lamp->edges, edges, sizeof edges);
  /* Of the disc's map: on the diagonal of the square, at 45 degrees and a radius of 0.5 (concentric.h). */
  const double u[2] = {0.75, 0.75};
  const double along = kind == ASC_LIGHT_DISC ? 0.5 * sqrt(0.5) : 0.75;
  float pixels[3 * PIXELS];
  render_pass(s, NULL, NULL, u, pixels);
  double facing[3] = {edges[0][1] * edges[1][2] - edges[0][2] * edges[1][1],
                      edges[0][2] * edges[1][0] - edges[0][0] * edges[1][2],
                      edges[0][0] * edges[1][1] - edges[0][1] * edges[1][0]};
  const double size = sqrt(facing[0] * facing[0] + facing[1] * facing[1] + facing[2] * facing[2]);
  for (int i = 0; i < PIXELS; ++i) {
    const double p[3] = {i % WIDTH + 0.5 - 0.5 * WIDTH, 0.5 * HEIGHT - i / WIDTH - 0.5, 0.0};
    double square = 0.0;
    double emitted = 0.0;
    double way[3];
    for (int k = 0; k < 3; ++k) {
      way[k] = lamp->place[k] + along * (edges[0][k] + edges[1][k]) - p[k];
      square += way[k] * way[k];
      emitted -= way[k] * facing[k] / size;
    }
    const double cosine = way[2] / sqrt(square);
    const double expected = inverse_square ? 30.0 * cosine * fmax(0.0, emitted / sqrt(square)) / square : cosine;
    assert_true(fabs((double)pixels[3 * i] - expected) < 2.0 * rounding);
  }
  assert_true(inverse_square && side > 0.0 ? red_sum(pixels) == 0.0 : red_sum(pixels) > 10.0);
  free(s);
}

static void test_a_pass_is_lit_by_its_point_of_a_flat_light(void **state) {
  (void)state;
  for (uint32_t inverse_square = 0; inverse_square < 2; ++inverse_square) {
    light_case(ASC_LIGHT_PARALLELOGRAM, inverse_square, 1.0);
    light_case(ASC_LIGHT_PARALLELOGRAM, inverse_square, -1.0);
    light_case(ASC_LIGHT_DISC, inverse_square, 1.0);
    light_case(ASC_LIGHT_DISC, inverse_square, -1.0);
  }
}

/* In the mean over many passes a sphere above the horizon lights as the point light at its centre, and from within not
 * at all; in the light of a sphere the shadows are those of its points. */
static void test_a_ball_of_light(void **state) {
  (void)state;
  enum { COUNT = 1024 };
  static double offsets[2 * COUNT];
  static double weights[COUNT];
  static double numbers[2 * COUNT];
  fill_lattice(COUNT, 275, numbers, weights);
  for (size_t i = 0; i < COUNT; ++i) {
    offsets[2 * i] = offsets[2 * i + 1] = 0.5;
  }
  stage *s = new_floor();
  asc_light *lamp = add_light(s, ASC_LIGHT_SPHERE, 1.5, -2.0, 4.0);
  lamp->inverse_square = 1;
  lamp->intensity[0] = 30.0;
  lamp->radius = 2.5;
  for (int within = 0; within < 2; ++within) {
    raster *made = made_of(s);
    raster_desc desc = passes_of(1, offsets, weights, COUNT, 0);
    desc.lights = numbers;
    float pixels[3 * PIXELS];
    render_desc(made, &desc, pixels);
    raster_destroy(made);
    for (int i = 0; i < PIXELS; ++i) {
      const double x = i % WIDTH + 0.5 - 0.5 * WIDTH - 1.5;
      const double y = 0.5 * HEIGHT - i / WIDTH - 0.5 + 2.0;
      const double square = x * x + y * y + 16.0;
      const double expected = within ? 0.0 : 30.0 * 4.0 / (square * sqrt(square));
      /* A lattice of 1,024 points on a smooth integrand: 3e-4 of it was measured. */
      assert_true(fabs((double)pixels[3 * i] - expected) <= 1e-3 * expected);
    }
    lamp->radius = 40.0;
  }
  free(s);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_pass_is_lit_by_its_point_of_a_flat_light),
      cmocka_unit_test(test_a_ball_of_light),
  };
  return cmocka_run_group_tests_name("raster area lights", tests, NULL, NULL);
}

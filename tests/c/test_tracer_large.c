/* Balls and discs much larger than they are far away: each sample is what double, or more, makes of it. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tracer.h"

enum { SIDE = 40, PIXELS = SIDE * SIDE, VALUES = PIXELS * 3 };

static const asc_material WHITE = {.emission = {1, 1, 1}}, CHALK = {.albedo = {1, 1, 1}};
static const asc_light SUN = {.kind = ASC_LIGHT_DIRECTIONAL, .place = {0, -1, 0}, .intensity = {1, 1, 1}};

/* From a place along -z. */
static asc_view view_from(const double eye[3], asc_projection projection, double half) {
  return (asc_view){.projection = projection,
                    .width = SIDE,
                    .height = SIDE,
                    .eye = {eye[0], eye[1], eye[2]},
                    .right = {1, 0, 0},
                    .up = {0, 1, 0},
                    .forward = {0, 0, -1},
                    .half_width = half,
                    .half_height = half};
}

static asc_scene of_balls(asc_view view, const asc_sphere *balls, size_t count, const asc_material *materials,
                          size_t material_count) {
  return (asc_scene){.struct_size = sizeof(asc_scene),
                     .view = view,
                     .materials = materials,
                     .material_count = material_count,
                     .spheres = balls,
                     .sphere_count = count};
}

/* One sample in the middle of each pixel. */
static void draw(const asc_scene *scene, tracer_options options, float *pixels) {
  tracer *made = NULL;
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  options.struct_size = sizeof options;
  if (tracer_create_with(scene, &options, &made, &error)) fail_msg("%s", error.text);
  const asc_sampler_desc pattern = {sizeof pattern, "regular", 1, tracer_dimensions(made), 7};
  if (asc_sampler_create(&pattern, &sampler, &error)) fail_msg("%s", error.text);
  const tracer_desc desc = {sizeof desc, sampler, 1, NULL};
  if (tracer_render(made, &desc, pixels, NULL, &error)) fail_msg("%s", error.text);
  asc_sampler_destroy(sampler);
  tracer_destroy(made);
}

/* Where the middle of a pixel lies, from -half to half; of rows downward. */
static double across_of(int pixel, double half) { return half * ((2.0 * pixel + 1.0) / SIDE - 1.0); }

/* Says of how many pixels the first channel is not what `expected` says, of its middle. */
static int count_wrong(const float *pixels, double half, float (*expected)(double u, double v, const void *of),
                       const void *of) {
  int wrong = 0;
  for (int y = 0; y < SIDE; y++)
    for (int x = 0; x < SIDE; x++) {
      const float got = pixels[3 * (y * SIDE + x)];
      wrong += !(fabsf(got - expected(across_of(x, half), -across_of(y, half), of)) < 1e-6f);
    }
  return wrong;
}

/* A ball by its centre from the eye. */
typedef struct seen_ball {
  long double centre[3], radius;
} seen_ball;

/* In long double: of a radius of 10^12 squares are off by 6e4, the power by 3e-8 of itself. */
static float ball_is_seen(double u, double v, const void *of) {
  const seen_ball *ball = of;
  const long double way[3] = {u, v, -1.0L};
  long double squared = 0.0L, toward = 0.0L, power = -ball->radius * ball->radius;
  for (int i = 0; i < 3; i++) {
    squared += way[i] * way[i];
    toward += way[i] * ball->centre[i];
    power += ball->centre[i] * ball->centre[i];
  }
  const int meets = toward * toward > squared * power && (toward > 0.0L || power < 0.0L);
  return meets ? 1.0f : 0.0f;
}

enum { BALLS = 6 };

/* A ball whose top is 1 under the eye, and others as large and as near behind it, so that Embree has boxes to look
 * into. */
static void set_balls(double radius, asc_sphere balls[BALLS]) {
  balls[0] = (asc_sphere){{0.25, -1.0 - radius, 0.5}, radius, 0};
  for (int i = 1; i < BALLS; i++) {
    const double angle = 0.5 * i;
    balls[i] = (asc_sphere){{(1.0 + radius) * cos(angle), 0.0, (1.0 + radius) * sin(angle)}, radius, 0};
  }
}

/* From 1 above a ball, through a window in which the horizon's dip is an eighth of the height: Embree's own was off by
 * a pixel from 10^4 on, and by all of it from 10^8 on. With every width of packets, which ask of so many lanes; and lit
 * from above, where the ball must not lie in its own shadow. */
static void the_horizon_of_a_ball_is_where_it_is(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  static const uint32_t packets[] = {16, 8, 4, 1};
  for (int power = 3; power <= 12; power++) {
    const double radius = pow(10.0, power), half = 4.0 * sqrt(2.0 / radius);
    asc_sphere balls[BALLS];
    set_balls(radius, balls);
    const seen_ball truth = {{0.25L, -1.0L - radius, 0.5L}, radius};
    asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, half), balls, BALLS, &WHITE, 1);
    for (size_t k = 0; k < sizeof packets / sizeof *packets; k++) {
      for (size_t lit = 0; lit < 2; lit++) {
        scene.materials = lit ? &CHALK : &WHITE;
        scene.lights = &SUN;
        scene.light_count = lit;
        draw(&scene, (tracer_options){.packet = packets[k]}, pixels);
        for (size_t i = 0; i < VALUES && lit; i++) pixels[i] = pixels[i] > 0.9f ? 1.0f : pixels[i]; /* a cosine */
        const int wrong = count_wrong(pixels, half, ball_is_seen, &truth);
        if (wrong > 0) fail_msg("radius %g, packets of %u, %s: %d", radius, packets[k], lit ? "lit" : "white", wrong);
      }
    }
  }
}

/* With a radius of 10^15 double parts eighths: centre and eye differ by what is no double, and yet they tell how far
 * the eye is above. The row of pixels beside the horizon is within 1/200 of its dip, on either side. */
static void places_that_are_no_doubles_from_the_eye_count(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double shares[] = {0.93, 0.97}; /* rows lie at 0.925 and 0.975 */
  const double radius = 1e15;
  for (int k = 0; k < 10; k++) {
    const double eye[3] = {0.0, 0.30 + 0.0125 * k, 0.0}, dip = sqrt(2.0 * (eye[1] + 0.125) / radius);
    const double half = dip / shares[k % 2];
    const asc_sphere ball = {{0.0, -0.125 - radius, 0.0}, radius, 0};
    const asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, half), &ball, 1, &WHITE, 1);
    draw(&scene, (tracer_options){0}, pixels);
    for (int y = 0; y < SIDE; y++)
      if (pixels[3 * y * SIDE] != (across_of(y, half) > dip ? 1.0f : 0.0f)) fail_msg("eye at %g, row %d", eye[1], y);
  }
}

/* From within, 1 above the ground of a ball that is all there is. */
static void a_ball_is_closed_round_the_eye(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  for (int power = 4; power <= 12; power++) {
    const double radius = pow(10.0, power);
    const asc_sphere ball = {{0.0, radius - 1.0, 0.0}, radius, 0};
    const asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, 1.0), &ball, 1, &WHITE, 1);
    draw(&scene, (tracer_options){0}, pixels);
    for (size_t i = 0; i < VALUES; i++)
      if (pixels[i] != 1.0f) fail_msg("radius %g", radius);
  }
}

/* Side by side from before a ball's top, which is 0.3 under the middle. */
static void an_orthographic_view_has_the_same_edge(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  for (int power = 3; power <= 12; power++) {
    const double radius = pow(10.0, power);
    const asc_sphere ball = {{0.0, -0.3 - radius, -3.0}, radius, 0};
    const asc_scene scene = of_balls(view_from(eye, ASC_ORTHOGRAPHIC, 1.0), &ball, 1, &WHITE, 1);
    draw(&scene, (tracer_options){0}, pixels);
    /* 1e-3: a pixel's middle is 0.025 from the edge, which a coordinate of 10^12, a double to 1.2e-4, moves by that. */
    for (int y = 0; y < SIDE; y++)
      for (int x = 0; x < SIDE; x++) {
        const double u = across_of(x, 1.0), v = -across_of(y, 1.0), top = -0.3 - 0.5 * u * u / radius;
        if (fabs(v - top) > 1e-3 && pixels[3 * (y * SIDE + x)] != (v < top ? 1.0f : 0.0f))
          fail_msg("radius %g: %d, %d", radius, x, y);
      }
  }
}

/* A disc under the eye, and to one side of it. */
static float disc_is_seen(double u, double v, const void *of) {
  const asc_disc *disc = of;
  const long double way[3] = {u, v, -1.0L};
  long double along = 0.0L, offset = 0.0L, squared = 0.0L;
  for (int i = 0; i < 3; i++) {
    along += way[i] * disc->normal[i];
    offset += (long double)disc->centre[i] * disc->normal[i];
  }
  for (int i = 0; i < 3; i++) squared += powl(offset / along * way[i] - disc->centre[i], 2.0L);
  return offset / along > 0.0L && squared <= (long double)disc->radius * disc->radius ? 1.0f : 0.0f;
}

static void the_horizon_of_a_disc_is_where_it_is(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  for (int power = 3; power <= 12; power++) {
    const double radius = pow(10.0, power);
    const asc_disc discs[] = {{{0.5 * radius, -1.0 - 0.0625 * radius, 0.25 * radius}, {0.125, 1.0, 0.0}, radius, 0},
                              {{radius - 0.21, -1.0, -1.5}, {0.0, 3.0, 0.0}, radius, 0}}; /* whose rim is near */
    for (size_t k = 0; k < 2; k++) {
      asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, 1.0), NULL, 0, &WHITE, 1);
      scene.discs = &discs[k];
      scene.disc_count = 1;
      draw(&scene, (tracer_options){0}, pixels);
      const int wrong = count_wrong(pixels, 1.0, disc_is_seen, &discs[k]);
      if (wrong > 0) fail_msg("radius %g, disc %zu: %d pixels", radius, k, wrong);
    }
  }
}

/* Above the eye a ball or a disc, so large that no sun comes by; but where the disc's rim is. */
static void large_balls_and_discs_throw_shadows(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  static const asc_plane floor = {{0.0, -1.0, 0.0}, {0, 1, 0}, 0};
  for (int power = 4; power <= 12; power++) {
    const double radius = pow(10.0, power);
    const asc_sphere ball = {{0.0, 1.0 + radius, 0.0}, radius, 0};
    const asc_disc disc = {{radius - 0.21, 1.0, -1.5}, {0.0, 1.0, 0.0}, radius, 0};
    for (size_t round = 0; round < 2; round++) {
      asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, 1.0), &ball, round, &CHALK, 1);
      scene.discs = &disc;
      scene.disc_count = 1 - round;
      scene.planes = &floor;
      scene.plane_count = 1;
      scene.lights = &SUN;
      scene.light_count = 1;
      draw(&scene, (tracer_options){0}, pixels);
      for (int y = SIDE / 2 + 3; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
          const double place = across_of(x, 1.0) / across_of(y, 1.0);
          const float got = pixels[3 * (y * SIDE + x)];
          if (got != (round || place > -0.21 ? 0.0f : 1.0f))
            fail_msg("radius %g: %d, %d: %g", radius, x, y, (double)got);
        }
    }
  }
}

typedef enum ground { BALL, DISC, FLOOR } ground;

/* On a ground 1 under the eye two small balls, of other materials, the sun above them. */
static void draw_ground(ground kind, double radius, int one_moves, const asc_material materials[3], float *pixels) {
  static const double eye[3] = {0.0, 0.0, 0.0};
  static const asc_motion motion = {.kind = ASC_MOTION_TRANSLATE, .by = {0.5, 0.0, 0.0}};
  const uint32_t still_and_moving[] = {1, 0, 0};
  const asc_sphere balls[] = {
      {{-0.5, -0.625, -3.0}, 0.25, 1}, {{0.0, -1.0 - radius, 0.0}, radius, 0}, {{0.5, -0.625, -3.0}, 0.25, 2}};
  const asc_sphere small[] = {balls[0], balls[2]};
  const asc_disc disc = {{0.0, -1.0, 0.0}, {0, 2, 0}, radius, 0};
  const asc_plane floor = {{0.0, -1.0, 0.0}, {0, 1, 0}, 0};
  asc_scene scene =
      of_balls(view_from(eye, ASC_PERSPECTIVE, 0.5), kind == BALL ? balls : small, kind == BALL ? 3 : 2, materials, 3);
  scene.view.shutter_close = 1.0;
  scene.discs = &disc;
  scene.disc_count = kind == DISC;
  scene.planes = &floor;
  scene.plane_count = kind == FLOOR;
  scene.lights = &SUN;
  scene.light_count = 1;
  scene.motions = &motion;
  scene.motion_count = (size_t)one_moves;
  scene.sphere_motion = one_moves ? still_and_moving : NULL;
  draw(&scene, (tracer_options){0}, pixels);
}

/* Down to 10 away, where the ground is flat to 50 / radius. */
static void expect_alike(const float *pixels, const float *flat, const char *what, double radius) {
  for (int i = 0; i < PIXELS; i++)
    if (-across_of(i / SIDE, 0.5) < -0.1)
      for (int channel = 0; channel < 3; channel++)
        if (!(fabsf(pixels[3 * i + channel] - flat[3 * i + channel]) < 1e-5f))
          fail_msg("%s of %g: %d, %d", what, radius, i % SIDE, i / SIDE);
}

/* Near the eye a large ball or disc is a floor: with the shadows that are cast on it, beside what moves or does not,
 * and with patterns of checks. */
static void the_ground_near_the_eye_is_a_floor(void **state) {
  (void)state;
  static float flat[VALUES], pixels[VALUES];
  const asc_pattern checks = {ASC_PATTERN_CHECKER, 3.0, {0.3, 0.4, 0.1}, {0.25, 0.5, 0.75}, {1, 1, 1}};
  const asc_material grounds[] = {
      CHALK, {.albedo = {1, 1, 1}, .pattern = checks}, {.emission = {1, 1, 1}, .pattern = checks}};
  for (size_t kind = 0; kind < 3; kind++)
    for (int one_moves = 0; one_moves < 2; one_moves++) {
      const asc_material materials[] = {grounds[kind], {.emission = {0.25, 0.0, 0.0}}, {.emission = {0.0, 0.5, 0.0}}};
      draw_ground(FLOOR, 1.0, one_moves, materials, flat);
      for (int power = 8; power <= 12; power++) {
        const double radius = pow(10.0, power);
        draw_ground(BALL, radius, one_moves, materials, pixels);
        expect_alike(pixels, flat, "ball", radius);
        draw_ground(DISC, radius, one_moves, materials, pixels);
        expect_alike(pixels, flat, "disc", radius);
      }
    }
}

/* Large balls that come from far to where one stands still, straight or half round another place: lit, at time 1. */
static void what_is_large_and_moves_is_where_it_is_then(void **state) {
  (void)state;
  static float pixels[VALUES], truth[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  static const uint32_t first[BALLS] = {1};
  for (int power = 4; power <= 12; power++) {
    const double radius = pow(10.0, power), half = 4.0 * sqrt(2.0 / radius), way = 10.0 * radius;
    const asc_motion motions[] = {{.kind = ASC_MOTION_TRANSLATE, .by = {-way, -1.0, 0.0}},
                                  {.kind = ASC_MOTION_ROTATE,
                                   .axis = {0, 1, 0},
                                   .centre = {0.25 + 0.5 * way, -1.0 - radius, 0.5},
                                   .angle = 3.14159265358979323846}};
    for (size_t kind = 0; kind < 2; kind++) {
      asc_sphere balls[BALLS];
      set_balls(radius, balls);
      asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, half), balls, BALLS, &CHALK, 1);
      scene.lights = &SUN;
      scene.light_count = 1;
      draw(&scene, (tracer_options){0}, truth);
      balls[0].centre[0] += way;
      balls[0].centre[1] += kind == 0;
      scene.view.shutter_open = 1.0 - 0x1p-53;
      scene.view.shutter_close = 1.0;
      scene.motions = &motions[kind];
      scene.motion_count = 1;
      scene.sphere_motion = first;
      draw(&scene, (tracer_options){0}, pixels);
      for (size_t i = 0; i < VALUES; i++)
        if (!(fabsf(pixels[i] - truth[i]) < 1e-5f)) fail_msg("radius %g, kind %zu: %zu", radius, kind, i / 3);
    }
  }
}

/* Embree's balls that turn are off by where its straight lines are, from which shadow rays keep away; not so these. */
static void large_balls_that_turn_keep_their_shadows(void **state) {
  (void)state;
  static float pixels[VALUES], truth[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  static const uint32_t second[] = {0, 1};
  for (int power = 6; power <= 12; power++) {
    const double radius = pow(10.0, power);
    const asc_sphere balls[] = {{{-0.5, -0.625, -3.0}, 0.25, 0}, {{0.0, -1.0 - radius, 0.0}, radius, 0}};
    const asc_motion turn = {
        .kind = ASC_MOTION_ROTATE, .axis = {0, 1, 0}, .centre = {0.0, -1.0 - radius, 0.0}, .angle = 1.0};
    asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, 0.5), balls, 2, &CHALK, 1);
    scene.lights = &SUN;
    scene.light_count = 1;
    draw(&scene, (tracer_options){0}, truth);
    scene.view.shutter_close = 1.0;
    scene.motions = &turn;
    scene.motion_count = 1;
    scene.sphere_motion = second;
    draw(&scene, (tracer_options){0}, pixels);
    expect_alike(pixels, truth, "turning ball", radius);
  }
}

/* What shines by itself, with a pattern, and nothing else: there is a way that takes flat surfaces alone. */
static void a_large_ball_shines_in_its_pattern(void **state) {
  (void)state;
  static float flat[VALUES], pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  const double radius = 1e9;
  const asc_material checks = {.emission = {1, 1, 1},
                               .pattern = {ASC_PATTERN_CHECKER, 3.0, {0.3, 0.4, 0.1}, {0.25, 0.5, 0.75}, {1, 1, 1}}};
  const asc_sphere ball = {{0.0, -1.0 - radius, 0.0}, radius, 0};
  const asc_plane floor = {{0.0, -1.0, 0.0}, {0, 1, 0}, 0};
  asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, 0.5), &ball, 1, &checks, 1);
  draw(&scene, (tracer_options){0}, pixels);
  scene.sphere_count = 0;
  scene.planes = &floor;
  scene.plane_count = 1;
  draw(&scene, (tracer_options){0}, flat);
  expect_alike(pixels, flat, "shining ball", radius);
}

/* Where places are rounded to float first nothing is held in double. */
static void without_the_switch_the_horizon_is_lost(void **state) {
  (void)state;
  static float pixels[VALUES];
  static const double eye[3] = {0.0, 0.0, 0.0};
  const double radius = 1e9, half = 4.0 * sqrt(2.0 / radius);
  const asc_sphere ball = {{0.0, -1.0 - radius, 0.0}, radius, 0};
  const seen_ball truth = {{0.0L, -1.0L - radius, 0.0L}, radius};
  const asc_scene scene = of_balls(view_from(eye, ASC_PERSPECTIVE, half), &ball, 1, &WHITE, 1);
  draw(&scene, (tracer_options){.not_relative = 1}, pixels);
  assert_true(count_wrong(pixels, half, ball_is_seen, &truth) > PIXELS / 20);
  const asc_disc disc = {{5e11, -1.0 - 6.25e10, 2.5e11}, {0.125, 1.0, 0.0}, 1e12, 0};
  asc_scene other = of_balls(view_from(eye, ASC_PERSPECTIVE, 1.0), NULL, 0, &WHITE, 1);
  other.discs = &disc;
  other.disc_count = 1;
  draw(&other, (tracer_options){.not_relative = 1}, pixels);
  assert_true(count_wrong(pixels, 1.0, disc_is_seen, &disc) > PIXELS / 20);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_horizon_of_a_ball_is_where_it_is),
      cmocka_unit_test(places_that_are_no_doubles_from_the_eye_count),
      cmocka_unit_test(a_ball_is_closed_round_the_eye),
      cmocka_unit_test(an_orthographic_view_has_the_same_edge),
      cmocka_unit_test(the_horizon_of_a_disc_is_where_it_is),
      cmocka_unit_test(large_balls_and_discs_throw_shadows),
      cmocka_unit_test(the_ground_near_the_eye_is_a_floor),
      cmocka_unit_test(what_is_large_and_moves_is_where_it_is_then),
      cmocka_unit_test(large_balls_that_turn_keep_their_shadows),
      cmocka_unit_test(a_large_ball_shines_in_its_pattern),
      cmocka_unit_test(without_the_switch_the_horizon_is_lost),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

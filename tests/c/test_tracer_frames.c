/* The tracer's meshes of frames: what it refuses, and what it copies. Where they are is tested in Python. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "tracer.h"

enum { W = 12, H = 8, FRAMES = 3 };

/* Two triangles that name the motion, and between them one that stands still. */
typedef struct filming {
  double vertices[3][3][3], frames[FRAMES][2][3][3];
  uint32_t materials[3], moving[3];
  asc_material white;
  asc_motion motion;
  asc_scene scene;
} filming;

static void begin(filming *made, double open, double close) {
  static const double triangle[3][3] = {{1, 1, 0}, {5, 2, 0}, {2, 7, 0}};
  *made = (filming){.moving = {1, 0, 1}, .white = {.emission = {1, 1, 1}}};
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 9; i++) made->vertices[k][i / 3][i % 3] = triangle[i / 3][i % 3] + 2.0 * k;
  for (int frame = 0; frame < FRAMES; frame++)
    for (int i = 0; i < 9; i++)
      for (int k = 0; k < 2; k++) made->frames[frame][k][i / 3][i % 3] = made->vertices[2 * k][i / 3][i % 3] + frame;
  made->motion = (asc_motion){
      .kind = ASC_MOTION_FRAMES, .frames = &made->frames[0][0][0][0], .frame_count = FRAMES, .frame_triangles = 2};
  made->scene = (asc_scene){.struct_size = sizeof made->scene,
                            .view = {.projection = ASC_ORTHOGRAPHIC,
                                     .width = W,
                                     .height = H,
                                     .eye = {W / 2.0, H / 2.0, 10.0},
                                     .right = {1, 0, 0},
                                     .up = {0, 1, 0},
                                     .forward = {0, 0, -1},
                                     .half_width = W / 2.0,
                                     .half_height = H / 2.0,
                                     .shutter_open = open,
                                     .shutter_close = close},
                            .materials = &made->white,
                            .material_count = 1,
                            .vertices = &made->vertices[0][0][0],
                            .triangle_material = made->materials,
                            .triangle_count = 3,
                            .motions = &made->motion,
                            .motion_count = 1,
                            .triangle_motion = made->moving};
}

static void refuse(const filming *made, asc_status expected, const char *reason) {
  tracer *never = NULL;
  asc_error error = {{0}};
  assert_int_equal(tracer_create(&made->scene, &never, &error), expected);
  assert_null(never);
  if (!strstr(error.text, reason)) fail_msg("%s", error.text);
}

static void what_cannot_be_is_refused(void **state) {
  (void)state;
  filming made;
  begin(&made, 0.0, 1.0);
  made.motion.frames = NULL;
  refuse(&made, ASC_INVALID_ARGUMENT, "1 to 128 frames");
  begin(&made, 0.0, 1.0);
  made.motion.frame_count = 0;
  refuse(&made, ASC_INVALID_ARGUMENT, "1 to 128 frames");
  made.motion.frame_count = 129;
  refuse(&made, ASC_INVALID_ARGUMENT, "1 to 128 frames");
  begin(&made, 0.0, 1.0);
  made.motion.frame_triangles = 3;
  refuse(&made, ASC_INVALID_ARGUMENT, "frames of 3 triangles, and 2 triangles name it");
  begin(&made, 0.0, 1.0);
  made.frames[FRAMES - 1][1][2][1] = NAN;
  refuse(&made, ASC_INVALID_ARGUMENT, "not finite");
  begin(&made, -0.5, 0.5);
  refuse(&made, ASC_INVALID_ARGUMENT, "from time 0 to 1");
  begin(&made, 0.5, 1.5);
  refuse(&made, ASC_INVALID_ARGUMENT, "from time 0 to 1");
  begin(&made, 1.0 / 3.0 - 1e-6, 1.0 / 3.0 + 1e-6);
  refuse(&made, ASC_UNSUPPORTED, "across a frame");
  begin(&made, 0.0, 1.0);
  made.motion.kind = (asc_motion_kind)7;
  refuse(&made, ASC_INVALID_ARGUMENT, "unknown kind");
  begin(&made, 0.0, 1.0);
  const asc_sphere ball = {{1, 1, 0}, 1, 0};
  const uint32_t first = 1;
  made.scene.spheres = &ball;
  made.scene.sphere_count = 1;
  made.scene.sphere_motion = &first;
  refuse(&made, ASC_INVALID_ARGUMENT, "a surface that is no triangle");
}

/* With a light, so that places in double are kept too; the caller's arrays are gone when the picture is made. */
static void frames_are_copied(void **state) {
  (void)state;
  static const double shutters[][2] = {{0.0, 1.0}, {0.1, 0.9}, {0.4, 0.6}, {1.0 / 3.0, 2.0 / 3.0}, {0.999, 1.0}};
  const asc_light sun = {.kind = ASC_LIGHT_DIRECTIONAL, .place = {0.1, 0.2, -1}, .intensity = {1, 1, 1}};
  const asc_sampler_desc pattern = {sizeof pattern, "sobol:scramble=owen", 16, 3, 7};
  asc_sampler *sampler = NULL;
  assert_int_equal(asc_sampler_create(&pattern, &sampler, NULL), ASC_OK);
  for (size_t k = 0; k < sizeof shutters / sizeof *shutters; k++) {
    static float kept[H][W][3], gone[H][W][3];
    filming made;
    tracer *first = NULL, *second = NULL;
    begin(&made, shutters[k][0], shutters[k][1]);
    made.white.albedo[0] = 0.5;
    made.scene.lights = &sun;
    made.scene.light_count = 1;
    assert_int_equal(tracer_create(&made.scene, &first, NULL), ASC_OK);
    assert_int_equal(tracer_create(&made.scene, &second, NULL), ASC_OK);
    assert_int_equal(tracer_dimensions(first), 3);
    const tracer_desc desc = {.struct_size = sizeof desc, .sampler = sampler, .threads = 1};
    assert_int_equal(tracer_render(first, &desc, &kept[0][0][0], NULL, NULL), ASC_OK);
    memset(&made, 0xff, sizeof made);
    assert_int_equal(tracer_render(second, &desc, &gone[0][0][0], NULL, NULL), ASC_OK);
    assert_memory_equal(kept, gone, sizeof kept);
    tracer_destroy(first);
    tracer_destroy(second);
  }
  asc_sampler_destroy(sampler);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_cannot_be_is_refused),
      cmocka_unit_test(frames_are_copied),
  };
  return cmocka_run_group_tests_name("tracer_frames", tests, NULL, NULL);
}

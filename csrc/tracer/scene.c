/* Surfaces: moved to the camera in double, kept in double where shading needs the point; geometry.c hands them to
 * Embree. */
#include <stdlib.h>
#include <string.h>

#include "frames.h"
#include "geometry.h"
#include "meeting.h"

#define WHOLE_TURN (2.0 * 3.14159265358979323846 * (1.0 + 1e-12)) /* given in degrees, it is rounded */

/* Copies the materials of one kind of primitive. */
static asc_status take_indices(tracer *made, int kind, const void *first, size_t stride, size_t count,
                               asc_error *error) {
  made->material_of[kind] = malloc((count + 1) * sizeof(uint32_t));
  if (!made->material_of[kind]) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < count; i++) {
    uint32_t index;
    memcpy(&index, (const char *)first + i * stride, sizeof index);
    if (index >= made->material_count)
      return asc_fail(error, ASC_INVALID_ARGUMENT, "a surface names material %u of %zu", index, made->material_count);
    made->material_of[kind][i] = index;
  }
  return ASC_OK;
}

plane plane_of(const double corner[3][3]) {
  double a[3], b[3];
  for (int i = 0; i < 3; i++) {
    a[i] = corner[1][i] - corner[0][i];
    b[i] = corner[2][i] - corner[0][i];
  }
  plane made = {.offset = 0.0};
  cross(a, b, made.normal);
  const double length = sqrt(dot(made.normal, made.normal));
  for (int i = 0; i < 3; i++) made.normal[i] /= length > 0.0 ? length : 1.0; /* without area it is never met */
  made.offset = dot(made.normal, corner[0]);
  return made;
}

static asc_status take_triangles(tracer *made, const asc_scene *scene, asc_error *error) {
  const size_t count = scene->triangle_count;
  if (count == 0) return ASC_OK;
  asc_status status =
      take_indices(made, TRIANGLES, scene->triangle_material, sizeof *scene->triangle_material, count, error);
  if (status) return status;
  if (!made->plain) made->triangle_planes = malloc(count * sizeof *made->triangle_planes);
  if (!made->plain && !made->triangle_planes)
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu triangles", count);
  for (size_t i = 0; i < count; i++) {
    double corner[3][3];
    for (size_t k = 0; k < 3; k++) {
      const double *world = scene->vertices + 9 * i + 3 * k;
      if (!finite3(world))
        return asc_fail(error, ASC_INVALID_ARGUMENT, "triangle %zu has a corner that is not finite", i);
      tracer_to_camera(&made->view, world, corner[k]);
    }
    if (!made->plain) made->triangle_planes[i] = plane_of((const double(*)[3])corner);
  }
  return geometry_take(made, scene, TRIANGLES, count, error);
}

static asc_status take_discs(tracer *made, const asc_scene *scene, asc_error *error) {
  const size_t count = scene->disc_count;
  if (count == 0) return ASC_OK;
  asc_status status = take_indices(made, DISCS, &scene->discs[0].material, sizeof(asc_disc), count, error);
  if (status) return status;
  made->disc_planes = malloc(count * sizeof *made->disc_planes);
  made->disc_balls = calloc(count, sizeof *made->disc_balls);
  made->least_lift[DISCS] = malloc(count * sizeof(double));
  if (!made->disc_planes || !made->disc_balls || !made->least_lift[DISCS])
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu discs", count);
  for (size_t i = 0; i < count; i++) {
    const asc_disc *disc = &scene->discs[i];
    double centre[3], normal[3];
    tracer_to_camera(&made->view, disc->centre, centre);
    tracer_to_camera_direction(&made->view, disc->normal, normal);
    const double length = sqrt(dot(normal, normal));
    if (!finite3(centre) || !(length > 0.0) || !isfinite(length) || !(disc->radius > 0.0) || !isfinite(disc->radius))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "disc %zu is not finite, or has no radius or normal", i);
    plane *facing = &made->disc_planes[i];
    for (size_t axis = 0; axis < 3; axis++) facing->normal[axis] = normal[axis] / length;
    facing->offset = dot(facing->normal, centre);
    memcpy(made->disc_balls[i].centre, centre, sizeof centre);
    made->disc_balls[i].radius = disc->radius;
    made->least_lift[DISCS][i] = meeting_least_lift(centre, 2.0 * disc->radius); /* Embree has a triangle about it */
  }
  return geometry_take(made, scene, DISCS, count, error);
}

static asc_status take_spheres(tracer *made, const asc_scene *scene, const double *powers, asc_error *error) {
  const size_t count = scene->sphere_count;
  if (count == 0) return ASC_OK;
  asc_status status = take_indices(made, SPHERES, &scene->spheres[0].material, sizeof(asc_sphere), count, error);
  if (status) return status;
  made->balls = calloc(count, sizeof *made->balls);
  made->least_lift[SPHERES] = malloc(count * sizeof(double));
  if (!made->balls || !made->least_lift[SPHERES])
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu spheres", count);
  for (size_t i = 0; i < count; i++) {
    ball *made_ball = &made->balls[i];
    tracer_to_camera(&made->view, scene->spheres[i].centre, made_ball->centre);
    made_ball->radius = scene->spheres[i].radius;
    made_ball->power = powers[i];
    made->least_lift[SPHERES][i] = meeting_least_lift(made_ball->centre, made_ball->radius);
    if (!finite3(made_ball->centre) || !(made_ball->radius > 0.0) || !isfinite(made_ball->radius))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "sphere %zu is not finite, or has no radius", i);
  }
  return geometry_take(made, scene, SPHERES, count, error);
}

static asc_status take_planes(tracer *made, const asc_scene *scene, asc_error *error) {
  const size_t count = scene->plane_count;
  if (count == 0) return ASC_OK;
  asc_status status = take_indices(made, PLANES, &scene->planes[0].material, sizeof(asc_plane), count, error);
  if (status) return status;
  made->plane_count = count;
  made->planes = malloc(count * sizeof *made->planes);
  if (!made->planes) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < count; i++) {
    plane *endless = &made->planes[i];
    double point[3];
    tracer_to_camera(&made->view, scene->planes[i].point, point);
    tracer_to_camera_direction(&made->view, scene->planes[i].normal, endless->normal);
    const double length = sqrt(dot(endless->normal, endless->normal));
    if (!finite3(point) || !(length > 0.0) || !isfinite(length))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "plane %zu is not finite, or has no normal", i);
    for (int axis = 0; axis < 3; axis++) endless->normal[axis] /= length;
    endless->offset = dot(endless->normal, point);
  }
  return ASC_OK;
}

static asc_status take_motion_of(tracer *made, int kind, const uint32_t *motions, size_t count, asc_error *error) {
  if (!motions || count == 0) return ASC_OK;
  made->motion_of[kind] = calloc(count, sizeof *made->motion_of[kind]);
  if (!made->motion_of[kind]) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < count; i++) {
    if (motions[i] > made->motion_count)
      return asc_fail(error, ASC_INVALID_ARGUMENT, "a surface names motion %u of %zu", motions[i], made->motion_count);
    if (motions[i] > 0) made->motion_of[kind][i] = &made->motions[motions[i] - 1];
  }
  return ASC_OK;
}

asc_status tracer_take_motions(tracer *made, const asc_scene *scene, asc_error *error) {
  const asc_view *view = &made->view;
  if (scene->motion_count == 0) return ASC_OK;
  if (!(view->shutter_open < view->shutter_close))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "surfaces move, and the shutter is open for no time");
  made->motions = calloc(scene->motion_count, sizeof *made->motions);
  if (!made->motions) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  made->motion_count = scene->motion_count;
  for (size_t i = 0; i < scene->motion_count; i++) {
    const asc_motion *world = &scene->motions[i];
    asc_motion *motion = &made->motions[i];
    *motion = *world;
    tracer_to_camera_direction(view, world->by, motion->by);
    tracer_to_camera_direction(view, world->axis, motion->axis);
    tracer_to_camera(view, world->centre, motion->centre);
    motion->angle = -world->angle; /* x right, y up, z forward is left-handed */
    const double length = sqrt(dot(motion->axis, motion->axis));
    const int turns = motion->kind == ASC_MOTION_ROTATE;
    if (motion->kind != ASC_MOTION_TRANSLATE && motion->kind != ASC_MOTION_FRAMES && !turns)
      return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu has an unknown kind, %d", i, (int)motion->kind);
    if (!finite3(motion->by) || !finite3(motion->centre) || !isfinite(motion->angle) || !isfinite(length) ||
        (turns && !(length > 0.0)))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu is not finite, or has no axis", i);
    for (int axis = 0; axis < 3 && turns; axis++) motion->axis[axis] /= length;
    if (turns && !(fabs(motion->angle) * (view->shutter_close - view->shutter_open) <= WHOLE_TURN))
      return asc_fail(error, ASC_UNSUPPORTED, "motion %zu turns by more than 360 degrees while the shutter is open", i);
  }
  asc_status status = take_motion_of(made, TRIANGLES, scene->triangle_motion, scene->triangle_count, error);
  if (status == ASC_OK) status = take_motion_of(made, DISCS, scene->disc_motion, scene->disc_count, error);
  if (status == ASC_OK) status = take_motion_of(made, SPHERES, scene->sphere_motion, scene->sphere_count, error);
  if (status == ASC_OK) status = take_motion_of(made, PLANES, scene->plane_motion, scene->plane_count, error);
  if (status == ASC_OK) status = frames_take(made, scene, error);
  return status;
}

asc_status tracer_take_geometry(tracer *made, const relative_scene *local, asc_error *error) {
  const asc_scene *scene = &local->scene;
  made->scene = rtcNewScene(made->device);
  if (!made->scene) return asc_fail(error, ASC_UNAVAILABLE, "Embree made no scene");
  /* Robust: rays along an edge that two triangles share must not slip between them. */
  rtcSetSceneFlags(made->scene, made->options.not_robust ? RTC_SCENE_FLAG_NONE : RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(made->scene, RTC_BUILD_QUALITY_HIGH);
  asc_status status = take_triangles(made, scene, error);
  if (status == ASC_OK) status = take_discs(made, scene, error);
  if (status == ASC_OK) status = take_spheres(made, scene, local->powers, error);
  if (status == ASC_OK) status = take_planes(made, scene, error);
  if (status) return status;
  const double begun = tracer_thread_cpu_seconds();
  rtcCommitScene(made->scene);
  made->build_cpu_seconds = tracer_thread_cpu_seconds() - begun;
  const enum RTCError failed = rtcGetDeviceError(made->device);
  if (failed != RTC_ERROR_NONE)
    return asc_fail(error, failed == RTC_ERROR_OUT_OF_MEMORY ? ASC_OUT_OF_MEMORY : ASC_UNAVAILABLE,
                    "Embree could not build the scene (its error %d)", (int)failed);
  return ASC_OK;
}

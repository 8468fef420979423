#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static int finite3(const double v[3]) { return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]); }

static void to_camera_direction(const asc_view *view, const double world[3], double camera[3]) {
  camera[0] = dot(world, view->right);
  camera[1] = dot(world, view->up);
  camera[2] = dot(world, view->forward);
}

static void to_camera(const asc_view *view, const double world[3], double camera[3]) {
  const double moved[3] = {world[0] - view->eye[0], world[1] - view->eye[1], world[2] - view->eye[2]};
  to_camera_direction(view, moved, camera);
}

static asc_status check_view(const asc_view *view, asc_error *error) {
  if (view->width < 1 || view->height < 1 || view->width > 16384 || view->height > 16384)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a picture has 1 to 16384 pixels a side, not %u x %u", view->width,
                    view->height);
  if (!finite3(view->eye) || !finite3(view->right) || !finite3(view->up) || !finite3(view->forward) ||
      !finite3(view->background) || !(view->half_width > 0.0) || !(view->half_height > 0.0) ||
      !isfinite(view->half_width) || !isfinite(view->half_height))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the view has a number that is not finite, or no extent");
  return ASC_OK;
}

asc_status tracer_take_materials(tracer *made, const asc_scene *scene, asc_error *error) {
  asc_status status = check_view(&scene->view, error);
  if (status) return status;
  made->view = scene->view;
  made->material_count = scene->material_count;
  made->materials = calloc(scene->material_count + 1, sizeof *made->materials);
  if (!made->materials) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < scene->material_count; i++) {
    asc_material *material = &made->materials[i];
    *material = scene->materials[i];
    const asc_pattern *pattern = &scene->materials[i].pattern;
    if (!finite3(material->emission) || !finite3(pattern->origin) || !finite3(pattern->low) ||
        !finite3(pattern->high) || !isfinite(pattern->scale))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has a number that is not finite", i);
    if (pattern->kind == ASC_PATTERN_NONE) continue;
    made->patterned = 1;
    to_camera(&made->view, pattern->origin, material->pattern.origin);
  }
  return ASC_OK;
}

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

static void *shared_buffer(RTCGeometry geometry, enum RTCBufferType type, enum RTCFormat format, size_t stride,
                           size_t count) {
  return rtcSetNewGeometryBuffer(geometry, type, 0, format, stride, count);
}

static void attach(tracer *made, RTCGeometry geometry, unsigned id) {
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(made->scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

/* The plane through a triangle's corners, in the camera frame. */
static plane plane_of(const double corner[3][3]) {
  double a[3], b[3];
  for (int i = 0; i < 3; i++) {
    a[i] = corner[1][i] - corner[0][i];
    b[i] = corner[2][i] - corner[0][i];
  }
  plane made = {{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}, 0.0};
  made.offset = dot(made.normal, corner[0]);
  return made;
}

static asc_status take_triangles(tracer *made, const asc_scene *scene, asc_error *error) {
  const size_t count = scene->triangle_count;
  if (count == 0) return ASC_OK;
  asc_status status =
      take_indices(made, TRIANGLES, scene->triangle_material, sizeof *scene->triangle_material, count, error);
  if (status) return status;
  RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float *vertices = shared_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count);
  uint32_t *indices = shared_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), count);
  if (made->patterned) made->triangle_planes = malloc(count * sizeof *made->triangle_planes);
  if (!vertices || !indices || (made->patterned && !made->triangle_planes)) {
    rtcReleaseGeometry(geometry);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu triangles", count);
  }
  for (size_t i = 0; i < count; i++) {
    double corner[3][3];
    for (size_t k = 0; k < 3; k++) {
      const double *world = scene->vertices + 9 * i + 3 * k;
      if (!finite3(world)) {
        rtcReleaseGeometry(geometry);
        return asc_fail(error, ASC_INVALID_ARGUMENT, "triangle %zu has a corner that is not finite", i);
      }
      to_camera(&made->view, world, corner[k]);
      for (size_t axis = 0; axis < 3; axis++) vertices[9 * i + 3 * k + axis] = (float)corner[k][axis];
      indices[3 * i + k] = (uint32_t)(3 * i + k);
    }
    if (made->patterned) made->triangle_planes[i] = plane_of((const double(*)[3])corner);
  }
  attach(made, geometry, TRIANGLES);
  return ASC_OK;
}

static asc_status take_discs(tracer *made, const asc_scene *scene, asc_error *error) {
  const size_t count = scene->disc_count;
  if (count == 0) return ASC_OK;
  asc_status status = take_indices(made, DISCS, &scene->discs[0].material, sizeof(asc_disc), count, error);
  if (status) return status;
  RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_ORIENTED_DISC_POINT);
  float *points = shared_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 4 * sizeof(float), count);
  float *normals = shared_buffer(geometry, RTC_BUFFER_TYPE_NORMAL, RTC_FORMAT_FLOAT3, 3 * sizeof(float), count);
  made->disc_planes = malloc(count * sizeof *made->disc_planes);
  if (!points || !normals || !made->disc_planes) {
    rtcReleaseGeometry(geometry);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu discs", count);
  }
  for (size_t i = 0; i < count; i++) {
    const asc_disc *disc = &scene->discs[i];
    double centre[3], normal[3];
    to_camera(&made->view, disc->centre, centre);
    to_camera_direction(&made->view, disc->normal, normal);
    const double length = sqrt(dot(normal, normal));
    if (!finite3(centre) || !(length > 0.0) || !isfinite(length) || !(disc->radius > 0.0) || !isfinite(disc->radius)) {
      rtcReleaseGeometry(geometry);
      return asc_fail(error, ASC_INVALID_ARGUMENT, "disc %zu is not finite, or has no radius or normal", i);
    }
    plane *facing = &made->disc_planes[i];
    for (size_t axis = 0; axis < 3; axis++) {
      facing->normal[axis] = normal[axis] / length;
      points[4 * i + axis] = (float)centre[axis];
      normals[3 * i + axis] = (float)facing->normal[axis];
    }
    points[4 * i + 3] = (float)disc->radius;
    facing->offset = dot(facing->normal, centre);
  }
  attach(made, geometry, DISCS);
  return ASC_OK;
}

static asc_status take_spheres(tracer *made, const asc_scene *scene, asc_error *error) {
  const size_t count = scene->sphere_count;
  if (count == 0) return ASC_OK;
  asc_status status = take_indices(made, SPHERES, &scene->spheres[0].material, sizeof(asc_sphere), count, error);
  if (status) return status;
  RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
  float *points = shared_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT4, 4 * sizeof(float), count);
  made->balls = malloc(count * sizeof *made->balls);
  if (!points || !made->balls) {
    rtcReleaseGeometry(geometry);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu spheres", count);
  }
  for (size_t i = 0; i < count; i++) {
    ball *made_ball = &made->balls[i];
    to_camera(&made->view, scene->spheres[i].centre, made_ball->centre);
    made_ball->radius = scene->spheres[i].radius;
    if (!finite3(made_ball->centre) || !(made_ball->radius > 0.0) || !isfinite(made_ball->radius)) {
      rtcReleaseGeometry(geometry);
      return asc_fail(error, ASC_INVALID_ARGUMENT, "sphere %zu is not finite, or has no radius", i);
    }
    for (size_t axis = 0; axis < 3; axis++) points[4 * i + axis] = (float)made_ball->centre[axis];
    points[4 * i + 3] = (float)made_ball->radius;
  }
  attach(made, geometry, SPHERES);
  return ASC_OK;
}

asc_status tracer_take_geometry(tracer *made, const asc_scene *scene, asc_error *error) {
  made->scene = rtcNewScene(made->device);
  if (!made->scene) return asc_fail(error, ASC_UNAVAILABLE, "Embree made no scene");
  /* Robust: rays along an edge that two triangles share must not slip between them. */
  rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(made->scene, RTC_BUILD_QUALITY_HIGH);
  asc_status status = take_triangles(made, scene, error);
  if (status == ASC_OK) status = take_discs(made, scene, error);
  if (status == ASC_OK) status = take_spheres(made, scene, error);
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

static double along_plane(const plane *met, const double origin[3], const double direction[3]) {
  return (met->offset - dot(met->normal, origin)) / dot(met->normal, direction);
}

/* The nearer root, and without its cancellation: the distance to the foot of the centre's perpendicular first
 * (Haines et al. 2019, "Precision improvements for ray/sphere intersection"). */
static double along_ball(const ball *met, const double origin[3], const double direction[3]) {
  double to_centre[3], miss[3];
  for (int i = 0; i < 3; i++) to_centre[i] = met->centre[i] - origin[i];
  const double squared = dot(direction, direction);
  const double foot = dot(to_centre, direction) / squared;
  for (int i = 0; i < 3; i++) miss[i] = to_centre[i] - foot * direction[i];
  const double inside = met->radius * met->radius - dot(miss, miss);
  const double half_chord = sqrt((inside > 0.0 ? inside : 0.0) / squared);
  return foot - half_chord > 0.0 ? foot - half_chord : foot + half_chord;
}

void tracer_hit_point(const tracer *made, uint32_t geometry, uint32_t primitive, const double origin[3],
                      const double direction[3], double point[3]) {
  double t = 0.0;
  switch (geometry) {
  case TRIANGLES: t = along_plane(&made->triangle_planes[primitive], origin, direction); break;
  case DISCS: t = along_plane(&made->disc_planes[primitive], origin, direction); break;
  default: t = along_ball(&made->balls[primitive], origin, direction); break;
  }
  for (int i = 0; i < 3; i++) point[i] = origin[i] + t * direction[i];
}

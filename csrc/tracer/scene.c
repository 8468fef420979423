/* Surfaces: moved to the camera in double, handed to Embree as float, kept in double where shading needs the point. */
#include <stdlib.h>
#include <string.h>

#include "scene.h"

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
  RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  float *vertices = shared_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 3 * count);
  uint32_t *indices = shared_buffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), count);
  if (!made->plain) made->triangle_planes = malloc(count * sizeof *made->triangle_planes);
  if (!vertices || !indices || (!made->plain && !made->triangle_planes)) {
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
      tracer_to_camera(&made->view, world, corner[k]);
      for (size_t axis = 0; axis < 3; axis++) vertices[9 * i + 3 * k + axis] = (float)corner[k][axis];
      indices[3 * i + k] = (uint32_t)(3 * i + k);
    }
    if (!made->plain) made->triangle_planes[i] = plane_of((const double(*)[3])corner);
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
    tracer_to_camera(&made->view, disc->centre, centre);
    tracer_to_camera_direction(&made->view, disc->normal, normal);
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
    tracer_to_camera(&made->view, scene->spheres[i].centre, made_ball->centre);
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

asc_status tracer_take_geometry(tracer *made, const asc_scene *scene, asc_error *error) {
  made->scene = rtcNewScene(made->device);
  if (!made->scene) return asc_fail(error, ASC_UNAVAILABLE, "Embree made no scene");
  /* Robust: rays along an edge that two triangles share must not slip between them. */
  rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(made->scene, RTC_BUILD_QUALITY_HIGH);
  asc_status status = take_triangles(made, scene, error);
  if (status == ASC_OK) status = take_discs(made, scene, error);
  if (status == ASC_OK) status = take_spheres(made, scene, error);
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

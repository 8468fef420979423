#include "geometry.h"

#include <stdlib.h>
#include <string.h>

#include "frames.h"
#include "large.h"
#include "split.h"

#define SQRT_3 1.73205080756887729353

/* Some surfaces of a kind, which share a motion. */
typedef struct batch {
  uint32_t kind;
  const uint32_t *members; /* NULL: all, in their order */
  size_t count;
  const asc_motion *motion; /* NULL: none */
  const double *corners;    /* [count][3][3] of triangles in pieces, in the camera's frame; NULL: they are whole */
} batch;

static void *new_buffer(RTCGeometry geometry, enum RTCBufferType type, unsigned step, enum RTCFormat format,
                        size_t floats, size_t count) {
  return rtcSetNewGeometryBuffer(geometry, type, step, format, floats * sizeof(float), count);
}

static void put_point(const double at_rest[3], const placing *at, float *point) {
  double moved[3] = {at_rest[0], at_rest[1], at_rest[2]};
  if (at) motion_place(at, at_rest, moved);
  for (int i = 0; i < 3; i++) point[i] = (float)moved[i];
}

static int put_triangles(const tracer *made, const asc_scene *scene, const batch *of, RTCGeometry geometry,
                         unsigned step, const placing *at) {
  float *vertices = new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, 3, 3 * of->count);
  uint32_t *indices = step == 0 ? new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3, of->count) : NULL;
  if (!vertices || (step == 0 && !indices)) return 0;
  const mesh_frames *frames = frames_of(made, of->motion);
  for (size_t i = 0; i < 3 * of->count; i++) {
    const size_t number = of->members ? of->members[i / 3] : i / 3;
    double corner[3];
    if (of->corners)
      put_point(of->corners + 3 * i, NULL, vertices + 3 * i);
    else if (frames)
      put_point(frames->corners + 3 * (3 * of->count * step + i), NULL, vertices + 3 * i);
    else {
      tracer_to_camera(&made->view, scene->vertices + 9 * number + 3 * (i % 3), corner);
      put_point(corner, at, vertices + 3 * i);
    }
    if (indices) indices[i] = (uint32_t)i;
  }
  return 1;
}

/* A disc, as Embree is given it: the triangle about its circle, of which `keep_discs` leaves the disc. Embree's own
 * discs take rays at half the rate. */
static int put_discs(const tracer *made, const asc_scene *scene, const batch *of, RTCGeometry geometry, unsigned step,
                     const placing *at) {
  /* Where the corners lie, in radii. */
  static const double corners[3][2] = {{0.0, 2.0}, {-SQRT_3, -1.0}, {SQRT_3, -1.0}};
  float *vertices = new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT3, 3, 3 * of->count);
  uint32_t *indices = step == 0 ? new_buffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3, of->count) : NULL;
  if (!vertices || (step == 0 && !indices)) return 0;
  for (size_t i = 0; i < of->count; i++) {
    const size_t number = of->members ? of->members[i] : i;
    const double radius = scene->discs[number].radius;
    double centre[3], a[3], b[3];
    tracer_to_camera(&made->view, scene->discs[number].centre, centre);
    across(made->disc_planes[number].normal, a, b);
    for (size_t k = 0; k < 3; k++) {
      double corner[3];
      for (int axis = 0; axis < 3; axis++)
        corner[axis] = centre[axis] + radius * (corners[k][0] * a[axis] + corners[k][1] * b[axis]);
      put_point(corner, at, vertices + 9 * i + 3 * k);
      if (indices) indices[3 * i + k] = (uint32_t)(3 * i + k);
    }
  }
  return 1;
}

/* Drops what meets the triangle about a disc's circle, and not the disc. */
static void keep_discs(const struct RTCFilterFunctionNArguments *met) {
  /* Hits are rows of N: the normal's three, then u and v; Embree has functions for them in C++ alone. */
  const float *row_u = (const float *)met->hit + 3 * (size_t)met->N, *row_v = row_u + met->N;
  for (unsigned i = 0; i < met->N; i++) {
    const double u = (double)row_u[i], v = (double)row_v[i];
    const double x = SQRT_3 * (v - u), y = 2.0 - 3.0 * (u + v);
    if (x * x + y * y > 1.0) met->valid[i] = 0;
  }
}

static int put_spheres(const tracer *made, const asc_scene *scene, const batch *of, RTCGeometry geometry, unsigned step,
                       const placing *at) {
  float *points = new_buffer(geometry, RTC_BUFFER_TYPE_VERTEX, step, RTC_FORMAT_FLOAT4, 4, of->count);
  if (!points) return 0;
  for (size_t i = 0; i < of->count; i++) {
    const size_t number = of->members ? of->members[i] : i;
    double centre[3];
    tracer_to_camera(&made->view, scene->spheres[number].centre, centre);
    put_point(centre, at, points + 4 * i);
    points[4 * i + 3] = (float)scene->spheres[number].radius;
  }
  return 1;
}

static asc_status attach(tracer *made, const asc_scene *scene, const batch *of, unsigned id, asc_error *error) {
  static const enum RTCGeometryType types[] = {RTC_GEOMETRY_TYPE_TRIANGLE, RTC_GEOMETRY_TYPE_TRIANGLE,
                                               RTC_GEOMETRY_TYPE_SPHERE_POINT};
  static int (*const put[])(const tracer *, const asc_scene *, const batch *, RTCGeometry, unsigned,
                            const placing *) = {put_triangles, put_discs, put_spheres};
  RTCGeometry geometry = rtcNewGeometry(made->device, types[of->kind]);
  if (of->kind == DISCS) {
    rtcSetGeometryIntersectFilterFunction(geometry, keep_discs);
    rtcSetGeometryOccludedFilterFunction(geometry, keep_discs);
  }
  const asc_view *view = &made->view;
  const double open = view->shutter_open, duration = view->shutter_close - open;
  const mesh_frames *frames = frames_of(made, of->motion);
  const unsigned segments = frames       ? (unsigned)frames->count - 1
                            : of->motion ? (unsigned)motion_segments(of->motion, duration)
                                         : 0,
                 steps = segments + 1;
  if (of->motion) rtcSetGeometryTimeStepCount(geometry, steps);
  if (frames) {
    float begin, end;
    frames_time_range(made, frames, &begin, &end);
    rtcSetGeometryTimeRange(geometry, begin, end);
  }
  for (unsigned step = 0; step < steps; step++) {
    placing at;
    if (of->motion && !frames) at = motion_at(of->motion, open + duration * step / segments);
    const placing *placed = of->motion && !frames ? &at : NULL;
    const int done = put[of->kind](made, scene, of, geometry, step, placed);
    if (!done) {
      rtcReleaseGeometry(geometry);
      return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu surfaces in %u places", of->count, steps);
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(made->scene, geometry, id);
  rtcReleaseGeometry(geometry);
  return ASC_OK;
}

/* The surfaces of a kind that have one motion, or none; or all those that are met in double, which are asked for alone.
 */
static asc_status new_part(tracer *made, uint32_t kind, size_t count, const asc_motion *motion, int large,
                           size_t *members, asc_error *error) {
  part *grown = realloc(made->parts, (made->part_count + 1) * sizeof *grown);
  uint32_t *numbers = malloc(count * sizeof *numbers + 1);
  if (grown) made->parts = grown;
  if (!grown || !numbers) {
    free(numbers);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu surfaces", count);
  }
  for (uint32_t i = 0; i < count; i++)
    if (large_is(made, (surface){kind, i}) ? large : !large && tracer_motion(made, (surface){kind, i}) == motion)
      numbers[(*members)++] = i;
  made->parts[made->part_count++] = (part){kind, numbers};
  return ASC_OK;
}

static asc_status take_moving(tracer *made, const asc_scene *scene, uint32_t kind, size_t count,
                              const asc_motion *motion, asc_error *error) {
  size_t members = 0;
  asc_status status = new_part(made, kind, count, motion, 0, &members, error);
  if (status) return status;
  const unsigned id = (unsigned)made->part_count - 1;
  if (members == 0) {
    free(made->parts[id].members);
    made->part_count--;
    return ASC_OK;
  }
  const batch of = {.kind = kind, .members = made->parts[id].members, .count = members, .motion = motion};
  return attach(made, scene, &of, id, error);
}

static asc_status take_large(tracer *made, uint32_t kind, size_t count, asc_error *error) {
  size_t members = 0;
  asc_status status = new_part(made, kind, count, NULL, 1, &members, error);
  if (status == ASC_OK) large_attach(made, (uint32_t)made->part_count - 1, members);
  return status;
}

/* One part for each of Embree's kinds, where nothing moves. */
static int begin_parts(tracer *made) {
  if (made->parts) return 1;
  made->parts = calloc(PLANES, sizeof *made->parts);
  if (!made->parts) return 0;
  made->part_count = PLANES;
  for (uint32_t kind = 0; kind < PLANES; kind++) made->parts[kind].kind = kind;
  return 1;
}

/* Triangles that stand still, some of them perhaps in pieces. */
static asc_status take_pieces(tracer *made, const asc_scene *scene, const pieces *cut, asc_error *error) {
  const int begun = begin_parts(made);
  uint32_t *members = malloc(cut->count * sizeof *members);
  if (!begun || !members) {
    free(members);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu pieces of triangles", cut->count);
  }
  memcpy(members, cut->owner, cut->count * sizeof *members);
  made->parts[TRIANGLES].members = members;
  const batch all = {.kind = TRIANGLES, .count = cut->count, .corners = cut->corners};
  return attach(made, scene, &all, TRIANGLES, error);
}

/* Balls or discs of a scene in which nothing moves, some of which are met in double. */
static asc_status take_still(tracer *made, const asc_scene *scene, uint32_t kind, size_t count, size_t large,
                             asc_error *error) {
  uint32_t *members = malloc((count - large) * sizeof *members + 1);
  if (!begin_parts(made) || !members) {
    free(members);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu surfaces", count);
  }
  made->parts[kind].members = members;
  size_t others = 0;
  for (uint32_t i = 0; i < count; i++)
    if (!large_is(made, (surface){kind, i})) members[others++] = i;
  const batch rest = {.kind = kind, .members = members, .count = others};
  const asc_status status = others > 0 ? attach(made, scene, &rest, kind, error) : ASC_OK;
  return status ? status : take_large(made, kind, count, error);
}

asc_status geometry_take(tracer *made, const asc_scene *scene, uint32_t kind, size_t count, asc_error *error) {
  if (made->motion_count == 0 && kind == TRIANGLES) {
    pieces cut;
    asc_status status = split_triangles(made, scene, &cut, error);
    if (status == ASC_OK && cut.count > 0) {
      status = take_pieces(made, scene, &cut, error);
      split_free(&cut);
      return status;
    }
    if (status) return status;
  }
  const size_t large = large_mark(made, kind, count);
  if (made->motion_count == 0) {
    const batch all = {.kind = kind, .count = count};
    return large > 0 ? take_still(made, scene, kind, count, large, error) : attach(made, scene, &all, kind, error);
  }
  asc_status status = take_moving(made, scene, kind, count, NULL, error);
  for (size_t i = 0; i < made->motion_count && status == ASC_OK; i++)
    status = take_moving(made, scene, kind, count, &made->motions[i], error);
  return status == ASC_OK && large > 0 ? take_large(made, kind, count, error) : status;
}

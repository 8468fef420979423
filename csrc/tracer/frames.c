#include "frames.h"

#include <float.h>
#include <stdlib.h>

/* In frames. Embree has times in float, as shares of the open shutter: of one that is much shorter than what it is
 * given of the motion they lose their digits (3.13 then fails at an assertion). */
#define LEAST_ACROSS (1.0 / 1024.0)

static size_t count_members(const tracer *made, const asc_motion *motion, size_t triangles) {
  size_t members = 0;
  for (uint32_t i = 0; i < triangles; i++) members += tracer_motion(made, (surface){TRIANGLES, i}) == motion;
  return members;
}

static asc_status check(const tracer *made, const asc_scene *scene, size_t number, asc_error *error) {
  const asc_motion *motion = &made->motions[number];
  const size_t members = count_members(made, motion, scene->triangle_count);
  if (!motion->frames || motion->frame_count < 1 || motion->frame_count > FRAMES_MOST)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu has 1 to %d frames after the first, not %zu", number,
                    FRAMES_MOST, motion->frame_count);
  if (motion->frame_triangles != members)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu has frames of %zu triangles, and %zu triangles name it",
                    number, motion->frame_triangles, members);
  if (made->view.shutter_open < 0.0 || made->view.shutter_close > 1.0)
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "motion %zu has frames from time 0 to 1, and the shutter is open at "
                    "another",
                    number);
  for (size_t i = 0; i < 3 * motion->frame_count * members; i++)
    if (!finite3(motion->frames + 3 * i))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu has a corner that is not finite", number);
  for (int kind = DISCS; kind < GEOMETRY_KINDS; kind++) {
    const size_t counts[GEOMETRY_KINDS] = {0, scene->disc_count, scene->sphere_count, scene->plane_count};
    for (uint32_t i = 0; i < counts[kind]; i++)
      if (tracer_motion(made, (surface){(uint32_t)kind, i}) == motion)
        return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu has frames, and a surface that is no triangle",
                        number);
  }
  return ASC_OK;
}

/* A corner at a frame, 0 being the scene's own vertices, in the camera's frame. */
static void corner_at(const tracer *made, const asc_scene *scene, const asc_motion *motion, size_t frame,
                      const uint32_t *numbers, size_t corner, double placed[3]) {
  const double *world = frame == 0 ? scene->vertices + 9 * (size_t)numbers[corner / 3] + 3 * (corner % 3)
                                   : motion->frames + 3 * ((frame - 1) * 3 * motion->frame_triangles + corner);
  tracer_to_camera(&made->view, world, placed);
}

/* Which frames are needed: all from the last before the shutter opens to the first after it has closed. */
static void choose(const asc_view *view, size_t last, size_t *from, size_t *to) {
  *from = (size_t)fmin(floor(view->shutter_open * (double)last), (double)last - 1.0);
  *to = (size_t)fmin(ceil(view->shutter_close * (double)last), (double)last);
  if (*to <= *from) *to = *from + 1; /* a product was rounded to a whole number */
}

static asc_status fill(const tracer *made, const asc_scene *scene, const asc_motion *motion, mesh_frames *into,
                       asc_error *error) {
  const asc_view *view = &made->view;
  const size_t last = motion->frame_count, corners = 3 * motion->frame_triangles;
  size_t from, to;
  choose(view, last, &from, &to);
  const int between = to == from + 1;
  if (!between && (view->shutter_close - view->shutter_open) * (double)last < LEAST_ACROSS)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "the shutter is open across a frame of a mesh for less than 1/1024 of the time between two: open "
                    "it for longer, or beside the frame");
  into->triangles = motion->frame_triangles;
  into->count = to - from + 1;
  into->begin = between ? view->shutter_open : (double)from / (double)last;
  into->end = between ? view->shutter_close : (double)to / (double)last;
  into->corners = malloc((into->count * corners * 3 + 1) * sizeof(double));
  into->rest = malloc((corners * 3 + 1) * sizeof(double));
  uint32_t *numbers = calloc(into->triangles + 1, sizeof *numbers);
  if (!into->corners || !into->rest || !numbers) {
    free(numbers);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu frames of %zu triangles", into->count,
                    into->triangles);
  }
  size_t found = 0;
  for (uint32_t i = 0; i < scene->triangle_count; i++)
    if (tracer_motion(made, (surface){TRIANGLES, i}) == motion) numbers[found++] = i;
  for (size_t corner = 0; corner < corners; corner++) {
    corner_at(made, scene, motion, 0, numbers, corner, into->rest + 3 * corner);
    for (size_t frame = 0; frame < into->count; frame++)
      corner_at(made, scene, motion, from + frame, numbers, corner, into->corners + 3 * (frame * corners + corner));
    for (size_t i = 0; i < 3 && between; i++) {
      double *first = into->corners + 3 * corner + i, *second = first + 3 * corners;
      const double at[2] = {*first, *second};
      const double opening = view->shutter_open * (double)last - (double)from;
      const double closing = view->shutter_close * (double)last - (double)from;
      *first = (1.0 - opening) * at[0] + opening * at[1];
      *second = (1.0 - closing) * at[0] + closing * at[1];
    }
  }
  free(numbers);
  return ASC_OK;
}

asc_status frames_take(tracer *made, const asc_scene *scene, asc_error *error) {
  int any = 0;
  for (size_t i = 0; i < made->motion_count; i++) any |= made->motions[i].kind == ASC_MOTION_FRAMES;
  if (!any) return ASC_OK;
  made->frames = calloc(made->motion_count, sizeof *made->frames);
  made->frame_member = calloc(scene->triangle_count + 1, sizeof *made->frame_member);
  if (!made->frames || !made->frame_member) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < made->motion_count; i++) {
    const asc_motion *motion = &made->motions[i];
    if (motion->kind != ASC_MOTION_FRAMES) continue;
    asc_status status = check(made, scene, i, error);
    if (status == ASC_OK) status = fill(made, scene, motion, &made->frames[i], error);
    if (status) return status;
    uint32_t member = 0;
    for (uint32_t triangle = 0; triangle < scene->triangle_count; triangle++)
      if (tracer_motion(made, (surface){TRIANGLES, triangle}) == motion) made->frame_member[triangle] = member++;
  }
  return ASC_OK;
}

void frames_free(tracer *made) {
  for (size_t i = 0; i < made->motion_count && made->frames; i++) {
    free(made->frames[i].corners);
    free(made->frames[i].rest);
  }
  free(made->frames);
  free(made->frame_member);
}

void frames_time_range(const tracer *made, const mesh_frames *of, float *begin, float *end) {
  const double open = made->view.shutter_open, duration = made->view.shutter_close - open;
  /* Beyond its range a geometry is not there: no rounding may leave a part of the shutter out. */
  *begin = (float)fmin((of->begin - open) / duration, 0.0);
  *end = (float)fmax((of->end - open) / duration, 1.0);
}

/* The weight of the corner across from the side from a to b, times the triangle's doubled area. */
static double weight(const double normal[3], const double a[3], const double b[3], const double point[3]) {
  double side[3], away[3], turned[3];
  for (int i = 0; i < 3; i++) {
    side[i] = b[i] - a[i];
    away[i] = point[i] - a[i];
  }
  cross(side, away, turned);
  return dot(normal, turned);
}

/* The corners at a time, and the largest coordinate that Embree interpolates between. */
static double corners_at(const mesh_frames *of, size_t member, double time, double corner[3][3]) {
  const double segments = (double)(of->count - 1);
  const double along = segments * (time - of->begin) / (of->end - of->begin);
  const double before = fmin(fmax(floor(along), 0.0), segments - 1.0), share = along - before;
  const double *first = of->corners + 9 * ((size_t)before * of->triangles + member),
               *second = first + 9 * of->triangles;
  double largest = 0.0;
  for (int i = 0; i < 9; i++) {
    corner[i / 3][i % 3] = (1.0 - share) * first[i] + share * second[i];
    largest = fmax(largest, fmax(fabs(first[i]), fabs(second[i])));
  }
  return largest;
}

double frames_meet(const tracer *made, uint32_t triangle, double time, const double origin[3],
                   const double direction[3], double normal[3], double rest[3], double *slack) {
  const mesh_frames *of = frames_of(made, tracer_motion(made, (surface){TRIANGLES, triangle}));
  const size_t member = made->frame_member[triangle];
  double corner[3][3], point[3];
  *slack = 8.0 * FLT_EPSILON * corners_at(of, member, time, corner);
  plane at = plane_of((const double(*)[3])corner);
  if (dot(at.normal, at.normal) == 0.0) { /* it has just collapsed, and was met by a rounding: it faces the ray */
    const double length = sqrt(dot(direction, direction));
    for (int i = 0; i < 3; i++) at.normal[i] = -direction[i] / length;
    at.offset = dot(at.normal, corner[0]);
  }
  const double t = (at.offset - dot(at.normal, origin)) / dot(at.normal, direction);
  for (int i = 0; i < 3; i++) {
    normal[i] = at.normal[i];
    point[i] = origin[i] + t * direction[i];
  }
  const double first = weight(normal, corner[1], corner[2], point),
               second = weight(normal, corner[2], corner[0], point),
               third = weight(normal, corner[0], corner[1], point), sum = first + second + third;
  const double *still = of->rest + 9 * member;
  for (int i = 0; i < 3; i++)
    rest[i] = sum > 0.0 ? (first * still[i] + second * still[3 + i] + third * still[6 + i]) / sum : still[i];
  return t;
}

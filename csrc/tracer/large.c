#include "large.h"

#include <string.h>

/* At so many times the distance Embree's surface is off by 2^-16 of it, 1/20 of a pixel where 1,000 of them make a
 * right angle; and what is not seen from next to its surface stays Embree's. */
#define RATIO 256.0

/* A box is wider than what it holds by so much of the largest of its numbers, which are rounded to float, as rays are.
 */
#define WIDER 0x1p-18

/* Embree's tables for packets of N rays: rows of N numbers of four bytes. It has functions for them in C++ alone. */
enum { ORIGIN = 0, TNEAR = 3, DIRECTION = 4, TIME = 7, TFAR = 8, PRIMITIVE = 17, GEOMETRY = 18, INSTANCE = 19 };

static double time_of(const asc_view *view, double moment) {
  return view->shutter_open + (view->shutter_close - view->shutter_open) * moment;
}

/* From the eye, or of an orthographic view from its middle ray, and then not below what is seen all at once. */
static double distance_in(const tracer *made, double distance) {
  const asc_view *view = &made->view;
  return view->projection == ASC_ORTHOGRAPHIC ? larger(distance, larger(view->half_width, view->half_height))
                                              : distance;
}

/* Of the part that does not depend on the ray the exact value is known; what is left to round is of the size of the
 * origin, not of the ball. */
static double power_at(const ball *of, const double origin[3]) {
  return of->power - 2.0 * dot(of->centre, origin) + dot(origin, origin);
}

static double distance_of_ball(const ball *of, const double origin[3]) {
  double away[3];
  for (int i = 0; i < 3; i++) away[i] = of->centre[i] - origin[i];
  return fabs(power_at(of, origin)) / (sqrt(dot(away, away)) + of->radius);
}

static double distance_of_disc(const plane *facing, const ball *about, const double origin[3]) {
  const double over = facing->offset - dot(facing->normal, origin);
  double aside[3];
  for (int i = 0; i < 3; i++) aside[i] = about->centre[i] - origin[i] - over * facing->normal[i];
  const double beyond = larger(sqrt(dot(aside, aside)) - about->radius, 0.0);
  return sqrt(beyond * beyond + over * over);
}

/* At a time, as a share of the open shutter. */
static double distance_then(const tracer *made, surface of, double moment) {
  const asc_view *view = &made->view;
  const double eye[3] = {0.0}, way[3] = {0.0};
  double origin[3] = {0.0}, turned[3];
  if (tracer_motion(made, of)) {
    const placing at = motion_at(tracer_motion(made, of), time_of(view, moment));
    motion_ray_to_rest(&at, eye, way, origin, turned);
  }
  return of.kind == SPHERES ? distance_of_ball(&made->balls[of.number], origin)
                            : distance_of_disc(&made->disc_planes[of.number], &made->disc_balls[of.number], origin);
}

static int is_large(const tracer *made, surface of, double radius) {
  for (int k = 0; k < 3; k++)
    if (RATIO * distance_in(made, distance_then(made, of, 0.5 * k)) < radius) return 1;
  return 0;
}

size_t large_mark(tracer *made, uint32_t kind, size_t count) {
  size_t marked = 0;
  if (made->options.not_relative || (kind != SPHERES && kind != DISCS)) return 0;
  ball *balls = kind == SPHERES ? made->balls : made->disc_balls;
  for (uint32_t i = 0; i < count; i++) {
    balls[i].large = is_large(made, (surface){kind, i}, balls[i].radius);
    if (balls[i].large) made->least_lift[kind][i] = 0.0;
    marked += (size_t)balls[i].large;
  }
  return marked;
}

/* The quadratic |o + t d - c|^2 = r^2; the nearer root as the quotient by the farther one. */
int large_roots(const ball *of, const double origin[3], const double direction[3], double roots[2]) {
  double to_centre[3];
  for (int i = 0; i < 3; i++) to_centre[i] = of->centre[i] - origin[i];
  const double squared = dot(direction, direction), toward = dot(to_centre, direction);
  const double power = power_at(of, origin);
  const double inside = toward * toward - squared * power;
  if (!(inside > 0.0)) {
    roots[0] = roots[1] = toward / squared;
    return 0;
  }
  const double farther = toward + copysign(sqrt(inside), toward);
  const double one = power / farther, other = farther / squared;
  roots[0] = one < other ? one : other;
  roots[1] = larger(one, other);
  return 1;
}

/* --- Embree's user geometry -----------------------------------------------------------------------------------------
 */

/* Where between two distances a ray first meets a surface; -1: nowhere. */
static double meet_between(const tracer *made, surface of, const double origin[3], const double direction[3],
                           double near, double far) {
  if (of.kind == SPHERES) {
    double roots[2];
    if (!large_roots(&made->balls[of.number], origin, direction, roots)) return -1.0;
    for (int i = 0; i < 2; i++)
      if (roots[i] > near && roots[i] <= far) return roots[i];
    return -1.0;
  }
  const plane *facing = &made->disc_planes[of.number];
  const ball *about = &made->disc_balls[of.number];
  const double along = dot(facing->normal, direction);
  if (along == 0.0) return -1.0;
  const double t = (facing->offset - dot(facing->normal, origin)) / along;
  double from_centre[3];
  for (int i = 0; i < 3; i++) from_centre[i] = origin[i] + t * direction[i] - about->centre[i];
  const int within = dot(from_centre, from_centre) <= about->radius * about->radius;
  return within && t > near && t <= far ? t : -1.0;
}

/* The same along a ray of Embree's, with what moves at the ray's own time, not at a place between two. */
static double meet_lane(const large_surfaces *among, uint32_t primitive, const float *rays, size_t width, size_t lane) {
  double origin[3], direction[3];
  const float *ray = rays + lane;
  for (size_t i = 0; i < 3; i++) {
    origin[i] = (double)ray[(ORIGIN + i) * width];
    direction[i] = (double)ray[(DIRECTION + i) * width];
  }
  const tracer *made = among->made;
  const surface of = tracer_surface(made, among->id, primitive);
  const double near = (double)ray[TNEAR * width], far = (double)ray[TFAR * width];
  const asc_motion *motion = tracer_motion(made, of);
  if (!motion) return meet_between(made, of, origin, direction, near, far);
  const placing at = motion_at(motion, time_of(&made->view, (double)ray[TIME * width]));
  double rest_origin[3], rest_direction[3];
  motion_ray_to_rest(&at, origin, direction, rest_origin, rest_direction);
  return meet_between(made, of, rest_origin, rest_direction, near, far);
}

static void find_closest(const struct RTCIntersectFunctionNArguments *asked) {
  float *rays = (float *)asked->rayhit;
  uint32_t *words = (uint32_t *)asked->rayhit;
  const size_t width = asked->N;
  for (size_t lane = 0; lane < width; lane++) {
    if (!asked->valid[lane]) continue;
    const double t = meet_lane(asked->geometryUserPtr, asked->primID, rays, width, lane);
    if (t < 0.0) continue;
    rays[TFAR * width + lane] = (float)t;
    words[PRIMITIVE * width + lane] = asked->primID;
    words[GEOMETRY * width + lane] = asked->geomID;
    words[INSTANCE * width + lane] = asked->context->instID[0];
  }
}

static void find_any(const struct RTCOccludedFunctionNArguments *asked) {
  float *rays = (float *)asked->ray;
  const size_t width = asked->N;
  for (size_t lane = 0; lane < width; lane++) {
    if (!asked->valid[lane]) continue;
    if (meet_lane(asked->geometryUserPtr, asked->primID, rays, width, lane) >= 0.0)
      rays[TFAR * width + lane] = -INFINITY;
  }
}

/* A box that holds a ball at all times: of what turns, at all angles. */
static void hold(const tracer *made, const asc_motion *motion, const ball *about, double low[3], double high[3]) {
  const double *centre = about->centre;
  double radius = about->radius, middle[3] = {centre[0], centre[1], centre[2]}, by[3] = {0.0};
  if (motion && motion->kind == ASC_MOTION_TRANSLATE)
    memcpy(by, motion->by, sizeof by);
  else if (motion) {
    double out[3];
    for (int i = 0; i < 3; i++) out[i] = centre[i] - motion->centre[i];
    memcpy(middle, motion->centre, sizeof middle);
    radius += sqrt(dot(out, out));
  }
  for (int i = 0; i < 3; i++) {
    const double first = middle[i] + made->view.shutter_open * by[i],
                 last = middle[i] + made->view.shutter_close * by[i];
    const double wider = WIDER * (larger(fabs(first), fabs(last)) + radius);
    low[i] = (first < last ? first : last) - radius - wider;
    high[i] = larger(first, last) + radius + wider;
  }
}

static void bound(const struct RTCBoundsFunctionArguments *asked) {
  const large_surfaces *among = asked->geometryUserPtr;
  const surface of = tracer_surface(among->made, among->id, asked->primID);
  const ball *about = of.kind == SPHERES ? &among->made->balls[of.number] : &among->made->disc_balls[of.number];
  double low[3], high[3];
  hold(among->made, tracer_motion(among->made, of), about, low, high);
  *asked->bounds_o = (struct RTCBounds){.lower_x = (float)low[0],
                                        .lower_y = (float)low[1],
                                        .lower_z = (float)low[2],
                                        .upper_x = (float)high[0],
                                        .upper_y = (float)high[1],
                                        .upper_z = (float)high[2]};
}

void large_attach(tracer *made, uint32_t id, size_t count) {
  large_surfaces *among = &made->large[made->parts[id].kind];
  *among = (large_surfaces){made, id};
  RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)count);
  rtcSetGeometryUserData(geometry, among);
  rtcSetGeometryBoundsFunction(geometry, bound, NULL);
  rtcSetGeometryIntersectFunction(geometry, find_closest);
  rtcSetGeometryOccludedFunction(geometry, find_any);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(made->scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

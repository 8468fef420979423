#include "meeting.h"

#include <float.h>

#include "arithmetic.h"
#include "frames.h"

static double along_plane(const plane *met, const double origin[3], const double direction[3]) {
  return (met->offset - dot(met->normal, origin)) / dot(met->normal, direction);
}

/* The nearer root in front of the origin, and without its cancellation: the distance to the foot of the centre's
 * perpendicular first (Haines et al. 2019, "Precision improvements for ray/sphere intersection"). */
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

/* Again in double what Embree met in float, so that patterns and shadows start from the surface itself. */
static double meet_at_rest(const tracer *made, surface of, const double origin[3], const double direction[3],
                           double normal[3]) {
  const uint32_t kind = of.kind, primitive = of.number;
  if (kind == SPHERES) {
    const ball *met = &made->balls[primitive];
    const double t = along_ball(met, origin, direction);
    for (int i = 0; i < 3; i++) normal[i] = (origin[i] + t * direction[i] - met->centre[i]) / met->radius;
    return t;
  }
  const plane *met = kind == TRIANGLES ? &made->triangle_planes[primitive]
                     : kind == DISCS   ? &made->disc_planes[primitive]
                                       : &made->planes[primitive];
  for (int i = 0; i < 3; i++) normal[i] = met->normal[i];
  return along_plane(met, origin, direction);
}

double meeting_slack(const tracer *made, const asc_motion *motion, const double rest[3]) {
  if (!motion) return 0.0;
  double out[3];
  for (int i = 0; i < 3; i++) out[i] = rest[i] - motion->centre[i];
  return motion_sagitta(motion, made->view.shutter_close - made->view.shutter_open) * sqrt(dot(out, out));
}

/* The same with what moves, at a time; and the material, normal and point of rest of the meeting. */
static double meet(const tracer *made, surface of, double time, const double origin[3], const double direction[3],
                   meeting *met) {
  met->of = of;
  met->material = &made->materials[made->material_of[of.kind][of.number]];
  const asc_motion *motion = tracer_motion(made, of);
  met->slack = 0.0;
  if (!motion) {
    const double t = meet_at_rest(made, of, origin, direction, met->normal);
    for (int i = 0; i < 3; i++) met->rest[i] = origin[i] + t * direction[i];
    return t;
  }
  if (motion->kind == ASC_MOTION_FRAMES)
    return frames_meet(made, of.number, time, origin, direction, met->normal, met->rest, &met->slack);
  const placing at = motion_at(motion, time);
  double rest_origin[3], rest_direction[3], normal[3];
  motion_ray_to_rest(&at, origin, direction, rest_origin, rest_direction);
  const double t = meet_at_rest(made, of, rest_origin, rest_direction, normal);
  for (int i = 0; i < 3; i++) met->rest[i] = rest_origin[i] + t * rest_direction[i];
  motion_turn(&at, normal, met->normal);
  met->slack = meeting_slack(made, motion, met->rest);
  return t;
}

/* The distance along a ray to an endless plane, at a time. */
static double along_moving_plane(const tracer *made, uint32_t number, double time, const double origin[3],
                                 const double direction[3]) {
  const asc_motion *motion = tracer_motion(made, (surface){PLANES, number});
  if (!motion) return along_plane(&made->planes[number], origin, direction);
  const placing at = motion_at(motion, time);
  double rest_origin[3], rest_direction[3];
  motion_ray_to_rest(&at, origin, direction, rest_origin, rest_direction);
  return along_plane(&made->planes[number], rest_origin, rest_direction);
}

static double mix_of(const asc_pattern *pattern, const double away[3]) {
  if (pattern->kind == ASC_PATTERN_ZONE_PLATE) return 0.5 * (1.0 + cosine_of_any(pattern->scale * dot(away, away)));
  double sum = 0.0;
  for (int i = 0; i < 3; i++) sum += floor(pattern->scale * away[i]);
  return sum - 2.0 * floor(0.5 * sum); /* the parity: 0 or 1, for sums of any size and sign */
}

void meeting_colour(const tracer *made, const asc_material *material, const double rest[3], double colour[3]) {
  const asc_pattern *pattern = &material->pattern;
  if (pattern->kind == ASC_PATTERN_NONE) {
    colour[0] = colour[1] = colour[2] = 1.0;
    return;
  }
  const asc_view *view = &made->view;
  double away[3]; /* from the pattern's origin, along the world's axes */
  for (int i = 0; i < 3; i++)
    away[i] = view->right[i] * rest[0] + view->up[i] * rest[1] + view->forward[i] * rest[2] - pattern->origin[i];
  const double mix = mix_of(pattern, away);
  for (int i = 0; i < 3; i++) colour[i] = pattern->low[i] + (pattern->high[i] - pattern->low[i]) * mix;
}

void meeting_find(const tracer *made, const packet *rays, uint32_t lane, meeting *met) {
  const double *origin = rays->origin[lane], *direction = rays->direction[lane];
  const struct RTCHit16 *hit = &rays->rays.hit;
  double nearest = INFINITY;
  met->material = NULL;
  if (hit->geomID[lane] != RTC_INVALID_GEOMETRY_ID) {
    const surface found = tracer_surface(made, hit->geomID[lane], hit->primID[lane]);
    nearest = meet(made, found, rays->time[lane], origin, direction, met);
  }
  for (uint32_t i = 0; i < made->plane_count; i++) {
    const double t = along_moving_plane(made, i, rays->time[lane], origin, direction);
    if (!(t > 0.0 && t < nearest)) continue;
    nearest = meet(made, (surface){PLANES, i}, rays->time[lane], origin, direction, met);
  }
  if (!met->material) return;
  met->distance = nearest;
  const double side = dot(met->normal, direction) > 0.0 ? -1.0 : 1.0;
  for (int i = 0; i < 3; i++) {
    met->point[i] = origin[i] + nearest * direction[i];
    met->normal[i] *= side;
  }
  meeting_colour(made, met->material, met->rest, met->colour);
}

/* Vertices and origin are rounded to 2^-24 of their largest coordinate, and a triangle's plane by a few times that; and
 * Embree's motion is off. */
void meeting_lift(const double point[3], const double normal[3], double slack, double lifted[3]) {
  double largest = 0.0;
  for (int i = 0; i < 3; i++) largest = larger(largest, fabs(point[i]));
  for (int i = 0; i < 3; i++) lifted[i] = point[i] + normal[i] * (16.0 * FLT_EPSILON * largest + 2.0 * slack);
}

int meeting_planes_block(const tracer *made, double time, const double origin[3], const double toward[3],
                         double distance) {
  for (uint32_t i = 0; i < made->plane_count; i++) {
    const double t = along_moving_plane(made, i, time, origin, toward);
    if (t > 0.0 && t < distance) return 1;
  }
  return 0;
}

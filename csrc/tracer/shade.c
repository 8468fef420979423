/* Radiance at the points that a packet's rays meet: the equation of scene.h, in double. */
#include <float.h>

#include "frames.h"
#include "packet.h"

/* Where a ray ends. */
typedef struct meeting {
  const asc_material *material; /* NULL: nowhere */
  double point[3];
  double rest[3];   /* where the surface had that point at time 0 */
  double normal[3]; /* of length 1, toward the viewer */
  double slack;     /* how far Embree's surface may be off for its motion in straight lines */
  double colour[3]; /* of the pattern */
} meeting;

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

/* The same with what moves, at a time; and the material, normal and point of rest of the meeting. */
static double meet(const tracer *made, surface of, double time, const double origin[3], const double direction[3],
                   meeting *met) {
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
  double out[3];
  for (int i = 0; i < 3; i++) out[i] = met->rest[i] - motion->centre[i];
  met->slack = motion_sagitta(motion, made->view.shutter_close - made->view.shutter_open) * sqrt(dot(out, out));
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
  if (pattern->kind == ASC_PATTERN_ZONE_PLATE) return 0.5 * (1.0 + cos(pattern->scale * dot(away, away)));
  double sum = 0.0;
  for (int i = 0; i < 3; i++) sum += floor(pattern->scale * away[i]);
  return sum - 2.0 * floor(0.5 * sum); /* the parity: 0 or 1, for sums of any size and sign */
}

static void take_colour(const tracer *made, meeting *met) {
  const asc_pattern *pattern = &met->material->pattern;
  if (pattern->kind == ASC_PATTERN_NONE) {
    met->colour[0] = met->colour[1] = met->colour[2] = 1.0;
    return;
  }
  const asc_view *view = &made->view;
  double away[3]; /* from the pattern's origin, along the world's axes */
  for (int i = 0; i < 3; i++)
    away[i] = view->right[i] * met->rest[0] + view->up[i] * met->rest[1] + view->forward[i] * met->rest[2] -
              pattern->origin[i];
  const double mix = mix_of(pattern, away);
  for (int i = 0; i < 3; i++) met->colour[i] = pattern->low[i] + (pattern->high[i] - pattern->low[i]) * mix;
}

/* A lane's ray from the eye, again in double. */
static void eye_ray(const tracer *made, const packet *rays, uint32_t lane, double origin[3], double direction[3]) {
  const asc_view *view = &made->view;
  const double u = (2.0 * rays->sample_x[lane] / view->width - 1.0) * view->half_width;
  const double v = (1.0 - 2.0 * rays->sample_y[lane] / view->height) * view->half_height;
  const int perspective = view->projection == ASC_PERSPECTIVE;
  origin[0] = perspective ? 0.0 : u;
  origin[1] = perspective ? 0.0 : v;
  origin[2] = 0.0;
  direction[0] = perspective ? u : 0.0;
  direction[1] = perspective ? v : 0.0;
  direction[2] = 1.0;
  if (!(view->lens_radius > 0.0)) return;
  for (int i = 0; i < 2; i++) {
    origin[i] = rays->lens[lane][i];
    direction[i] -= rays->lens[lane][i] / view->focus_distance;
  }
}

/* The nearest of what Embree met and of the planes. */
static meeting find_meeting(const tracer *made, const packet *rays, uint32_t lane) {
  double origin[3], direction[3];
  eye_ray(made, rays, lane, origin, direction);
  const struct RTCHit16 *hit = &rays->rays.hit;
  meeting met = {0};
  double nearest = INFINITY;
  if (hit->geomID[lane] != RTC_INVALID_GEOMETRY_ID) {
    const surface found = tracer_surface(made, hit->geomID[lane], hit->primID[lane]);
    nearest = meet(made, found, rays->time[lane], origin, direction, &met);
  }
  for (uint32_t i = 0; i < made->plane_count; i++) {
    const double t = along_moving_plane(made, i, rays->time[lane], origin, direction);
    if (!(t > 0.0 && t < nearest)) continue;
    nearest = meet(made, (surface){PLANES, i}, rays->time[lane], origin, direction, &met);
  }
  if (!met.material) return met;
  const double side = dot(met.normal, direction) > 0.0 ? -1.0 : 1.0;
  for (int i = 0; i < 3; i++) {
    met.point[i] = origin[i] + nearest * direction[i];
    met.normal[i] *= side;
  }
  take_colour(made, &met);
  return met;
}

/* A point moved off its surface by more than float can have moved the surface: vertices and origin are rounded to 2^-24
 * of their largest coordinate, and a triangle's plane by a few times that; and than Embree's motion is off. */
static void lift(const meeting *met, double origin[3]) {
  double largest = 0.0;
  for (int i = 0; i < 3; i++) largest = fmax(largest, fabs(met->point[i]));
  for (int i = 0; i < 3; i++)
    origin[i] = met->point[i] + met->normal[i] * (16.0 * FLT_EPSILON * largest + 2.0 * met->slack);
}

static int planes_block(const tracer *made, double time, const double origin[3], const double toward[3],
                        double distance) {
  for (uint32_t i = 0; i < made->plane_count; i++) {
    const double t = along_moving_plane(made, i, time, origin, toward);
    if (t > 0.0 && t < distance) return 1;
  }
  return 0;
}

static void set_shadow_ray(packet *rays, uint32_t lane, const double origin[3], const double toward[3],
                           double distance) {
  struct RTCRay16 *ray = &rays->shadows;
  ray->org_x[lane] = (float)origin[0];
  ray->org_y[lane] = (float)origin[1];
  ray->org_z[lane] = (float)origin[2];
  ray->dir_x[lane] = (float)toward[0];
  ray->dir_y[lane] = (float)toward[1];
  ray->dir_z[lane] = (float)toward[2];
  ray->tnear[lane] = 0.0f;
  ray->tfar[lane] = (float)distance;
  ray->time[lane] = rays->rays.ray.time[lane];
  ray->mask[lane] = UINT32_MAX;
  ray->flags[lane] = 0;
}

static void add_light(const tracer *made, packet *rays, const light_source *from, const meeting met[PACKET]) {
  const asc_light *given = &from->given;
  const int has_area = light_has_area(given);
  double cosine[PACKET] = {0.0}, falloff[PACKET];
  uint32_t count = 0;
  for (uint32_t i = 0; i < PACKET; i++) {
    rays->shadowed[i] = 0;
    if (i >= rays->lanes || !met[i].material) continue;
    double toward[3], origin[3];
    const double *u = has_area ? rays->further[i] + from->numbers : NULL;
    const double distance = light_toward(from, u, met[i].point, toward, &falloff[i]);
    cosine[i] = dot(met[i].normal, toward);
    if (!(cosine[i] > 0.0) || falloff[i] == 0.0) continue;
    lift(&met[i], origin);
    if (planes_block(made, rays->time[i], origin, toward, distance)) continue;
    set_shadow_ray(rays, i, origin, toward, distance);
    rays->shadowed[i] = -1;
    count++;
  }
  if (count == 0) return;
  rays->shadow_rays += count;
  rtcOccluded16(rays->shadowed, made->scene, &rays->context, &rays->shadows);
  for (uint32_t i = 0; i < rays->lanes; i++) {
    if (!rays->shadowed[i] || rays->shadows.tfar[i] < 0.0f) continue; /* Embree sets tfar to -inf where it is blocked */
    const asc_material *material = met[i].material;
    for (int channel = 0; channel < 3; channel++)
      rays->radiance[i][channel] +=
          met[i].colour[channel] * material->albedo[channel] * given->intensity[channel] * (cosine[i] * falloff[i]);
  }
}

void packet_shade(const tracer *made, packet *rays) {
  meeting met[PACKET];
  for (uint32_t i = 0; i < rays->lanes; i++) {
    met[i] = find_meeting(made, rays, i);
    for (int channel = 0; channel < 3; channel++)
      rays->radiance[i][channel] = met[i].material ? met[i].colour[channel] * met[i].material->emission[channel]
                                                   : made->view.background[channel];
  }
  for (size_t i = 0; i < made->light_count; i++) add_light(made, rays, &made->lights[i], met);
}

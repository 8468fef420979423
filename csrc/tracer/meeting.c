#include "meeting.h"

#include "arithmetic.h"
#include "frames.h"
#include "large.h"
#include "surface_pattern.h"
#include "vectorise.h"

static double along_plane(const plane *met, const double origin[3], const double direction[3]) {
  return (met->offset - dot(met->normal, origin)) / dot(met->normal, direction);
}

/* The nearer root in front of the origin, and without its cancellation: the distance to the foot of the centre's
 * perpendicular first (Haines et al. 2019, "Precision improvements for ray/sphere intersection"). */
static double along_ball(const ball *met, const double origin[3], const double direction[3]) {
  double to_centre[3], miss[3], roots[2];
  if (met->large) {
    (void)large_roots(met, origin, direction, roots);
    return roots[0] > 0.0 ? roots[0] : roots[1];
  }
  for (int i = 0; i < 3; i++) to_centre[i] = met->centre[i] - origin[i];
  const double squared = dot(direction, direction);
  const double foot = dot(to_centre, direction) / squared;
  for (int i = 0; i < 3; i++) miss[i] = to_centre[i] - foot * direction[i];
  const double inside = met->radius * met->radius - dot(miss, miss);
  const double half_chord = sqrt((inside > 0.0 ? inside : 0.0) / squared);
  return foot - half_chord > 0.0 ? foot - half_chord : foot + half_chord;
}

static const plane *plane_of_flat(const tracer *made, surface of) {
  return of.kind == TRIANGLES ? &made->triangle_planes[of.number]
         : of.kind == DISCS   ? &made->disc_planes[of.number]
                              : &made->planes[of.number];
}

/* Again in double what Embree met in float, so that patterns and shadows start from the surface itself. */
static double meet_at_rest(const tracer *made, surface of, const double origin[3], const double direction[3],
                           double normal[3]) {
  if (of.kind == SPHERES) {
    const ball *met = &made->balls[of.number];
    const double t = along_ball(met, origin, direction);
    for (int i = 0; i < 3; i++) normal[i] = (origin[i] + t * direction[i] - met->centre[i]) / met->radius;
    return t;
  }
  const plane *met = plane_of_flat(made, of);
  for (int i = 0; i < 3; i++) normal[i] = met->normal[i];
  return along_plane(met, origin, direction);
}

double meeting_slack(const tracer *made, const asc_motion *motion, const double rest[3]) {
  if (!motion) return 0.0;
  double out[3];
  for (int i = 0; i < 3; i++) out[i] = rest[i] - motion->centre[i];
  return motion_sagitta(motion, made->view.shutter_close - made->view.shutter_open) * sqrt(dot(out, out));
}

/* What a surface that is round or moves gives of a meeting. */
typedef struct found {
  double distance, normal[3];
  double rest[3]; /* where the surface had the point at time 0 */
  double slack;   /* how far Embree's surface may be off for its motion in straight lines */
} found;

/* The same with what moves, at a time. */
static found meet(const tracer *made, surface of, double time, const double origin[3], const double direction[3]) {
  const asc_motion *motion = tracer_motion(made, of);
  found met = {.slack = 0.0};
  if (!motion) {
    met.distance = meet_at_rest(made, of, origin, direction, met.normal);
    for (int i = 0; i < 3; i++) met.rest[i] = origin[i] + met.distance * direction[i];
    return met;
  }
  if (motion->kind == ASC_MOTION_FRAMES) {
    met.distance = frames_meet(made, of.number, time, origin, direction, met.normal, met.rest, &met.slack);
    return met;
  }
  const placing at = motion_at(motion, time);
  double rest_origin[3], rest_direction[3], normal[3];
  motion_ray_to_rest(&at, origin, direction, rest_origin, rest_direction);
  met.distance = meet_at_rest(made, of, rest_origin, rest_direction, normal);
  for (int i = 0; i < 3; i++) met.rest[i] = rest_origin[i] + met.distance * rest_direction[i];
  motion_turn(&at, normal, met.normal);
  if (!large_is(made, of)) met.slack = meeting_slack(made, motion, met.rest);
  return met;
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

/* `mix`: the shares of the second colour. */
ASC_VECTORISE static void mix_colours(const asc_pattern *of, const scalars *restrict mix, uint32_t lanes,
                                      vectors *restrict colour) {
  const asc_pattern pattern = *of;
  for (uint32_t i = 0; i < PACKET; i++) {
    for (int channel = 0; channel < 3; channel++) {
      const double mixed = pattern.low[channel] + (pattern.high[channel] - pattern.low[channel]) * mix->of[i];
      colour->row[channel][i] = (lanes >> i) & 1 ? mixed : colour->row[channel][i];
    }
  }
}

ASC_VECTORISE static void mix_checks(const asc_view *of, const asc_pattern *checks, const vectors *restrict rest,
                                     scalars *restrict mix) {
  const asc_view view = *of;
  const asc_pattern pattern = *checks;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double point[3] = {rest->row[0][i], rest->row[1][i], rest->row[2][i]};
    mix->of[i] = pattern_parity(&view, &pattern, point);
  }
}

/* Gives whether a phase of the lanes is too large; then sets the phases alone. */
ASC_VECTORISE static int mix_rings(const asc_pattern *rings, const vectors *restrict rest, uint32_t lanes,
                                   scalars *restrict mix) {
  const asc_pattern pattern = *rings;
  int far = 0;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double point[3] = {rest->row[0][i], rest->row[1][i], rest->row[2][i]};
    mix->of[i] = (lanes >> i) & 1 ? pattern_phase(&pattern, point) : 0.0;
    far |= !(fabs(mix->of[i]) <= HAVERCOSINE_MOST);
  }
  for (uint32_t i = 0; i < PACKET && !far; i++) mix->of[i] = havercosine(mix->of[i]);
  return far;
}

void meeting_colours(const tracer *made, const asc_material *const material[PACKET], uint32_t lanes,
                     const vectors *rest, vectors *colour) {
  while (lanes) {
    const uint32_t alike = meeting_alike(material, lanes);
    const asc_pattern *pattern = &material[__builtin_ctz(alike)]->pattern;
    scalars mix;
    if (pattern->kind == ASC_PATTERN_CHECKER)
      mix_checks(&made->view, pattern, rest, &mix);
    else if (mix_rings(pattern, rest, alike, &mix))
      for (uint32_t i = 0; i < PACKET; i++) mix.of[i] = havercosine_of_any(mix.of[i]);
    mix_colours(pattern, &mix, alike, colour);
    lanes &= ~alike;
  }
}

/* Where the lanes' rays end, before the points themselves are known. */
typedef struct search {
  alignas(64) double offset[PACKET]; /* of their planes, where `meetings` has the normals; both 0 where there is none */
  alignas(64) double slack[PACKET];
  alignas(64) double least_lift[PACKET];
  vectors rest;    /* of the lanes that are in `others` alone */
  int one;         /* whether all lanes meet the same surface, which is flat and stands still */
  uint32_t others; /* bits: lanes that meet what is round or moves */
} search;

static int is_flat_and_still(const tracer *made, surface of) {
  return of.kind != SPHERES && (made->motion_count == 0 || !tracer_motion(made, of));
}

static const asc_material *material_of(const tracer *made, surface of) {
  return &made->materials[made->material_of[of.kind][of.number]];
}

static void take_surface(const tracer *made, surface of, uint32_t lane, meetings *met, search *to) {
  const uint32_t bit = UINT32_C(1) << lane;
  met->of[lane] = of;
  met->material[lane] = material_of(made, of);
  to->slack[lane] = 0.0;
  to->least_lift[lane] = meeting_least_lift_of(made, of);
  if (!is_flat_and_still(made, of)) {
    to->others |= bit;
    return;
  }
  const plane *facing = plane_of_flat(made, of);
  set_lane(&met->normal, lane, facing->normal);
  to->offset[lane] = facing->offset;
  to->others &= ~bit;
}

static void set_material(const tracer *made, uint32_t lane, meetings *met) {
  static const double black[3] = {0.0};
  const asc_material *material = met->material[lane];
  set_lane(&met->emission, lane, material ? material->emission : made->view.background);
  if (made->light_count > 0 || made->transport.bounces > 0)
    set_lane(&met->albedo, lane, material ? material->albedo : black);
  if (made->transport.bounces > 0) set_lane(&met->reflection, lane, material ? material->reflection : black);
}

/* The same flat surface for all lanes. */
static void take_one(const tracer *made, surface of, meetings *met, search *to) {
  const plane facing = *plane_of_flat(made, of);
  const double least_lift = meeting_least_lift_of(made, of);
  const asc_material *one = material_of(made, of), material = *one;
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    met->of[lane] = of;
    met->material[lane] = one;
    to->slack[lane] = 0.0;
    to->least_lift[lane] = least_lift;
    to->offset[lane] = facing.offset;
    set_lane(&met->normal, lane, facing.normal);
    set_lane(&met->albedo, lane, material.albedo);
    set_lane(&met->emission, lane, material.emission);
    set_lane(&met->reflection, lane, material.reflection);
  }
}

/* Gives whether Embree met anything. */
static int take_embrees(const tracer *made, const packet *rays, meetings *met, search *to) {
  const struct RTCHit16 *hit = &rays->rays.hit;
  uint32_t differ = 0, any = 0;
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const uint32_t there = rays->valid[lane] ? ~hit->geomID[lane] : 0;
    differ |= (there ^ ~hit->geomID[0]) | (hit->primID[lane] ^ hit->primID[0]);
    any |= there;
  }
  to->others = 0;
  to->one = 0;
  if (any && !differ) {
    const surface of = tracer_surface(made, hit->geomID[0], hit->primID[0]);
    if (is_flat_and_still(made, of)) {
      take_one(made, of, met, to);
      to->one = 1;
      return 1;
    }
  }
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    if (any && rays->valid[lane] && hit->geomID[lane] != RTC_INVALID_GEOMETRY_ID) {
      take_surface(made, tracer_surface(made, hit->geomID[lane], hit->primID[lane]), lane, met, to);
      continue;
    }
    met->material[lane] = NULL;
    met->normal.row[0][lane] = met->normal.row[1][lane] = met->normal.row[2][lane] = 0.0;
    to->offset[lane] = to->slack[lane] = to->least_lift[lane] = met->distance[lane] = 0.0;
  }
  return any != 0;
}

/* For all lanes, as along_plane. */
ASC_VECTORISE static void meet_flat(const packet *restrict rays, const search *restrict with, meetings *restrict met) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double origin[3] = {rays->origin.row[0][i], rays->origin.row[1][i], rays->origin.row[2][i]};
    const double direction[3] = {rays->direction.row[0][i], rays->direction.row[1][i], rays->direction.row[2][i]};
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double along = dot(normal, direction);
    met->distance[i] = (with->offset[i] - dot(normal, origin)) / (along == 0.0 ? 1.0 : along);
  }
}

static void meet_other(const tracer *made, const packet *rays, uint32_t lane, meetings *met, search *with) {
  double origin[3], direction[3];
  get_lane(&rays->origin, lane, origin);
  get_lane(&rays->direction, lane, direction);
  const found there = meet(made, met->of[lane], rays->time[lane], origin, direction);
  met->distance[lane] = there.distance;
  with->slack[lane] = there.slack;
  set_lane(&met->normal, lane, there.normal);
  set_lane(&with->rest, lane, there.rest);
}

/* Planes that are nearer than what was met so far. Gives whether there are any. */
static int meet_endless(const tracer *made, const packet *rays, uint32_t lane, meetings *met, search *with) {
  double origin[3], direction[3];
  get_lane(&rays->origin, lane, origin);
  get_lane(&rays->direction, lane, direction);
  int any = 0;
  for (uint32_t i = 0; i < made->plane_count; i++) {
    const double t = along_moving_plane(made, i, rays->time[lane], origin, direction);
    if (!(t > 0.0 && t < (met->material[lane] ? met->distance[lane] : INFINITY))) continue;
    take_surface(made, (surface){PLANES, i}, lane, met, with);
    with->one = 0;
    met->distance[lane] = t;
    if ((with->others >> lane) & 1) meet_other(made, rays, lane, met, with);
    any = 1;
  }
  return any;
}

ASC_VECTORISE static void set_points(const packet *restrict rays, const search *restrict with, meetings *restrict met) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double direction[3] = {rays->direction.row[0][lane], rays->direction.row[1][lane],
                                 rays->direction.row[2][lane]};
    const double normal[3] = {met->normal.row[0][lane], met->normal.row[1][lane], met->normal.row[2][lane]};
    const double side = dot(normal, direction) > 0.0 ? -1.0 : 1.0;
    double point[3];
    for (int i = 0; i < 3; i++) point[i] = rays->origin.row[i][lane] + met->distance[lane] * direction[i];
    const double lift = larger(meeting_lift(point, with->slack[lane]), with->least_lift[lane]);
    for (int i = 0; i < 3; i++) {
      const double facing = normal[i] * side;
      met->normal.row[i][lane] = facing;
      met->point.row[i][lane] = point[i];
      met->lifted.row[i][lane] = point[i] + facing * lift;
      met->colour.row[i][lane] = 1.0;
    }
  }
}

ASC_VECTORISE static void set_ways_to_eye(const packet *restrict rays, meetings *restrict met) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double direction[3] = {rays->direction.row[0][lane], rays->direction.row[1][lane],
                                 rays->direction.row[2][lane]};
    const double length = sqrt(dot(direction, direction));
    for (int i = 0; i < 3; i++) met->to_eye.row[i][lane] = -direction[i] / length;
  }
}

static void set_colours(const tracer *made, const search *with, meetings *met) {
  uint32_t patterned = 0;
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const asc_material *material = met->material[lane];
    if (material && material->pattern.kind != ASC_PATTERN_NONE) patterned |= UINT32_C(1) << lane;
  }
  if (!patterned) return;
  if (!with->others) {
    meeting_colours(made, met->material, patterned, &met->point, &met->colour);
    return;
  }
  vectors rest = met->point;
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    if (!((with->others >> lane) & 1)) continue;
    for (int i = 0; i < 3; i++) rest.row[i][lane] = with->rest.row[i][lane];
  }
  meeting_colours(made, met->material, patterned, &rest, &met->colour);
}

static int reflects(const asc_material *material) {
  return material && (material->reflection[0] > 0.0 || material->reflection[1] > 0.0 || material->reflection[2] > 0.0);
}

static int any_reflects(const search *with, const meetings *met) {
  for (uint32_t lane = 0; lane < (with->one ? 1 : PACKET); lane++)
    if (reflects(met->material[lane])) return 1;
  return 0;
}

int meeting_find(const tracer *made, const packet *rays, meetings *met) {
  search with;
  int any = take_embrees(made, rays, met, &with);
  if (!any && made->plane_count == 0) return 0;
  if (any) meet_flat(rays, &with, met);
  for (uint32_t lane = 0; lane < PACKET && with.others; lane++)
    if ((with.others >> lane) & 1) meet_other(made, rays, lane, met, &with);
  for (uint32_t lane = 0; lane < PACKET && made->plane_count > 0; lane++)
    if (rays->valid[lane]) any |= meet_endless(made, rays, lane, met, &with);
  if (!any) return 0;
  set_points(rays, &with, met);
  for (uint32_t lane = 0; lane < PACKET && !with.one; lane++) set_material(made, lane, met);
  if (made->has_patterns) set_colours(made, &with, met);
  if (made->transport.mirror_bounces > 0 && any_reflects(&with, met)) set_ways_to_eye(rays, met);
  return 1;
}

meeting meeting_of(const meetings *met, uint32_t lane) {
  meeting one = {.material = met->material[lane], .of = met->of[lane], .distance = met->distance[lane]};
  get_lane(&met->point, lane, one.point);
  get_lane(&met->normal, lane, one.normal);
  get_lane(&met->lifted, lane, one.lifted);
  get_lane(&met->colour, lane, one.colour);
  return one;
}

int meeting_planes_block(const tracer *made, double time, const double origin[3], const double toward[3],
                         double distance) {
  for (uint32_t i = 0; i < made->plane_count; i++) {
    const double t = along_moving_plane(made, i, time, origin, toward);
    if (t > 0.0 && t < distance) return 1;
  }
  return 0;
}

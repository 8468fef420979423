#include "emitter.h"

#include <stdlib.h>
#include <string.h>

#include "concentric.h"
#include "frames.h"
#include "vectorise.h"

static double length_of(const double v[3]) { return sqrt(dot(v, v)); }

/* The mean of what a material sends out of a unit area, but for a factor; a pattern counts as half of each colour. */
static double power_of(const asc_material *material) {
  double sum = 0.0;
  for (int channel = 0; channel < 3; channel++) {
    const asc_pattern *pattern = &material->pattern;
    const double colour =
        pattern->kind == ASC_PATTERN_NONE ? 1.0 : 0.5 * (fabs(pattern->low[channel]) + fabs(pattern->high[channel]));
    sum += colour * fabs(material->emission[channel]);
  }
  return sum;
}

static emitter describe(const tracer *made, const asc_scene *scene, surface of) {
  emitter made_emitter = {.of = of};
  if (of.kind == SPHERES) {
    const ball *round = &made->balls[of.number];
    made_emitter.area = 4.0 * ASC_PI * round->radius * round->radius;
  } else if (of.kind == DISCS) {
    const asc_disc *disc = &scene->discs[of.number];
    tracer_to_camera(&made->view, disc->centre, made_emitter.corner);
    across(made->disc_planes[of.number].normal, made_emitter.edges[0], made_emitter.edges[1]);
    for (int i = 0; i < 6; i++) made_emitter.edges[i / 3][i % 3] *= disc->radius;
    made_emitter.area = ASC_PI * disc->radius * disc->radius;
  } else {
    const double *corners = scene->vertices + 9 * (size_t)of.number;
    tracer_to_camera(&made->view, corners, made_emitter.corner);
    for (size_t k = 0; k < 2; k++) {
      double corner[3];
      tracer_to_camera(&made->view, corners + 3 * (k + 1), corner);
      for (int i = 0; i < 3; i++) made_emitter.edges[k][i] = corner[i] - made_emitter.corner[i];
    }
  }
  cross(made_emitter.edges[0], made_emitter.edges[1], made_emitter.across);
  made_emitter.length = length_of(made_emitter.across);
  if (of.kind == TRIANGLES) made_emitter.area = 0.5 * made_emitter.length;
  return made_emitter;
}

/* Lists those of one kind, with their power in the place of their chance. */
static asc_status list(tracer *made, const asc_scene *scene, uint32_t kind, size_t count, asc_error *error) {
  size_t found = 0;
  for (size_t i = 0; i < count; i++) found += power_of(&made->materials[made->material_of[kind][i]]) > 0.0;
  if (found == 0) return ASC_OK;
  emitter *grown = realloc(made->emitters, (made->emitter_count + found) * sizeof *grown);
  if (grown) made->emitters = grown;
  made->emitter_of[kind] = calloc(count, sizeof(uint32_t));
  if (!grown || !made->emitter_of[kind])
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu surfaces that shine", found);
  for (uint32_t i = 0; i < count; i++) {
    const double power = power_of(&made->materials[made->material_of[kind][i]]);
    if (!(power > 0.0) || frames_of(made, tracer_motion(made, (surface){kind, i}))) continue;
    emitter fresh = describe(made, scene, (surface){kind, i});
    fresh.chance = power * fresh.area;
    if (!(fresh.chance > 0.0)) continue; /* a triangle without area */
    made->emitters[made->emitter_count++] = fresh;
    made->emitter_of[kind][i] = (uint32_t)made->emitter_count;
  }
  return ASC_OK;
}

asc_status emitter_take(tracer *made, const asc_scene *scene, asc_error *error) {
  if (!made->transport.samples_emitters) return ASC_OK;
  asc_status status = list(made, scene, TRIANGLES, scene->triangle_count, error);
  if (status == ASC_OK) status = list(made, scene, DISCS, scene->disc_count, error);
  if (status == ASC_OK) status = list(made, scene, SPHERES, scene->sphere_count, error);
  if (status) return status;
  double whole = 0.0, sum = 0.0;
  for (size_t i = 0; i < made->emitter_count; i++) whole += made->emitters[i].chance;
  if (!(whole > 0.0) || !isfinite(whole)) made->emitter_count = 0; /* rays alone find such */
  for (size_t i = 0; i < made->emitter_count; i++) {
    made->emitters[i].chance /= whole;
    made->emitters[i].up_to = sum += made->emitters[i].chance;
  }
  return ASC_OK;
}

/* The emitter in whose share of [0, 1) a number lies, and where in it. */
static const emitter *pick(const tracer *made, double number, double *within) {
  size_t first = 0, count = made->emitter_count;
  while (count > 1) { /* the first whose sum is above the number, or the last */
    const size_t half = count / 2;
    if (made->emitters[first + half - 1].up_to > number) {
      count = half;
    } else {
      first += half;
      count -= half;
    }
  }
  const emitter *picked = &made->emitters[first];
  *within = fmin(fmax(1.0 - (picked->up_to - number) / picked->chance, 0.0), 1.0);
  return picked;
}

/* 1 - cosine of half the angle that a sphere is seen under, from outside. */
static double cap_of(double radius, double distance) {
  const double squared = radius * radius / (distance * distance);
  return squared / (1.0 + sqrt(fmax(0.0, 1.0 - squared)));
}

/* A place on a ball. */
typedef struct ball_place {
  double point[3], normal[3], density;
} ball_place;

/* From outside, directions uniform over the cone that the sphere fills; from within, places uniform by area. */
static int choose_of_ball(const double centre[3], double radius, const double u[2], const double seen_from[3],
                          ball_place *chosen) {
  double axis[3], a[3], b[3], disc[2];
  for (int i = 0; i < 3; i++) axis[i] = centre[i] - seen_from[i];
  const double distance = length_of(axis);
  if (distance > radius) {
    for (int i = 0; i < 3; i++) axis[i] /= distance;
    const double out = asc_to_disc(u, disc), cap = cap_of(radius, distance), versine = out * out * cap;
    const double spread = sqrt(cap * (2.0 - versine)), along = distance * (1.0 - versine);
    const double miss = distance * out * spread, inside = sqrt(fmax(0.0, radius * radius - miss * miss));
    across(axis, a, b);
    for (int i = 0; i < 3; i++) {
      const double way = (1.0 - versine) * axis[i] + spread * (disc[0] * a[i] + disc[1] * b[i]);
      chosen->normal[i] = ((along - inside) * way - distance * axis[i]) / radius;
      chosen->point[i] = centre[i] + radius * chosen->normal[i];
    }
    chosen->density = 1.0 / (2.0 * ASC_PI * cap);
    return 1;
  }
  const double z = 1.0 - 2.0 * u[0], out = sqrt(fmax(0.0, 1.0 - z * z)), turn = 2.0 * ASC_PI * u[1];
  const double outward[3] = {out * cos(turn), out * sin(turn), z};
  double way[3];
  for (int i = 0; i < 3; i++) {
    chosen->point[i] = centre[i] + radius * outward[i];
    chosen->normal[i] = -outward[i];
    way[i] = chosen->point[i] - seen_from[i];
  }
  const double squared = dot(way, way), cosine = -dot(chosen->normal, way) / sqrt(squared);
  if (!(cosine > 0.0)) return 0;
  chosen->density = squared / (cosine * 4.0 * ASC_PI * radius * radius);
  return 1;
}

/* Points and directions of what stands still, where `at` is NULL, are where they are. */
static void placed(const placing *at, const double rest[3], double moved[3]) {
  if (at)
    motion_place(at, rest, moved);
  else
    memcpy(moved, rest, 3 * sizeof *moved);
}

static void turned(const placing *at, const double rest[3], double moved[3]) {
  if (at)
    motion_turn(at, rest, moved);
  else
    memcpy(moved, rest, 3 * sizeof *moved);
}

/* Where on a triangle or a disc the numbers lie, along its edges: uniform by area. */
static void along_flat(const emitter *from, const double u[2], double along[2]) {
  if (from->of.kind == DISCS) {
    (void)asc_to_disc(u, along);
    return;
  }
  const double out = sqrt(u[1]);
  along[0] = out * (1.0 - u[0]);
  along[1] = out * u[0];
}

/* The flat emitters of lanes, with the places in `emitter_places`. */
typedef struct flat_emitters {
  vectors across;
  scalars length, area, chance;
} flat_emitters;

/* Lanes whose places have a pattern, bits, and where their surfaces had these at time 0. */
typedef struct patterned {
  uint32_t lanes;
  const asc_material *material[PACKET];
  vectors rest;
} patterned;

/* What a place sends out, but for a pattern, and how far Embree's surface may be off there. */
static void set_shining(const tracer *made, const emitter *from, const asc_motion *motion, const placing *at,
                        const double point[3], uint32_t lane, emitter_places *chosen, patterned *to) {
  const asc_material *material = &made->materials[made->material_of[from->of.kind][from->of.number]];
  chosen->slack.of[lane] = 0.0;
  chosen->least_lift.of[lane] = meeting_least_lift_of(made, from->of);
  set_lane(&chosen->radiance, lane, material->emission);
  if (!motion && material->pattern.kind == ASC_PATTERN_NONE) return;
  double rest[3] = {point[0], point[1], point[2]};
  if (motion) motion_ray_to_rest(at, point, (const double[3]){0.0, 0.0, 0.0}, rest, (double[3]){0.0});
  chosen->slack.of[lane] = meeting_slack(made, motion, rest);
  if (material->pattern.kind == ASC_PATTERN_NONE) return;
  to->lanes |= UINT32_C(1) << lane;
  to->material[lane] = material;
  set_lane(&to->rest, lane, rest);
}

static void add_patterns(const tracer *made, const patterned *on, emitter_places *chosen) {
  vectors colour;
  meeting_colours(made, on->material, on->lanes, &on->rest, &colour);
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    if (!((on->lanes >> lane) & 1)) continue;
    for (int channel = 0; channel < 3; channel++) chosen->radiance.row[channel][lane] *= colour.row[channel][lane];
  }
}

static void put_flat(const tracer *made, const emitter *from, double time, const double u[2], uint32_t lane,
                     flat_emitters *to, emitter_places *chosen, patterned *on) {
  const asc_motion *motion = tracer_motion(made, from->of);
  double along[2], still[3], point[3], normal[3];
  placing moved;
  if (motion) moved = motion_at(motion, time);
  const placing *at = motion ? &moved : NULL;
  along_flat(from, u, along);
  for (int i = 0; i < 3; i++) still[i] = from->corner[i] + along[0] * from->edges[0][i] + along[1] * from->edges[1][i];
  placed(at, still, point);
  turned(at, from->across, normal);
  set_lane(&chosen->point, lane, point);
  set_lane(&to->across, lane, normal);
  to->length.of[lane] = motion ? length_of(normal) : from->length;
  to->area.of[lane] = from->area;
  to->chance.of[lane] = from->chance;
  set_shining(made, from, motion, at, point, lane, chosen, on);
}

/* Sides and densities of all lanes' places. */
ASC_VECTORISE static void face(const flat_emitters *restrict from, const vectors *restrict seen_from,
                               emitter_places *restrict chosen) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double normal[3] = {from->across.row[0][lane], from->across.row[1][lane], from->across.row[2][lane]};
    double way[3];
    for (int i = 0; i < 3; i++) way[i] = chosen->point.row[i][lane] - seen_from->row[i][lane];
    const double squared = dot(way, way), facing = dot(normal, way), length = from->length.of[lane];
    const double far = length * sqrt(squared), cosine = fabs(facing) / (far > 0.0 ? far : 1.0);
    const int seen = cosine > 0.0;
    for (int i = 0; i < 3; i++)
      chosen->normal.row[i][lane] = copysign(1.0, -facing) * normal[i] / (seen ? length : 1.0);
    const double density = squared / (seen ? cosine * from->area.of[lane] : 1.0);
    chosen->density.of[lane] = seen ? density * from->chance.of[lane] : 0.0;
  }
}

static void put_ball(const tracer *made, const emitter *from, double time, const double u[2], const vectors *seen_from,
                     uint32_t lane, emitter_places *chosen, patterned *on) {
  const ball *round = &made->balls[from->of.number];
  const asc_motion *motion = tracer_motion(made, from->of);
  double centre[3], eye[3];
  ball_place place;
  placing moved;
  if (motion) moved = motion_at(motion, time);
  const placing *at = motion ? &moved : NULL;
  placed(at, round->centre, centre);
  get_lane(seen_from, lane, eye);
  if (!choose_of_ball(centre, round->radius, u, eye, &place)) return;
  set_lane(&chosen->point, lane, place.point);
  set_lane(&chosen->normal, lane, place.normal);
  chosen->density.of[lane] = place.density * from->chance;
  set_shining(made, from, motion, at, place.point, lane, chosen, on);
}

void emitter_choose(const tracer *made, const double time[PACKET], const pairs *u, const vectors *seen_from,
                    uint32_t there, emitter_places *chosen) {
  flat_emitters flat = {.length = {{0.0}}};
  patterned on;
  on.lanes = 0;
  const emitter *picked[PACKET];
  double numbers[PACKET][2];
  uint32_t balls = 0;
  *chosen = (emitter_places){.density = {{0.0}}};
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    if (!((there >> lane) & 1)) continue;
    numbers[lane][1] = u->row[1][lane];
    picked[lane] = pick(made, u->row[0][lane], &numbers[lane][0]);
    if (picked[lane]->of.kind == SPHERES)
      balls |= UINT32_C(1) << lane;
    else
      put_flat(made, picked[lane], time[lane], numbers[lane], lane, &flat, chosen, &on);
  }
  face(&flat, seen_from, chosen);
  for (uint32_t lane = 0; lane < PACKET && balls; lane++)
    if ((balls >> lane) & 1) put_ball(made, picked[lane], time[lane], numbers[lane], seen_from, lane, chosen, &on);
  if (on.lanes) add_patterns(made, &on, chosen);
}

double emitter_density(const tracer *made, double time, const meeting *met, const double origin[3],
                       const double direction[3]) {
  const uint32_t *listed = met->of.kind == PLANES ? NULL : made->emitter_of[met->of.kind];
  if (made->emitter_count == 0 || !listed || listed[met->of.number] == 0) return 0.0;
  const emitter *from = &made->emitters[listed[met->of.number] - 1];
  if (met->of.kind == SPHERES) {
    const ball *round = &made->balls[met->of.number];
    const asc_motion *motion = tracer_motion(made, met->of);
    placing moved;
    if (motion) moved = motion_at(motion, time);
    double centre[3], axis[3];
    placed(motion ? &moved : NULL, round->centre, centre);
    for (int i = 0; i < 3; i++) axis[i] = centre[i] - origin[i];
    const double distance = length_of(axis);
    if (distance > round->radius) return from->chance / (2.0 * ASC_PI * cap_of(round->radius, distance));
  }
  const double cosine = -dot(met->normal, direction);
  return cosine > 0.0 ? from->chance * met->distance * met->distance / (cosine * from->area) : 0.0;
}

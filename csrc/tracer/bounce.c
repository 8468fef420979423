#include "bounce.h"

#include "lobe.h"
#include "rows.h"
#include "traverse.h"
#include "vectorise.h"

/* How a lane's path goes on; GLOSSY: by a reflection that is no perfect mirror's. */
enum { ENDS = 0, MIRRORED, SCATTERED, GLOSSY };

typedef struct ways_on {
  alignas(64) int32_t of[PACKET];
  scalars choice;
  pairs u;
} ways_on;

/* The chances are as what either brings to the eye is of both. They make 1, or, where less light than that is left
 * after some bounces, that much (Russian roulette). */
ASC_VECTORISE static int set_chances(const transport *restrict far, packet *restrict rays, const meetings *restrict met,
                                     uint32_t bounce) {
  int any = 0;
  const int may_end = far->diffuse_bounces > 0 && bounce >= far->roulette_from;
  for (uint32_t i = 0; i < PACKET; i++) {
    double mirror = 0.0, scatter = 0.0;
    for (int channel = 0; channel < 3; channel++) {
      const double left = rays->throughput.row[channel][i];
      mirror = larger(mirror, left * met->reflection.row[channel][i]);
      scatter = larger(scatter, left * (met->colour.row[channel][i] * met->albedo.row[channel][i]));
    }
    mirror *= rays->mirrors_left.of[i] > 0.0 ? 1.0 : 0.0;
    scatter *= rays->scatters_left.of[i] > 0.0 ? 1.0 : 0.0;
    const double sum = mirror + scatter, whole = sum > 0.0 ? sum : 1.0;
    const double chance = may_end && sum < 1.0 ? sum : 1.0;
    rays->mirror.of[i] = chance * mirror / whole;
    rays->scatter.of[i] = chance * scatter / whole;
    any |= sum > 0.0;
  }
  return any;
}

int bounce_set_chances(const transport *far, packet *rays, const meetings *met, uint32_t bounce) {
  return set_chances(far, rays, met, bounce);
}

static void take_numbers(const tracer *made, const packet *rays, uint32_t bounce, ways_on *by) {
  static const double none[3] = {0.0};
  const layout *further = &made->further;
  const int chooses = made->transport.diffuse_bounces > 0;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double *numbers =
        further->bounce ? packet_numbers(rays, i) + further->bounces + (size_t)bounce * further->bounce : none;
    by->choice.of[i] = chooses ? *numbers++ : 0.0;
    by->u.row[0][i] = numbers[0];
    by->u.row[1][i] = numbers[1];
  }
}

ASC_VECTORISE static void choose(const packet *restrict rays, ways_on *restrict by) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double choice = by->choice.of[i], mirror = rays->mirror.of[i], scatter = rays->scatter.of[i];
    const int32_t way = choice < mirror ? MIRRORED : SCATTERED;
    by->of[i] = choice < mirror + scatter ? way : ENDS;
  }
}

ASC_VECTORISE static void scatter(const meetings *restrict met, const vectors *restrict ways,
                                  const ways_on *restrict by, packet *restrict rays) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const int mine = by->of[i] == SCATTERED;
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double way[3] = {ways->row[0][i], ways->row[1][i], ways->row[2][i]};
    const double chance = rays->scatter.of[i], density = chance * larger(0.0, dot(normal, way)) / ASC_PI;
    for (int channel = 0; channel < 3; channel++) {
      const double left = rays->throughput.row[channel][i];
      const double share = met->colour.row[channel][i] * met->albedo.row[channel][i] / (mine ? chance : 1.0);
      rays->throughput.row[channel][i] = left * (mine ? share : 1.0);
    }
    for (int k = 0; k < 3; k++) rays->direction.row[k][i] = mine ? way[k] : rays->direction.row[k][i];
    rays->density.of[i] = mine ? density : rays->density.of[i];
    rays->scatters_left.of[i] -= mine ? 1.0 : 0.0;
  }
}

/* Along perfect mirrors. Below the surface a path ends. */
ASC_VECTORISE static void mirror(const meetings *restrict met, ways_on *restrict by, packet *restrict rays) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double to_eye[3] = {met->to_eye.row[0][i], met->to_eye.row[1][i], met->to_eye.row[2][i]};
    const double along = 2.0 * dot(normal, to_eye);
    const double way[3] = {along * normal[0] - to_eye[0], along * normal[1] - to_eye[1], along * normal[2] - to_eye[2]};
    const int32_t asked = by->of[i];
    const int mine = asked == MIRRORED, above = dot(normal, way) > 0.0, goes = mine & above;
    const double share = 1.0 / (goes ? rays->mirror.of[i] : 1.0);
    for (int channel = 0; channel < 3; channel++) {
      const double factor = met->reflection.row[channel][i] * share;
      rays->throughput.row[channel][i] *= goes ? factor : 1.0;
    }
    for (int k = 0; k < 3; k++) rays->direction.row[k][i] = goes ? way[k] : rays->direction.row[k][i];
    rays->density.of[i] = goes ? -1.0 : rays->density.of[i];
    rays->mirrors_left.of[i] -= goes ? 1.0 : 0.0;
    by->of[i] = (mine & !above) ? ENDS : asked;
  }
}

/* Those of `lanes`, bits, whose surfaces have one lobe. Below the surface a path ends. */
ASC_VECTORISE static void take_gloss(const meetings *restrict met, const lobe_ways *restrict ways, uint32_t lanes,
                                     ways_on *restrict by, packet *restrict rays) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const int mine = (lanes >> i) & 1, goes = mine & (ways->share.of[i] > 0.0);
    const double chance = goes ? rays->mirror.of[i] : 1.0, share = ways->share.of[i] / chance;
    for (int channel = 0; channel < 3; channel++) {
      const double factor = met->reflection.row[channel][i] * share;
      rays->throughput.row[channel][i] *= goes ? factor : 1.0;
    }
    for (int k = 0; k < 3; k++) rays->direction.row[k][i] = goes ? ways->way.row[k][i] : rays->direction.row[k][i];
    rays->density.of[i] = goes ? chance * ways->density.of[i] : rays->density.of[i];
    rays->mirrors_left.of[i] -= goes ? 1.0 : 0.0;
    const int32_t way = goes ? GLOSSY : ENDS;
    by->of[i] = mine ? way : by->of[i];
  }
}

/* In the lobes of the lanes' surfaces, but for perfect mirrors. */
static void gloss(const meetings *met, ways_on *by, packet *rays) {
  uint32_t left = 0;
  for (uint32_t i = 0; i < PACKET; i++)
    if (by->of[i] == MIRRORED && met->material[i]->gloss.kind != ASC_LOBE_MIRROR) left |= UINT32_C(1) << i;
  while (left) {
    lobe_ways ways;
    const uint32_t lanes = meeting_alike(met->material, left);
    lobe_sample(&met->material[__builtin_ctz(lanes)]->gloss, &met->normal, &met->to_eye, &by->u, &ways);
    take_gloss(met, &ways, lanes, by, rays);
    left &= ~lanes;
  }
}

ASC_VECTORISE static void set_rays(const meetings *restrict met, const ways_on *restrict by, packet *restrict rays) {
  struct RTCRay16 *ray = &rays->rays.ray;
  for (uint32_t i = 0; i < PACKET; i++) {
    const int goes = by->of[i] != ENDS;
    rays->valid[i] = -goes;
    for (int k = 0; k < 3; k++) rays->origin.row[k][i] = goes ? met->lifted.row[k][i] : rays->origin.row[k][i];
    ray->org_x[i] = (float)rays->origin.row[0][i];
    ray->org_y[i] = (float)rays->origin.row[1][i];
    ray->org_z[i] = (float)rays->origin.row[2][i];
    ray->dir_x[i] = (float)rays->direction.row[0][i];
    ray->dir_y[i] = (float)rays->direction.row[1][i];
    ray->dir_z[i] = (float)rays->direction.row[2][i];
    ray->tfar[i] = INFINITY;
    rays->rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  }
}

/* How many lanes' paths go on in each way. */
typedef struct tally {
  uint32_t of[GLOSSY + 1];
} tally;

static tally count(const ways_on *by) {
  tally counts = {{0}};
  for (uint32_t i = 0; i < PACKET; i++) counts.of[by->of[i]]++;
  return counts;
}

int bounce_go_on(const tracer *made, packet *rays, const meetings *met, uint32_t bounce) {
  ways_on by;
  take_numbers(made, rays, bounce, &by);
  choose(rays, &by);
  const tally asked = count(&by);
  if (asked.of[SCATTERED] > 0) {
    vectors ways;
    lobe_cosine(&met->normal, &by.u, &ways);
    scatter(met, &ways, &by, rays);
  }
  if (asked.of[MIRRORED] > 0) {
    gloss(met, &by, rays);
    mirror(met, &by, rays);
  }
  const tally going = count(&by);
  rays->counts.bounce += going.of[SCATTERED];
  rays->counts.reflection += going.of[MIRRORED] + going.of[GLOSSY];
  set_rays(met, &by, rays);
  if (going.of[ENDS] == PACKET) return 0;
  traverse_closest(made, rays->valid, &rays->scattered, &rays->rays);
  return 1;
}

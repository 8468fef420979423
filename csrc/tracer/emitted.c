#include "emitted.h"

#include "direct.h"
#include "emitter.h"
#include "lobe.h"
#include "rows.h"
#include "vectorise.h"

/* Ways to the places, of length 1, from surface to surface. */
typedef struct ways_there {
  vectors toward;
  scalars distance;
  scalars reflected; /* what of the radiance along the way a glossy surface sends to the eye, in a steradian, less what
                      * rays will find */
} ways_there;

/* They end as far from the other surface as they start from this one. Marks the lanes in which the surfaces face each
 * other. */
ASC_VECTORISE static void turn_toward(const emitter_places *restrict places, const meetings *restrict met,
                                      packet *restrict rays, ways_there *restrict ways) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double point[3] = {places->point.row[0][i], places->point.row[1][i], places->point.row[2][i]};
    const double facing[3] = {places->normal.row[0][i], places->normal.row[1][i], places->normal.row[2][i]};
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double lift = larger(meeting_lift(point, places->slack.of[i]), places->least_lift.of[i]);
    double way[3];
    for (int k = 0; k < 3; k++) way[k] = point[k] + facing[k] * lift - met->lifted.row[k][i];
    const double distance = sqrt(dot(way, way)), length = distance > 0.0 ? distance : 1.0;
    for (int k = 0; k < 3; k++) way[k] /= length;
    for (int k = 0; k < 3; k++) ways->toward.row[k][i] = way[k];
    ways->distance.of[i] = distance;
    ways->reflected.of[i] = 0.0;
    rays->shadowed[i] = -((places->density.of[i] > 0.0) & (dot(normal, way) > 0.0) & (dot(facing, way) < 0.0));
  }
}

/* Of `lanes`, bits, whose surfaces have one lobe. */
ASC_VECTORISE static void take_reflected(emission_from from, const lobe_at *restrict lobe, uint32_t lanes,
                                         const packet *restrict rays, const emitter_places *restrict places,
                                         ways_there *restrict ways) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const int mine = (lanes >> i) & 1;
    const double found = emitted_share_of_rays(from, rays->mirror.of[i] * lobe->density.of[i], places->density.of[i]);
    const double reflected = lobe->value.of[i] * (1.0 - found);
    ways->reflected.of[i] = mine ? reflected : ways->reflected.of[i];
  }
}

/* Whether light from elsewhere than along the mirrored way comes to the eye by the reflection. */
static int is_glossy(const packet *rays, const meetings *met, uint32_t lane) {
  return rays->mirror.of[lane] > 0.0 && met->material[lane]->gloss.kind != ASC_LOBE_MIRROR;
}

static void find_reflected(const tracer *made, const packet *rays, const meetings *met, const emitter_places *places,
                           ways_there *ways) {
  uint32_t left = 0;
  for (uint32_t i = 0; i < PACKET; i++)
    if (rays->shadowed[i] && is_glossy(rays, met, i)) left |= UINT32_C(1) << i;
  while (left) {
    lobe_at lobe;
    const uint32_t lanes = meeting_alike(met->material, left);
    lobe_towards(&met->material[__builtin_ctz(lanes)]->gloss, &met->normal, &met->to_eye, &ways->toward, &lobe);
    take_reflected(made->transport.emission_from, &lobe, lanes, rays, places, ways);
    left &= ~lanes;
  }
}

/* What the places give where nothing is between; drops the shadow rays where that is nothing, and sets the others. */
ASC_VECTORISE static void weigh(const transport *restrict far, const meetings *restrict met,
                                const emitter_places *restrict places, const ways_there *restrict ways,
                                packet *restrict rays, vectors *restrict gives) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double way[3] = {ways->toward.row[0][i], ways->toward.row[1][i], ways->toward.row[2][i]};
    const double value = dot(normal, way) / ASC_PI, density = places->density.of[i];
    const double found = emitted_share_of_rays(far->emission_from, rays->scatter.of[i] * value, density);
    const double scattered = rays->scatters_left.of[i] > 0.0 ? value * (1.0 - found) : 0.0;
    double largest = 0.0;
    for (int channel = 0; channel < 3; channel++) {
      const double share =
          rays->throughput.row[channel][i] * (met->colour.row[channel][i] * met->albedo.row[channel][i] * scattered +
                                              met->reflection.row[channel][i] * ways->reflected.of[i]);
      const double given = share * places->radiance.row[channel][i] / (density > 0.0 ? density : 1.0);
      gives->row[channel][i] = given;
      largest = larger(largest, fabs(given));
    }
    rays->shadowed[i] = largest > 0.0 ? rays->shadowed[i] : 0;
    direct_set_shadow_ray(&rays->shadows, i, &met->lifted, way, ways->distance.of[i]);
  }
}

ASC_VECTORISE static void add_unblocked(packet *restrict rays, const vectors *restrict gives) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const int reaches = direct_reaches(rays, i);
    for (int channel = 0; channel < 3; channel++)
      rays->gathered.row[channel][i] += reaches ? gives->row[channel][i] : 0.0;
  }
}

void emitted_add(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context) {
  pairs u = {{{0.0}}};
  emitter_places places;
  ways_there ways;
  vectors gives;
  uint32_t there = 0;
  if (made->emitter_count == 0) return;
  for (uint32_t i = 0; i < PACKET; i++) {
    if (!met->material[i] || !(rays->scatter.of[i] > 0.0 || is_glossy(rays, met, i))) continue;
    there |= UINT32_C(1) << i;
    u.row[0][i] = rays->further[i][made->further.emitter];
    u.row[1][i] = rays->further[i][made->further.emitter + 1];
  }
  if (there == 0) return;
  emitter_choose(made, rays->time, &u, &met->lifted, there, &places);
  turn_toward(&places, met, rays, &ways);
  if (made->transport.mirror_bounces > 0) find_reflected(made, rays, met, &places, &ways);
  weigh(&made->transport, met, &places, &ways, rays, &gives);
  if (direct_trace_shadows(made, rays, &met->lifted, &ways.toward, ways.distance.of, context))
    add_unblocked(rays, &gives);
}

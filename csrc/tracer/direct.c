#include "direct.h"

#include "traverse.h"
#include "vectorise.h"

/* What the lanes' surfaces scatter of a light to the eye, but for its cosine. */
ASC_VECTORISE static void find_scattering(const packet *restrict rays, const meetings *restrict met,
                                          vectors *restrict shares) {
  for (uint32_t i = 0; i < PACKET; i++)
    for (int channel = 0; channel < 3; channel++)
      shares->row[channel][i] =
          rays->throughput.row[channel][i] * met->colour.row[channel][i] * met->albedo.row[channel][i];
}

/* Sets the shadow rays, and which lanes have one; gives what they weigh where nothing is between: the cosine and the
 * fall-off. */
ASC_VECTORISE static void set_shadow_rays(packet *restrict rays, const meetings *restrict met,
                                          const light_ways *restrict ways, scalars *restrict weights) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double toward[3] = {ways->toward.row[0][i], ways->toward.row[1][i], ways->toward.row[2][i]};
    const double cosine = dot(normal, toward), arriving = ways->arriving[i];
    weights->of[i] = cosine * arriving;
    rays->shadowed[i] = -((cosine > 0.0) & (arriving != 0.0));
    direct_set_shadow_ray(&rays->shadows, i, &met->lifted, toward, ways->distance[i]);
  }
}

ASC_VECTORISE static void add_unblocked(packet *restrict rays, const vectors *restrict shares,
                                        const double intensity[3], const scalars *restrict weights) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double weight = direct_reaches(rays, i) ? weights->of[i] : 0.0;
    for (int channel = 0; channel < 3; channel++)
      rays->gathered.row[channel][i] += shares->row[channel][i] * intensity[channel] * weight;
  }
}

int direct_trace_shadows(const tracer *made, packet *rays, const vectors *origin, const vectors *toward,
                         const double distance[PACKET], struct RTCIntersectContext *context) {
  int count = 0;
  for (uint32_t i = 0; i < PACKET && made->plane_count > 0; i++) {
    double from[3], way[3];
    if (!rays->shadowed[i]) continue;
    get_lane(origin, i, from);
    get_lane(toward, i, way);
    if (meeting_planes_block(made, rays->time[i], from, way, distance[i])) rays->shadowed[i] = 0;
  }
  for (uint32_t i = 0; i < PACKET; i++) count -= rays->shadowed[i];
  if (count > 0) traverse_any(made, rays->shadowed, context, &rays->shadows);
  rays->counts.shadow += (uint64_t)count;
  return count;
}

static void take_numbers(const packet *rays, uint32_t first, pairs *u) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const double *numbers = packet_numbers(rays, i) + first;
    u->row[0][i] = numbers[0];
    u->row[1][i] = numbers[1];
  }
}

static void add_light(const tracer *made, packet *rays, const light_source *from, const meetings *met,
                      const vectors *shares, struct RTCIntersectContext *context) {
  pairs u;
  light_ways ways;
  scalars weights;
  if (light_has_area(&from->given)) take_numbers(rays, from->numbers, &u);
  light_toward(from, &u, &met->point, &ways);
  set_shadow_rays(rays, met, &ways, &weights);
  if (direct_trace_shadows(made, rays, &met->lifted, &ways.toward, ways.distance, context))
    add_unblocked(rays, shares, from->given.intensity, &weights);
}

void direct_add_lights(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context) {
  vectors shares;
  if (made->light_count == 0) return;
  find_scattering(rays, met, &shares);
  for (size_t i = 0; i < made->light_count; i++) add_light(made, rays, &made->lights[i], met, &shares, context);
}

#include "direct.h"

#include "lobe.h"
#include "rows.h"

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

static void add_light(const tracer *made, packet *rays, const light_source *from, const meeting met[PACKET],
                      struct RTCIntersectContext *context) {
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
    meeting_lift(met[i].point, met[i].normal, met[i].slack, origin);
    if (meeting_planes_block(made, rays->time[i], origin, toward, distance)) continue;
    set_shadow_ray(rays, i, origin, toward, distance);
    rays->shadowed[i] = -1;
    count++;
  }
  if (count == 0) return;
  rays->counts.shadow += count;
  rtcOccluded16(rays->shadowed, made->scene, context, &rays->shadows);
  for (uint32_t i = 0; i < rays->lanes; i++) {
    if (!rays->shadowed[i] || rays->shadows.tfar[i] < 0.0f) continue; /* Embree sets tfar to -inf where it is blocked */
    const asc_material *material = met[i].material;
    for (int channel = 0; channel < 3; channel++)
      rays->radiance[i][channel] += rays->paths[i].throughput[channel] * met[i].colour[channel] *
                                    material->albedo[channel] * given->intensity[channel] * (cosine[i] * falloff[i]);
  }
}

void direct_add_lights(const tracer *made, packet *rays, const meeting met[PACKET],
                       struct RTCIntersectContext *context) {
  for (size_t i = 0; i < made->light_count; i++) add_light(made, rays, &made->lights[i], met, context);
}

double direct_share_of_rays(const tracer *made, double density_of_ray, double density_of_emitter) {
  if (!(density_of_emitter > 0.0) || made->transport.emission_from == FROM_RAYS) return 1.0;
  if (made->transport.emission_from == FROM_EMITTERS) return 0.0;
  return density_of_ray / (density_of_ray + density_of_emitter);
}

/* What of the radiance along a way reaches the eye, in a steradian, less what rays will find. */
static void weigh(const tracer *made, const packet *rays, uint32_t lane, const meeting *met, const double way[3],
                  double cosine, double density, double share[3]) {
  const path *from = &rays->paths[lane];
  const asc_material *material = met->material;
  double scattered = 0.0, reflected = 0.0;
  if (from->scatters_left > 0) {
    const double value = cosine / ASC_PI;
    scattered = value * (1.0 - direct_share_of_rays(made, from->scatter * value, density));
  }
  if (from->mirror > 0.0 && material->gloss.kind != ASC_LOBE_MIRROR) {
    double to_eye[3];
    const double *direction = rays->direction[lane], length = sqrt(dot(direction, direction));
    for (int i = 0; i < 3; i++) to_eye[i] = -direction[i] / length;
    const lobe_at towards = lobe_towards(&material->gloss, met->normal, to_eye, way);
    reflected = towards.value * (1.0 - direct_share_of_rays(made, from->mirror * towards.density, density));
  }
  for (int channel = 0; channel < 3; channel++)
    share[channel] = from->throughput[channel] * (met->colour[channel] * material->albedo[channel] * scattered +
                                                  material->reflection[channel] * reflected);
}

/* The shadow ray of a lane to a place on a surface that shines, and what that gives where nothing is between. Gives 0
 * where it is nothing. */
static int towards_emitter(const tracer *made, packet *rays, uint32_t lane, const meeting *met, double gives[3]) {
  emitter_place chosen;
  double origin[3], end[3], way[3], share[3];
  const path *from = &rays->paths[lane];
  if (!(from->mirror > 0.0) && !(from->scatter > 0.0)) return 0;
  meeting_lift(met->point, met->normal, met->slack, origin);
  const double *u = rays->further[lane] + made->further.emitter;
  if (!emitter_choose(made, rays->time[lane], u, origin, &chosen)) return 0;
  /* It ends as far from the other surface as it starts from this one. */
  meeting_lift(chosen.point, chosen.normal, chosen.slack, end);
  for (int i = 0; i < 3; i++) way[i] = end[i] - origin[i];
  const double distance = sqrt(dot(way, way));
  for (int i = 0; i < 3; i++) way[i] /= distance;
  const double cosine = dot(met->normal, way);
  if (!(cosine > 0.0) || !(dot(chosen.normal, way) < 0.0)) return 0;
  weigh(made, rays, lane, met, way, cosine, chosen.density, share);
  double largest = 0.0;
  for (int channel = 0; channel < 3; channel++) {
    gives[channel] = share[channel] * chosen.radiance[channel] / chosen.density;
    largest = fmax(largest, fabs(gives[channel]));
  }
  if (!(largest > 0.0) || meeting_planes_block(made, rays->time[lane], origin, way, distance)) return 0;
  set_shadow_ray(rays, lane, origin, way, distance);
  return 1;
}

void direct_add_emitters(const tracer *made, packet *rays, const meeting met[PACKET],
                         struct RTCIntersectContext *context) {
  double gives[PACKET][3];
  uint32_t count = 0;
  if (made->emitter_count == 0) return;
  for (uint32_t i = 0; i < PACKET; i++) {
    const int there = i < rays->lanes && met[i].material && towards_emitter(made, rays, i, &met[i], gives[i]);
    rays->shadowed[i] = there ? -1 : 0;
    count += (uint32_t)there;
  }
  if (count == 0) return;
  rays->counts.shadow += count;
  rtcOccluded16(rays->shadowed, made->scene, context, &rays->shadows);
  for (uint32_t i = 0; i < rays->lanes; i++) {
    if (!rays->shadowed[i] || rays->shadows.tfar[i] < 0.0f) continue;
    for (int channel = 0; channel < 3; channel++) rays->radiance[i][channel] += gives[i][channel];
  }
}

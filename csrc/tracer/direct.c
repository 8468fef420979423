#include "direct.h"

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

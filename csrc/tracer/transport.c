/* How far light is followed: read off what the scene's surfaces are made of. */
#include "transport.h"

#define BOUNCES_MOST 64

/* Whether a material's numbers can be; those of pattern and emission were looked at. */
static asc_status check_material(const asc_material *material, size_t number, asc_error *error) {
  const asc_pattern *pattern = &material->pattern;
  for (int channel = 0; channel < 3; channel++) {
    const double mirrored = material->reflection[channel];
    const double colour = pattern->kind == ASC_PATTERN_NONE ? 1.0 : fmax(pattern->low[channel], pattern->high[channel]);
    if (mirrored == 0.0) continue;
    if (!(mirrored > 0.0) || !(material->albedo[channel] * colour + mirrored <= 1.0))
      return asc_fail(error, ASC_INVALID_ARGUMENT,
                      "material %zu has a reflection that is negative, or above 1 with its albedo", number);
  }
  return ASC_OK;
}

static int is_there(const double share[3]) { return share[0] > 0.0 || share[1] > 0.0 || share[2] > 0.0; }

typedef struct found {
  int reflection;
} found;

/* Adds what the surfaces of one kind ask for. */
static void look_at(const tracer *made, const void *first, size_t stride, size_t count, found *asked) {
  for (size_t i = 0; i < count; i++) {
    const uint32_t index = *(const uint32_t *)(const void *)((const char *)first + i * stride);
    if (index >= made->material_count) continue; /* refused where the surfaces are taken */
    asked->reflection |= is_there(made->materials[index].reflection);
  }
}

asc_status transport_take(tracer *made, const asc_scene *scene, asc_error *error) {
  const asc_transport *given = &scene->transport;
  if (given->mirror_bounces > BOUNCES_MOST)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a path has at most %d mirror bounces, not %u", BOUNCES_MOST,
                    given->mirror_bounces);
  for (size_t i = 0; i < scene->material_count; i++) {
    const asc_status status = check_material(&scene->materials[i], i, error);
    if (status) return status;
  }
  found asked = {0};
  look_at(made, scene->triangle_material, sizeof(uint32_t), scene->triangle_count, &asked);
  if (scene->disc_count) look_at(made, &scene->discs[0].material, sizeof(asc_disc), scene->disc_count, &asked);
  if (scene->sphere_count) look_at(made, &scene->spheres[0].material, sizeof(asc_sphere), scene->sphere_count, &asked);
  if (scene->plane_count) look_at(made, &scene->planes[0].material, sizeof(asc_plane), scene->plane_count, &asked);
  made->transport.mirror_bounces = asked.reflection ? given->mirror_bounces : 0;
  made->transport.bounces = made->transport.mirror_bounces;
  if (made->transport.bounces > 0) made->plain = 0;
  return ASC_OK;
}

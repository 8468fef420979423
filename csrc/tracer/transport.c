/* How far light is followed: read off what the scene's surfaces are made of. */
#include "transport.h"

#define BOUNCES_MOST 64
#define ROULETTE_FROM 3

static asc_status check_gloss(const asc_lobe *gloss, size_t number, asc_error *error) {
  switch (gloss->kind) {
  case ASC_LOBE_MIRROR: return ASC_OK;
  case ASC_LOBE_PHONG:
    if (gloss->exponent >= 1.0 && gloss->exponent <= 1e6) return ASC_OK;
    return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has an exponent that is not 1 to 1e6", number);
  case ASC_LOBE_GGX:
    if (gloss->roughness >= 1e-3 && gloss->roughness <= 1.0) return ASC_OK;
    return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has a roughness that is not 1e-3 to 1", number);
  default:
    return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has an unknown lobe, %d", number, (int)gloss->kind);
  }
}

/* Whether a material's numbers can be; those of pattern and emission were looked at. */
static asc_status check_material(const asc_material *material, size_t number, int scatters, asc_error *error) {
  const asc_pattern *pattern = &material->pattern;
  for (int channel = 0; channel < 3; channel++) {
    const double mirrored = material->reflection[channel], albedo = material->albedo[channel];
    const double colour = pattern->kind == ASC_PATTERN_NONE ? 1.0 : fmax(pattern->low[channel], pattern->high[channel]);
    if (mirrored == 0.0 && !scatters) continue;
    if (!(mirrored >= 0.0) || !(albedo * colour + mirrored <= 1.0))
      return asc_fail(error, ASC_INVALID_ARGUMENT,
                      "material %zu has a reflection that is negative, or above 1 with its albedo", number);
    if (!(albedo >= 0.0)) return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has a negative albedo", number);
  }
  return check_gloss(&material->gloss, number, error);
}

static int is_there(const double share[3]) { return share[0] > 0.0 || share[1] > 0.0 || share[2] > 0.0; }

typedef struct found {
  int reflection, gloss, albedo, emission;
} found;

/* Adds what a surface of this material asks for. Those that are no place to send rays to only come to be met. */
static void look_at(const tracer *made, uint32_t index, int has_places, found *asked) {
  if (index >= made->material_count) return; /* refused where the surfaces are taken */
  const asc_material *material = &made->materials[index];
  asked->reflection |= is_there(material->reflection);
  asked->gloss |= is_there(material->reflection) && material->gloss.kind != ASC_LOBE_MIRROR;
  asked->albedo |= is_there(material->albedo);
  asked->emission |= has_places && is_there(material->emission);
}

static int changes_shape(const asc_scene *scene, size_t triangle) {
  const uint32_t motion = scene->triangle_motion ? scene->triangle_motion[triangle] : 0;
  return motion > 0 && motion <= scene->motion_count && scene->motions[motion - 1].kind == ASC_MOTION_FRAMES;
}

static found look_at_all(const tracer *made, const asc_scene *scene) {
  found asked = {0};
  for (size_t i = 0; i < scene->triangle_count; i++)
    look_at(made, scene->triangle_material[i], !changes_shape(scene, i), &asked);
  for (size_t i = 0; i < scene->disc_count; i++) look_at(made, scene->discs[i].material, 1, &asked);
  for (size_t i = 0; i < scene->sphere_count; i++) look_at(made, scene->spheres[i].material, 1, &asked);
  for (size_t i = 0; i < scene->plane_count; i++) look_at(made, scene->planes[i].material, 0, &asked);
  return asked;
}

asc_status transport_take(tracer *made, const asc_scene *scene, asc_error *error) {
  const asc_transport *given = &scene->transport;
  transport *far = &made->transport;
  if (given->mirror_bounces > BOUNCES_MOST || given->diffuse_bounces > BOUNCES_MOST)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a path has at most %d mirror bounces, and as many diffuse ones",
                    BOUNCES_MOST);
  for (size_t i = 0; i < scene->material_count; i++) {
    const asc_status status = check_material(&scene->materials[i], i, given->diffuse_bounces > 0, error);
    if (status) return status;
  }
  const found asked = look_at_all(made, scene);
  far->mirror_bounces = asked.reflection ? given->mirror_bounces : 0;
  far->diffuse_bounces = asked.albedo ? given->diffuse_bounces : 0;
  far->bounces = far->mirror_bounces + far->diffuse_bounces;
  far->spreads = far->diffuse_bounces > 0 || (far->mirror_bounces > 0 && asked.gloss);
  far->samples_emitters = far->spreads && asked.emission;
  far->roulette_from = ROULETTE_FROM;
  if (far->bounces > 0) made->plain = 0;
  return ASC_OK;
}

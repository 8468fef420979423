#include "validate.h"

#include <math.h>

#include "lighting.h"
#include "target.h"

static bool usable(const double *numbers, size_t count) {
  for (size_t i = 0; i < count; ++i) {
    if (!(fabs(numbers[i]) <= RASTER_LARGEST_NUMBER)) { /* a NaN compares false */
      return false;
    }
  }
  return true;
}

static double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static asc_status bad_number(asc_error *error, const char *what, size_t index) {
  return asc_fail(error, ASC_INVALID_ARGUMENT, "%s %zu has a number that is not finite or is beyond 1e30", what, index);
}

static asc_status check_frame(const asc_view *view, asc_error *error) {
  const double *axes[3] = {view->right, view->up, view->forward};
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      /* Loose: what it catches is axes that were never normalised, not their rounding. */
      if (!(fabs(dot(axes[i], axes[j]) - (i == j ? 1.0 : 0.0)) <= 1e-6)) {
        return asc_fail(error, ASC_INVALID_ARGUMENT, "right, up and forward of the view are not orthonormal");
      }
    }
  }
  return ASC_OK;
}

static asc_status check_view(const asc_view *view, asc_error *error) {
  if (view->projection != ASC_ORTHOGRAPHIC && view->projection != ASC_PERSPECTIVE) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the view has an unknown projection, %d", (int)view->projection);
  }
  if (view->width < 1 || view->height < 1 || view->width > RASTER_LARGEST_SIDE || view->height > RASTER_LARGEST_SIDE) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a picture of %u x %u pixels: each side is 1 to %u", view->width,
                    view->height, RASTER_LARGEST_SIDE);
  }
  if (!usable(view->eye, 3) || !usable(view->background, 3)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the view's eye or background is not finite or is beyond 1e30");
  }
  if (!usable(&view->half_width, 1) || !usable(&view->half_height, 1) || !(view->half_width > 0.0) ||
      !(view->half_height > 0.0)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "half_width and half_height of the view must be positive and finite");
  }
  if (!usable(view->shift, 2)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the shift of the view is not finite or is beyond 1e30");
  }
  if (!usable(&view->lens_radius, 1) || view->lens_radius < 0.0) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the radius of a lens is not negative, and finite");
  }
  if (view->lens_radius > 0.0 &&
      (view->projection != ASC_PERSPECTIVE || !usable(&view->focus_distance, 1) || !(view->focus_distance > 0.0))) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a lens has a perspective view, focused at a positive distance");
  }
  return check_frame(view, error);
}

static asc_status check_materials(const asc_scene *scene, asc_error *error) {
  if (scene->transport.diffuse_bounces > 0) {
    return asc_fail(error, ASC_UNSUPPORTED, "the scene has diffuse bounces, which are not drawn");
  }
  for (size_t i = 0; i < scene->material_count; ++i) {
    const asc_material *material = &scene->materials[i];
    const asc_pattern *pattern = &material->pattern;
    if (pattern->kind != ASC_PATTERN_NONE && pattern->kind != ASC_PATTERN_ZONE_PLATE &&
        pattern->kind != ASC_PATTERN_CHECKER) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has an unknown pattern, %d", i, (int)pattern->kind);
    }
    bool fine = usable(material->emission, 3) && usable(material->albedo, 3);
    if (pattern->kind != ASC_PATTERN_NONE) {
      fine = fine && usable(&pattern->scale, 1) && usable(pattern->origin, 3) && usable(pattern->low, 3) &&
             usable(pattern->high, 3);
    }
    if (!fine) {
      return bad_number(error, "material", i);
    }
    for (int channel = 0; channel < 3; ++channel) {
      if (material->reflection[channel] != 0.0) {
        return asc_fail(error, ASC_UNSUPPORTED, "material %zu mirrors, which is not drawn", i);
      }
    }
  }
  return ASC_OK;
}

static asc_status check_material_index(const asc_scene *scene, const char *what, size_t index, uint32_t material,
                                       asc_error *error) {
  if (material >= scene->material_count) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "%s %zu names material %u, and there are %zu", what, index, material,
                    scene->material_count);
  }
  return ASC_OK;
}

static asc_status check_triangles(const asc_scene *scene, asc_error *error) {
  for (size_t i = 0; i < scene->triangle_count; ++i) {
    if (!usable(scene->vertices + 9 * i, 9)) {
      return bad_number(error, "triangle", i);
    }
    asc_status status = check_material_index(scene, "triangle", i, scene->triangle_material[i], error);
    if (status != ASC_OK) {
      return status;
    }
  }
  return ASC_OK;
}

static bool is_zero(const double *v) { return v[0] == 0.0 && v[1] == 0.0 && v[2] == 0.0; }

static asc_status check_round(const asc_scene *scene, asc_error *error) {
  for (size_t i = 0; i < scene->disc_count; ++i) {
    const asc_disc *disc = &scene->discs[i];
    if (!usable(disc->centre, 3) || !usable(disc->normal, 3) || !usable(&disc->radius, 1)) {
      return bad_number(error, "disc", i);
    }
    if (!(disc->radius > 0.0) || is_zero(disc->normal)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "disc %zu needs a positive radius and a normal that is not 0", i);
    }
    asc_status status = check_material_index(scene, "disc", i, disc->material, error);
    if (status != ASC_OK) {
      return status;
    }
  }
  for (size_t i = 0; i < scene->sphere_count; ++i) {
    const asc_sphere *sphere = &scene->spheres[i];
    if (!usable(sphere->centre, 3) || !usable(&sphere->radius, 1)) {
      return bad_number(error, "sphere", i);
    }
    if (!(sphere->radius > 0.0)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "sphere %zu needs a positive radius", i);
    }
    asc_status status = check_material_index(scene, "sphere", i, sphere->material, error);
    if (status != ASC_OK) {
      return status;
    }
  }
  return ASC_OK;
}

static asc_status check_planes(const asc_scene *scene, asc_error *error) {
  for (size_t i = 0; i < scene->plane_count; ++i) {
    const asc_plane *plane = &scene->planes[i];
    if (!usable(plane->point, 3) || !usable(plane->normal, 3)) {
      return bad_number(error, "plane", i);
    }
    if (is_zero(plane->normal)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "plane %zu needs a normal that is not 0", i);
    }
    asc_status status = check_material_index(scene, "plane", i, plane->material, error);
    if (status != ASC_OK) {
      return status;
    }
  }
  return ASC_OK;
}

/* Whether a light has the extent that its kind asks for. */
static bool has_extent(const asc_light *light) {
  const double *a = light->edges[0];
  const double *b = light->edges[1];
  if (light->kind == ASC_LIGHT_SPHERE) {
    return usable(&light->radius, 1) && light->radius > 0.0;
  }
  if (!lighting_has_area(light)) {
    return true;
  }
  const double across[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  return usable(a, 3) && usable(b, 3) && !is_zero(across);
}

static asc_status check_lights(const asc_scene *scene, asc_error *error) {
  for (size_t i = 0; i < scene->light_count; ++i) {
    const asc_light *light = &scene->lights[i];
    if (light->kind != ASC_LIGHT_POINT && light->kind != ASC_LIGHT_DIRECTIONAL && !lighting_has_area(light)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has an unknown kind, %d", i, (int)light->kind);
    }
    if (!usable(light->place, 3) || !usable(light->intensity, 3)) {
      return bad_number(error, "light", i);
    }
    if (!has_extent(light)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has no area, or one that is not finite", i);
    }
    if (light->kind == ASC_LIGHT_DIRECTIONAL && is_zero(light->place)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu needs a direction that is not 0", i);
    }
    if (light->inverse_square > 1) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu: inverse_square is 0 or 1, not %u", i,
                      light->inverse_square);
    }
  }
  return ASC_OK;
}

/* Division, as products and sums of counts may not fit. */
static asc_status check_shadows(const asc_scene *scene, asc_error *error) {
  if (!lighting_is_needed(scene)) {
    return ASC_OK;
  }
  const size_t most = RASTER_MOST_SHADOW_TESTS / scene->light_count;
  const size_t counts[4] = {scene->triangle_count, scene->disc_count, scene->sphere_count, scene->plane_count};
  size_t left = most;
  for (int i = 0; i < 4; ++i) {
    if (counts[i] > left) {
      return asc_fail(error, ASC_UNSUPPORTED,
                      "shadows are tested surface by surface for each light, at most %d tests a pixel: with %zu lights "
                      "%zu surfaces, and the scene has %zu triangles, %zu discs, %zu spheres, %zu planes",
                      RASTER_MOST_SHADOW_TESTS, scene->light_count, most, counts[0], counts[1], counts[2], counts[3]);
    }
    left -= counts[i];
  }
  return ASC_OK;
}

static asc_status check_motion_indices(const asc_scene *scene, const uint32_t *motions, size_t count, bool triangles,
                                       asc_error *error) {
  for (size_t i = 0; motions && i < count; ++i) {
    if (motions[i] > scene->motion_count) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "a surface names motion %u of %zu", motions[i], scene->motion_count);
    }
    if (!triangles && motions[i] > 0 && scene->motions[motions[i] - 1].kind == ASC_MOTION_FRAMES) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "a motion of frames moves triangles, and no other surface");
    }
  }
  return ASC_OK;
}

/* Frames move triangles alone, which have no pattern: it would be stretched with them. */
static asc_status check_frames(const asc_scene *scene, size_t index, asc_error *error) {
  const asc_motion *motion = &scene->motions[index];
  const uint32_t named = (uint32_t)index + 1;
  size_t count = 0;
  for (size_t i = 0; scene->triangle_motion && i < scene->triangle_count; ++i) {
    if (scene->triangle_motion[i] != named) {
      continue;
    }
    ++count;
    if (scene->materials[scene->triangle_material[i]].pattern.kind != ASC_PATTERN_NONE) {
      return asc_fail(error, ASC_UNSUPPORTED, "triangle %zu has a pattern and a motion of frames, which is not drawn",
                      i);
    }
  }
  if (!motion->frames || motion->frame_count < 1 || motion->frame_triangles != count) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu has %zu frames of %zu triangles, and %zu name it", index,
                    motion->frames ? motion->frame_count : 0, motion->frame_triangles, count);
  }
  for (size_t i = 0; i < motion->frame_count; ++i) {
    if (!usable(motion->frames + 9 * count * i, 9 * count)) {
      return bad_number(error, "motion", index);
    }
  }
  return ASC_OK;
}

static asc_status check_motion(const asc_scene *scene, size_t index, asc_error *error) {
  const asc_motion *motion = &scene->motions[index];
  bool fine = false;
  switch (motion->kind) {
  case ASC_MOTION_FRAMES: return check_frames(scene, index, error);
  case ASC_MOTION_TRANSLATE: fine = usable(motion->by, 3); break;
  case ASC_MOTION_ROTATE:
    if (is_zero(motion->axis)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "motion %zu needs an axis that is not 0", index);
    }
    fine = usable(motion->axis, 3) && usable(motion->centre, 3) && usable(&motion->angle, 1);
    break;
  default:
    return asc_fail(error, ASC_UNSUPPORTED, "motion %zu is of a kind that is not drawn, %d", index, (int)motion->kind);
  }
  return fine ? ASC_OK : bad_number(error, "motion", index);
}

static asc_status check_motions(const asc_scene *scene, asc_error *error) {
  if (scene->motion_count == 0) {
    return ASC_OK; /* nothing is looked up */
  }
  const uint32_t *motions[4] = {scene->triangle_motion, scene->disc_motion, scene->sphere_motion, scene->plane_motion};
  const size_t counts[4] = {scene->triangle_count, scene->disc_count, scene->sphere_count, scene->plane_count};
  for (size_t i = 0; i < scene->motion_count; ++i) {
    asc_status status = check_motion(scene, i, error);
    if (status != ASC_OK) {
      return status;
    }
  }
  for (int kind = 0; kind < 4; ++kind) {
    asc_status status = check_motion_indices(scene, motions[kind], counts[kind], kind == 0, error);
    if (status != ASC_OK) {
      return status;
    }
  }
  return ASC_OK;
}

static bool arrays_are_there(const asc_scene *scene) {
  return (scene->material_count == 0 || scene->materials) &&
         (scene->triangle_count == 0 || (scene->vertices && scene->triangle_material)) &&
         (scene->disc_count == 0 || scene->discs) && (scene->sphere_count == 0 || scene->spheres) &&
         (scene->plane_count == 0 || scene->planes) && (scene->light_count == 0 || scene->lights) &&
         (scene->motion_count == 0 || scene->motions);
}

asc_status raster_validate(const asc_scene *scene, asc_error *error) {
  if (!scene || scene->struct_size < sizeof *scene) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "no scene, or its struct_size is not set");
  }
  if (!arrays_are_there(scene)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "the scene counts surfaces, materials, lights or motions whose array is NULL");
  }
  asc_status status = check_view(&scene->view, error);
  if (status == ASC_OK) {
    status = check_materials(scene, error);
  }
  if (status == ASC_OK) {
    status = check_triangles(scene, error);
  }
  if (status == ASC_OK) {
    status = check_round(scene, error);
  }
  if (status == ASC_OK) {
    status = check_planes(scene, error);
  }
  if (status == ASC_OK) {
    status = check_lights(scene, error);
  }
  if (status == ASC_OK) {
    status = check_motions(scene, error);
  }
  if (status == ASC_OK) {
    status = check_shadows(scene, error);
  }
  return status;
}

static asc_status check_pass(const raster_desc *desc, const pass_choices *varies, size_t i, asc_error *error) {
  const double *o = desc->offsets + 2 * i;
  if (!(o[0] >= 0.0 && o[0] < 1.0 && o[1] >= 0.0 && o[1] < 1.0)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "pass %zu has the offset (%g, %g): both lie in [0, 1)", i, o[0], o[1]);
  }
  if (!isfinite(desc->weights[i])) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "pass %zu has a weight that is not finite", i);
  }
  if (desc->times && !usable(desc->times + i, 1)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "pass %zu has a time that is not finite or is beyond 1e30", i);
  }
  /* A little more than the radius, for the rounding of what lies on the rim. */
  if (desc->lens && !(hypot(desc->lens[2 * i], desc->lens[2 * i + 1]) <= (1.0 + 1e-12) * varies->lens_radius)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "pass %zu looks from (%g, %g), beyond a lens of radius %g", i,
                    desc->lens[2 * i], desc->lens[2 * i + 1], varies->lens_radius);
  }
  for (size_t k = 0; desc->lights && k < 2 * varies->area_lights; ++k) {
    const double u = desc->lights[2 * varies->area_lights * i + k];
    if (!(u >= 0.0 && u < 1.0)) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "pass %zu has %g for the point of a light: it lies in [0, 1)", i, u);
    }
  }
  return ASC_OK;
}

asc_status raster_validate_desc(const raster_desc *desc, const pass_choices *varies, asc_error *error) {
  if (!desc || desc->struct_size < sizeof *desc) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "no desc, or its struct_size is not set");
  }
  if (desc->samples_per_pass != 1 && desc->samples_per_pass != MULTISAMPLES) {
    return asc_fail(error, ASC_UNSUPPORTED, "%u samples a pass: llvmpipe has 1 or 4", desc->samples_per_pass);
  }
  if (desc->sample_shading > 1) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "sample_shading is 0 or 1, not %u", desc->sample_shading);
  }
  if (desc->pass_count < 1 || !desc->offsets || !desc->weights) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a picture needs one pass at least, with its offset and weight");
  }
  const bool there = (varies->lens_radius > 0.0) == (desc->lens != NULL) && varies->time == (desc->times != NULL) &&
                     (varies->area_lights > 0) == (desc->lights != NULL);
  if (!there) {
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "passes have points of the lens, times and points of lights where the scene has a lens, moves and "
                    "has lights with an area, and else not");
  }
  for (size_t i = 0; i < desc->pass_count; ++i) {
    asc_status status = check_pass(desc, varies, i, error);
    if (status != ASC_OK) {
      return status;
    }
  }
  return ASC_OK;
}

#include "validate.h"

#include <math.h>
#include <stdbool.h>

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
  return check_frame(view, error);
}

static asc_status check_materials(const asc_scene *scene, asc_error *error) {
  for (size_t i = 0; i < scene->material_count; ++i) {
    const asc_material *material = &scene->materials[i];
    const asc_pattern *pattern = &material->pattern;
    if (pattern->kind != ASC_PATTERN_NONE && pattern->kind != ASC_PATTERN_ZONE_PLATE) {
      return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has an unknown pattern, %d", i, (int)pattern->kind);
    }
    bool fine = usable(material->emission, 3);
    if (pattern->kind != ASC_PATTERN_NONE) {
      fine = fine && usable(&pattern->scale, 1) && usable(pattern->origin, 3) && usable(pattern->low, 3) &&
             usable(pattern->high, 3);
    }
    if (!fine) {
      return bad_number(error, "material", i);
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

static asc_status check_round(const asc_scene *scene, asc_error *error) {
  for (size_t i = 0; i < scene->disc_count; ++i) {
    const asc_disc *disc = &scene->discs[i];
    if (!usable(disc->centre, 3) || !usable(disc->normal, 3) || !usable(&disc->radius, 1)) {
      return bad_number(error, "disc", i);
    }
    if (!(disc->radius > 0.0) || (disc->normal[0] == 0.0 && disc->normal[1] == 0.0 && disc->normal[2] == 0.0)) {
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

static bool arrays_are_there(const asc_scene *scene) {
  return (scene->material_count == 0 || scene->materials) &&
         (scene->triangle_count == 0 || (scene->vertices && scene->triangle_material)) &&
         (scene->disc_count == 0 || scene->discs) && (scene->sphere_count == 0 || scene->spheres);
}

asc_status raster_validate(const asc_scene *scene, asc_error *error) {
  if (!scene || scene->struct_size < sizeof *scene) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "no scene, or its struct_size is not set");
  }
  if (!arrays_are_there(scene)) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the scene counts surfaces or materials whose array is NULL");
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
  return status;
}

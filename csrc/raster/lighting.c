#include "lighting.h"

#include <stdlib.h>
#include <string.h>

#include "concentric.h"

bool lighting_takes(const asc_material *material) {
  return material->albedo[0] != 0.0 || material->albedo[1] != 0.0 || material->albedo[2] != 0.0;
}

bool lighting_is_needed(const asc_scene *scene) {
  if (scene->light_count == 0) {
    return false;
  }
  for (size_t i = 0; i < scene->material_count; ++i) {
    if (lighting_takes(&scene->materials[i])) {
      return true;
    }
  }
  return false;
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(const double a[3], const double b[3], double product[3]) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

bool lighting_has_area(const asc_light *given) {
  return given->kind == ASC_LIGHT_PARALLELOGRAM || given->kind == ASC_LIGHT_DISC || given->kind == ASC_LIGHT_SPHERE;
}

static void add_four(lighting *made, const double xyz[3], double w) {
  occluder_four *fresh = &made->occluders[made->occluder_fours++];
  memcpy(fresh->xyzw, xyz, 3 * sizeof xyz[0]);
  fresh->xyzw[3] = w;
}

static void add_plane(lighting *made, const camera *eye, const double world_normal[3], const double point[3]) {
  double normal[3];
  camera_direction(eye, world_normal, normal);
  make_unit(normal);
  add_four(made, normal, dot(normal, point));
}

static void add_triangle(lighting *made, const camera *eye, const double *corners) {
  double p[3][3];
  for (size_t i = 0; i < 3; ++i) {
    camera_point(eye, corners + 3 * i, p[i]);
  }
  double e[3];
  double f[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = p[1][i] - p[0][i];
    f[i] = p[2][i] - p[0][i];
  }
  double n[3];
  cross(e, f, n);
  double square = dot(n, n);
  if (!(square > 0.0)) {
    made->occluder_fours += 3; /* which are 0 */
    return;
  }
  /* u is 1 along e and 0 along f, v the other way round. */
  double u[3];
  double v[3];
  cross(f, n, u);
  cross(n, e, v);
  for (int i = 0; i < 3; ++i) {
    u[i] /= square;
    v[i] /= square;
  }
  make_unit(n);
  add_four(made, n, dot(n, p[0]));
  add_four(made, u, -dot(u, p[0]));
  add_four(made, v, -dot(v, p[0]));
}

static void add_occluders(lighting *made, const asc_scene *scene, const camera *eye) {
  double place[3];
  for (size_t i = 0; i < scene->sphere_count; ++i) {
    camera_point(eye, scene->spheres[i].centre, place);
    add_four(made, place, scene->spheres[i].radius);
  }
  for (size_t i = 0; i < scene->plane_count; ++i) {
    camera_point(eye, scene->planes[i].point, place);
    add_plane(made, eye, scene->planes[i].normal, place);
  }
  for (size_t i = 0; i < scene->disc_count; ++i) {
    camera_point(eye, scene->discs[i].centre, place);
    add_four(made, place, scene->discs[i].radius);
    add_plane(made, eye, scene->discs[i].normal, place);
  }
  made->counts.spheres = scene->sphere_count;
  made->counts.planes = scene->plane_count;
  made->counts.discs = scene->disc_count;
  made->counts.triangles = scene->triangle_count;
  for (size_t i = 0; i < scene->triangle_count; ++i) {
    add_triangle(made, eye, scene->vertices + 9 * i);
  }
}

/* The point of a light that the numbers choose, uniform by area; of a sphere the place on a disc that the shader takes
 * to the part of it that is seen. */
static void choose_point(const asc_light *from, const camera *eye, const double *numbers, light_record *to) {
  double along[2] = {numbers[0], numbers[1]};
  if (from->kind != ASC_LIGHT_PARALLELOGRAM) {
    (void)asc_to_disc(numbers, along);
  }
  if (from->kind == ASC_LIGHT_SPHERE) {
    const double extent[4] = {along[0], along[1], from->radius, LIGHT_BALL};
    memcpy(to->extent, extent, sizeof extent);
    camera_point(eye, from->place, to->place);
    return;
  }
  double chosen[3];
  double normal[3];
  for (int i = 0; i < 3; ++i) {
    chosen[i] = from->place[i] + along[0] * from->edges[0][i] + along[1] * from->edges[1][i];
  }
  camera_point(eye, chosen, to->place);
  cross(from->edges[0], from->edges[1], normal);
  camera_direction(eye, normal, to->extent);
  make_unit(to->extent);
  to->extent[3] = LIGHT_FACE;
}

static void add_lights(lighting *made, const asc_scene *scene, const camera *eye, const double *numbers) {
  static const double middle[2] = {0.5, 0.5};
  for (size_t i = 0; i < scene->light_count; ++i) {
    const asc_light *from = &scene->lights[i];
    light_record *to = &made->lights[i];
    memcpy(to->intensity, from->intensity, sizeof from->intensity);
    if (from->kind != ASC_LIGHT_DIRECTIONAL) {
      to->place[3] = 1.0;
      to->intensity[3] = from->inverse_square ? 1.0 : 0.0;
    }
    if (from->kind == ASC_LIGHT_POINT) {
      camera_point(eye, from->place, to->place);
      continue;
    }
    if (lighting_has_area(from)) {
      choose_point(from, eye, numbers ? numbers : middle, to);
      numbers += numbers ? 2 : 0;
      made->counts.any_area = true;
      continue;
    }
    camera_direction(eye, from->place, to->place);
    make_unit(to->place);
    for (int k = 0; k < 3; ++k) {
      to->place[k] = -to->place[k];
    }
  }
  made->counts.lights = scene->light_count;
}

asc_status lighting_create(const asc_scene *scene, const camera *eye, const double *numbers, lighting *made,
                           asc_error *error) {
  memset(made, 0, sizeof *made);
  if (!lighting_is_needed(scene)) {
    return ASC_OK;
  }
  size_t fours = scene->sphere_count + scene->plane_count + 2 * scene->disc_count + 3 * scene->triangle_count;
  made->lights = calloc(scene->light_count, sizeof *made->lights);
  made->occluders = calloc(fours + 1, sizeof *made->occluders);
  if (!made->lights || !made->occluders) {
    lighting_destroy(made);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu lights", scene->light_count);
  }
  add_lights(made, scene, eye, numbers);
  add_occluders(made, scene, eye);
  return ASC_OK;
}

void lighting_destroy(lighting *made) {
  free(made->lights);
  free(made->occluders);
  memset(made, 0, sizeof *made);
}

/* View, materials and lights: copied, checked, moved to the camera. */
#include <stdlib.h>

#include "transport.h"

void tracer_to_camera_direction(const asc_view *view, const double world[3], double camera[3]) {
  camera[0] = dot(world, view->right);
  camera[1] = dot(world, view->up);
  camera[2] = dot(world, view->forward);
}

void tracer_to_camera(const asc_view *view, const double world[3], double camera[3]) {
  const double moved[3] = {world[0] - view->eye[0], world[1] - view->eye[1], world[2] - view->eye[2]};
  tracer_to_camera_direction(view, moved, camera);
}

static asc_status take_view(tracer *made, const asc_view *view, asc_error *error) {
  made->view = *view;
  if (view->width < 1 || view->height < 1 || view->width > 16384 || view->height > 16384)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a picture has 1 to 16384 pixels a side, not %u x %u", view->width,
                    view->height);
  if (!finite3(view->eye) || !finite3(view->right) || !finite3(view->up) || !finite3(view->forward) ||
      !finite3(view->background) || !(view->half_width > 0.0) || !(view->half_height > 0.0) ||
      !isfinite(view->half_width) || !isfinite(view->half_height) || !isfinite(view->shift[0]) ||
      !isfinite(view->shift[1]))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the view has a number that is not finite, or no extent");
  if (!(view->shutter_open <= view->shutter_close) || !isfinite(view->shutter_open) || !isfinite(view->shutter_close) ||
      (view->response != ASC_RESPONSE_BOX && view->response != ASC_RESPONSE_TRIANGLE))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a shutter closes no sooner than it opens, with a known response");
  if (!(view->lens_radius >= 0.0) || !isfinite(view->lens_radius))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "the radius of a lens is not negative, and finite");
  if (view->lens_radius == 0.0) return ASC_OK;
  if (view->projection != ASC_PERSPECTIVE || !(view->focus_distance > 0.0) || !isfinite(view->focus_distance))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a lens has a perspective view, focused at a positive distance");
  if (view->blades == 1 || view->blades == 2 || view->blades > 64)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a lens has 3 to 64 blades, or 0 where it is round, not %u",
                    view->blades);
  lens_make(view, &made->lens);
  return ASC_OK;
}

static asc_status take_materials(tracer *made, const asc_scene *scene, asc_error *error) {
  made->material_count = scene->material_count;
  made->materials = calloc(scene->material_count + 1, sizeof *made->materials);
  if (!made->materials) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < scene->material_count; i++) {
    asc_material *material = &made->materials[i];
    *material = scene->materials[i];
    asc_pattern *pattern = &material->pattern;
    if (!finite3(material->emission) || !finite3(material->albedo) || !finite3(material->reflection) ||
        !finite3(pattern->origin) || !finite3(pattern->low) || !finite3(pattern->high) || !isfinite(pattern->scale))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "material %zu has a number that is not finite", i);
    if (pattern->kind == ASC_PATTERN_NONE) continue;
    made->plain = 0;
    made->has_patterns = 1;
    for (int axis = 0; axis < 3; axis++) pattern->origin[axis] -= scene->view.eye[axis];
    if (pattern->kind != ASC_PATTERN_ZONE_PLATE) continue;
    const double from_eye[3] = {pattern->origin[0], pattern->origin[1], pattern->origin[2]};
    tracer_to_camera_direction(&made->view, from_eye, pattern->origin);
  }
  return ASC_OK;
}

/* The extent of a light in the camera frame. */
static asc_status take_area(const tracer *made, const asc_light *world, light_source *into, size_t number,
                            asc_error *error) {
  if (world->kind == ASC_LIGHT_SPHERE) {
    if (world->radius > 0.0 && isfinite(world->radius)) return ASC_OK;
    return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has no radius", number);
  }
  if (world->kind != ASC_LIGHT_PARALLELOGRAM && world->kind != ASC_LIGHT_DISC)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has an unknown kind, %d", number, (int)world->kind);
  const double *a = world->edges[0], *b = world->edges[1];
  double normal[3];
  cross(a, b, normal);
  const double length = sqrt(dot(normal, normal));
  if (!(length > 0.0) || !isfinite(length))
    return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has no area", number);
  tracer_to_camera_direction(&made->view, normal, into->normal);
  for (int i = 0; i < 3; i++) into->normal[i] /= length;
  for (int i = 0; i < 2; i++) tracer_to_camera_direction(&made->view, world->edges[i], into->given.edges[i]);
  return ASC_OK;
}

static asc_status take_lights(tracer *made, const asc_scene *scene, asc_error *error) {
  asc_status status;
  made->light_count = scene->light_count;
  made->lights = calloc(scene->light_count + 1, sizeof *made->lights);
  if (!made->lights) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < scene->light_count; i++) {
    light_source *into = &made->lights[i];
    into->given = scene->lights[i];
    asc_light *given = &into->given;
    made->plain = 0;
    if (!finite3(given->place) || !finite3(given->intensity))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has a number that is not finite", i);
    status = light_has_area(given) ? take_area(made, &scene->lights[i], into, i, error) : ASC_OK;
    if (status) return status;
    if (given->kind != ASC_LIGHT_DIRECTIONAL) {
      tracer_to_camera(&made->view, scene->lights[i].place, given->place);
      continue;
    }
    tracer_to_camera_direction(&made->view, scene->lights[i].place, given->place);
    const double length = sqrt(dot(given->place, given->place));
    if (!(length > 0.0) || !isfinite(length))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "light %zu has no direction", i);
    for (int axis = 0; axis < 3; axis++) given->place[axis] /= -length;
  }
  return ASC_OK;
}

/* Gives the next group of a sample's numbers its place, `at` from the third number on (NULL: the group is the first two
 * themselves). */
static int add_group(layout *to, uint32_t size, uint32_t *at) {
  uint32_t *groups = realloc(to->groups, (to->group_count + 1) * sizeof *groups);
  if (!groups) return 0;
  to->groups = groups;
  groups[to->group_count++] = size;
  if (!at) return 1;
  *at = to->count;
  to->count += size;
  return 1;
}

/* The one place that says what a sample has numbers for, and in which order; tracer.h tells it. */
static asc_status lay_out(tracer *made, asc_error *error) {
  layout *further = &made->further;
  const transport *far = &made->transport;
  int there = add_group(further, 2, NULL);
  if (made->motion_count > 0) there = there && add_group(further, 1, &further->time);
  if (made->view.lens_radius > 0.0) there = there && add_group(further, 2, &further->lens);
  for (size_t i = 0; i < made->light_count; i++)
    if (light_has_area(&made->lights[i].given)) there = there && add_group(further, 2, &made->lights[i].numbers);
  if (far->samples_emitters) there = there && add_group(further, 2, &further->emitter);
  further->bounces = further->count;
  further->bounce = (far->diffuse_bounces ? 1U : 0U) + (far->spreads ? 2U : 0U);
  for (uint32_t i = 0; i < far->bounces; i++) {
    uint32_t at;
    if (far->diffuse_bounces) there = there && add_group(further, 1, &at);
    if (far->spreads) there = there && add_group(further, 2, &at);
  }
  return there ? ASC_OK : asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
}

asc_status tracer_take_appearance(tracer *made, const asc_scene *scene, asc_error *error) {
  made->plain = scene->plane_count == 0;
  asc_status status = take_view(made, &scene->view, error);
  if (status == ASC_OK) status = take_materials(made, scene, error);
  if (status == ASC_OK) status = take_lights(made, scene, error);
  if (status == ASC_OK) status = transport_take(made, scene, error);
  if (status == ASC_OK) status = tracer_take_motions(made, scene, error);
  if (status == ASC_OK) status = lay_out(made, error);
  made->shines_alone =
      made->light_count == 0 && made->transport.bounces == 0 && made->motion_count == 0 && made->ahead == 0.0;
  return status;
}

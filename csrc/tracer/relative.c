#include "relative.h"

#include <stdlib.h>
#include <string.h>

#include "frames.h"
#include "kept.h"

/* The largest coordinate becomes one of this size or up to half of it, so that products of three of them are floats,
 * and of what is 2^70 times smaller still. Only exponents change: no bit of a picture where none was lost. */
#define LARGEST_EXPONENT 30
#define UNIT_EXPONENT_MOST 200

/* So many times its own size a scene has to be away for its depths to count from itself. */
#define FAR_AWAY 64.0

/* How places become others: (place - eye - forward ahead) unit. */
typedef struct change {
  double eye[3], forward[3], ahead, unit;
  int in_float; /* places are rounded first, as in a tracer that has the world in float */
} change;

static void change_place(const change *by, double place[3]) {
  for (int i = 0; i < 3; i++) {
    const double from_eye = by->in_float ? (double)(float)place[i] - (double)(float)by->eye[i] : place[i] - by->eye[i];
    place[i] = (from_eye - by->forward[i] * by->ahead) * by->unit;
  }
}

static void change_way(const change *by, double way[3]) {
  for (int i = 0; i < 3; i++) way[i] *= by->unit;
}

/* --- copies ---------------------------------------------------------------------------------------------------------
 */

static int copy(void **into, const void *from, size_t count, size_t size) {
  *into = malloc(count * size + 1);
  if (*into && count > 0) memcpy(*into, from, count * size);
  return *into != NULL;
}

/* 0 too where they are not as many as the scene says, which is refused where motions are taken. */
static size_t frame_places(const asc_scene *scene, size_t number) {
  const asc_motion *of = &scene->motions[number];
  if (of->kind != ASC_MOTION_FRAMES || !of->frames || !scene->triangle_motion || of->frame_count > FRAMES_MOST)
    return 0;
  size_t members = 0;
  for (size_t i = 0; i < scene->triangle_count; i++) members += scene->triangle_motion[i] == number + 1;
  return members == of->frame_triangles ? 3 * of->frame_count * members : 0;
}

static int copy_frames(relative_scene *made) {
  asc_scene *scene = &made->scene;
  size_t places = 0;
  for (size_t i = 0; i < scene->motion_count; i++) places += frame_places(scene, i);
  made->frames = malloc(places * 3 * sizeof(double) + 1);
  if (!made->frames) return 0;
  double *next = made->frames;
  for (size_t i = 0; i < scene->motion_count; i++) {
    const size_t mine = frame_places(scene, i);
    if (mine == 0) continue;
    memcpy(next, made->motions[i].frames, mine * 3 * sizeof(double));
    made->motions[i].frames = next;
    next += 3 * mine;
  }
  return 1;
}

static int copy_all(relative_scene *made) {
  asc_scene *scene = &made->scene;
  const int there = copy((void **)&made->vertices, scene->vertices, scene->triangle_count, 9 * sizeof(double)) &&
                    copy((void **)&made->discs, scene->discs, scene->disc_count, sizeof(asc_disc)) &&
                    copy((void **)&made->spheres, scene->spheres, scene->sphere_count, sizeof(asc_sphere)) &&
                    copy((void **)&made->planes, scene->planes, scene->plane_count, sizeof(asc_plane)) &&
                    copy((void **)&made->lights, scene->lights, scene->light_count, sizeof(asc_light)) &&
                    copy((void **)&made->materials, scene->materials, scene->material_count, sizeof(asc_material)) &&
                    copy((void **)&made->motions, scene->motions, scene->motion_count, sizeof(asc_motion)) &&
                    copy_frames(made) && (made->powers = malloc(scene->sphere_count * sizeof(double) + 1));
  scene->vertices = made->vertices;
  scene->discs = made->discs;
  scene->spheres = made->spheres;
  scene->planes = made->planes;
  scene->lights = made->lights;
  scene->materials = made->materials;
  scene->motions = made->motions;
  return there;
}

/* --- changing -------------------------------------------------------------------------------------------------------
 */

static void change_surfaces(relative_scene *made, const change *by) {
  const asc_scene *scene = &made->scene;
  for (size_t i = 0; i < 3 * scene->triangle_count; i++) change_place(by, made->vertices + 3 * i);
  for (size_t i = 0; i < scene->disc_count; i++) {
    change_place(by, made->discs[i].centre);
    made->discs[i].radius *= by->unit;
  }
  for (size_t i = 0; i < scene->sphere_count; i++) {
    change_place(by, made->spheres[i].centre);
    made->spheres[i].radius *= by->unit;
  }
  for (size_t i = 0; i < scene->plane_count; i++) change_place(by, made->planes[i].point);
}

/* A ball that is seen from 1 above it has a power of 2 r + 1, of squares of the size of r^2. */
static double power_of(const asc_sphere *of, const double eye[3]) {
  const asc_kept radius = {of->radius, 0.0}, within = asc_kept_product(radius, radius);
  asc_kept sum = {-within.value, -within.lost};
  for (int i = 0; i < 3; i++) {
    const asc_kept away = asc_kept_sum(of->centre[i], -eye[i]), squared = asc_kept_product(away, away);
    const asc_kept more = asc_kept_sum(sum.value, squared.value);
    sum = (asc_kept){more.value, sum.lost + (more.lost + squared.lost)};
  }
  return sum.value + sum.lost;
}

/* Before the balls change. From far away none is near enough to ask. */
static void set_powers(relative_scene *made, const change *by) {
  for (size_t i = 0; i < made->scene.sphere_count; i++) {
    const double power = by->ahead > 0.0 ? INFINITY : power_of(&made->spheres[i], by->eye);
    made->powers[i] = power * by->unit * by->unit;
  }
}

static void change_motions(relative_scene *made, const change *by) {
  double *frames = made->frames;
  for (size_t i = 0; i < made->scene.motion_count; i++) {
    change_way(by, made->motions[i].by);
    change_place(by, made->motions[i].centre);
    for (size_t left = frame_places(&made->scene, i); left > 0; left--, frames += 3) change_place(by, frames);
  }
}

static void change_lights(relative_scene *made, const change *by) {
  for (size_t i = 0; i < made->scene.light_count; i++) {
    asc_light *light = &made->lights[i];
    if (light->kind == ASC_LIGHT_DIRECTIONAL) continue;
    change_place(by, light->place);
    change_way(by, light->edges[0]);
    change_way(by, light->edges[1]);
    light->radius *= by->unit;
    for (int channel = 0; channel < 3 && light->inverse_square; channel++)
      light->intensity[channel] *= by->unit * by->unit;
  }
}

/* So many checks away, the origin of checks moves nearer by an even number of them, which leaves every colour: else
 * what is subtracted from it would be rounded to more and more of a check. */
#define FAR_CHECKS 0x1p20L

static void change_checks(const change *by, asc_pattern *checks) {
  double near[3];
  memcpy(near, checks->origin, sizeof near);
  change_place(by, near);
  for (int i = 0; i < 3; i++) {
    const long double from_eye = (long double)checks->origin[i] - by->eye[i] - (long double)by->forward[i] * by->ahead;
    const long double away = from_eye * checks->scale;
    if (!by->in_float && fabsl(away) > FAR_CHECKS && isfinite(away))
      near[i] = (double)(fmodl(away, 2.0L) / checks->scale) * by->unit;
  }
  memcpy(checks->origin, near, sizeof near);
  checks->scale /= by->unit;
}

static void change_rings(const change *by, asc_pattern *rings) {
  change_place(by, rings->origin);
  rings->scale /= by->unit * by->unit;
}

static void change_patterns(relative_scene *made, const change *by) {
  for (size_t i = 0; i < made->scene.material_count; i++) {
    asc_pattern *pattern = &made->materials[i].pattern;
    if (pattern->kind == ASC_PATTERN_CHECKER) change_checks(by, pattern);
    if (pattern->kind == ASC_PATTERN_ZONE_PLATE) change_rings(by, pattern);
  }
}

static void change_view(asc_view *view, const change *by) {
  for (int i = 0; i < 3; i++) view->eye[i] -= by->eye[i]; /* 0, or what is not finite */
  view->lens_radius *= by->unit;
  view->focus_distance *= by->unit;
  if (view->projection == ASC_PERSPECTIVE) return;
  view->half_width *= by->unit;
  view->half_height *= by->unit;
}

/* --- where to, and how large ----------------------------------------------------------------------------------------
 */

/* What holds all surfaces but planes, from the eye. */
typedef struct extent {
  double nearest, farthest; /* depths */
  double aside, largest;    /* the largest coordinate across, and of all axes of the world */
} extent;

/* A ball at a place. */
static void hold(const change *by, const double place[3], double radius, extent *held) {
  double from[3] = {place[0], place[1], place[2]}, out[3];
  change_place(by, from);
  const double depth = dot(from, by->forward);
  if (!finite3(from) || !isfinite(depth) || !isfinite(radius)) return; /* refused where the surfaces are taken */
  held->nearest = -larger(-held->nearest, radius - depth);
  held->farthest = larger(held->farthest, depth + radius);
  for (int i = 0; i < 3; i++) {
    out[i] = from[i] - depth * by->forward[i];
    held->aside = larger(held->aside, fabs(out[i]) + radius);
    held->largest = larger(held->largest, fabs(from[i]) + radius);
  }
}

static extent hold_all(const asc_scene *scene, const change *by) {
  extent held = {INFINITY, -INFINITY, 0.0, 0.0};
  for (size_t i = 0; i < 3 * scene->triangle_count; i++) hold(by, scene->vertices + 3 * i, 0.0, &held);
  for (size_t i = 0; i < scene->disc_count; i++) hold(by, scene->discs[i].centre, scene->discs[i].radius, &held);
  for (size_t i = 0; i < scene->sphere_count; i++) hold(by, scene->spheres[i].centre, scene->spheres[i].radius, &held);
  for (size_t i = 0; i < scene->motion_count; i++) {
    const asc_motion *motion = &scene->motions[i];
    for (int axis = 0; axis < 3; axis++)
      if (isfinite(motion->by[axis])) held.largest = fmax(held.largest, fabs(motion->by[axis]));
    const size_t places = frame_places(scene, i);
    for (size_t k = 0; k < places; k++) hold(by, motion->frames + 3 * k, 0.0, &held);
  }
  return held;
}

/* Planes have no nearest place, and what moves none that is known here. */
static double find_ahead(const asc_scene *scene, const extent *held) {
  if (scene->plane_count > 0 || scene->motion_count > 0) return 0.0;
  const double size = fmax(held->farthest - held->nearest, held->aside);
  return isfinite(size) && held->nearest > FAR_AWAY * size ? held->nearest - size : 0.0;
}

static double find_unit(const asc_view *view, double largest) {
  if (view->projection == ASC_ORTHOGRAPHIC) largest = fmax(largest, fmax(view->half_width, view->half_height));
  if (!(largest > 0.0) || !isfinite(largest)) return 1.0;
  int exponent;
  (void)frexp(largest, &exponent);
  const int wanted = LARGEST_EXPONENT - exponent;
  return ldexp(1.0, wanted > UNIT_EXPONENT_MOST    ? UNIT_EXPONENT_MOST
                    : wanted < -UNIT_EXPONENT_MOST ? -UNIT_EXPONENT_MOST
                                                   : wanted);
}

asc_status relative_take(const asc_scene *world, const tracer_options *options, relative_scene *made,
                         asc_error *error) {
  const asc_view *view = &world->view;
  change by = {.unit = 1.0, .in_float = options->not_relative != 0};
  memcpy(by.eye, view->eye, sizeof by.eye);
  memcpy(by.forward, view->forward, sizeof by.forward);
  *made = (relative_scene){.scene = *world};
  if (!options->not_relative) {
    extent held = hold_all(world, &by);
    by.ahead = find_ahead(world, &held);
    if (by.ahead > 0.0) held = hold_all(world, &by);
    by.unit = find_unit(&world->view, held.largest);
  }
  if (!copy_all(made)) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for the scene's places");
  made->ahead = by.ahead * by.unit;
  change_view(&made->scene.view, &by);
  set_powers(made, &by);
  change_surfaces(made, &by);
  change_motions(made, &by);
  change_lights(made, &by);
  change_patterns(made, &by);
  return ASC_OK;
}

void relative_free(relative_scene *made) {
  free(made->vertices);
  free(made->frames);
  free(made->discs);
  free(made->spheres);
  free(made->powers);
  free(made->planes);
  free(made->lights);
  free(made->materials);
  free(made->motions);
}

#include "geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "lighting.h"

/* A corner before the range of depths is known. */
typedef struct corner {
  double x, y, depth;
  uint32_t surface;
} corner;

typedef struct builder {
  const asc_scene *scene;
  camera eye;
  const turn *turns;
  geometry *made;
  corner *corners;
  size_t count, capacity;
  range depth;
} builder;

/* Room for the triangles of one more polygon. */
static bool reserve(builder *b) {
  const size_t most = (size_t)3 * CLIP_CAPACITY;
  if (b->capacity - b->count >= most) {
    return true;
  }
  size_t capacity = 2 * b->capacity + 64 * most;
  corner *grown = realloc(b->corners, capacity * sizeof *grown);
  if (!grown) {
    return false;
  }
  b->corners = grown;
  b->capacity = capacity;
  return true;
}

static void add_corner(builder *b, double x, double y, double depth, uint32_t surface) {
  corner fresh = {x, y, depth, surface};
  b->corners[b->count++] = fresh;
}

static double clamp(double x, double limit) { return fmin(fmax(x, -limit), limit); }

static void add_clipped(builder *b, const clip_vertex *clipped, size_t count, uint32_t surface) {
  double x[CLIP_CAPACITY];
  double y[CLIP_CAPACITY];
  for (size_t i = 0; i < count; ++i) {
    /* The clamp takes back the rounding of corners cut very near to the eye. */
    x[i] = clamp(clipped[i].x / clipped[i].weight, b->eye.guard_x);
    y[i] = clamp(clipped[i].y / clipped[i].weight, b->eye.guard_y);
    range here = {clipped[i].depth, clipped[i].depth};
    range_join(&b->depth, &here);
  }
  for (size_t i = 2; i < count; ++i) {
    const size_t fan[3] = {0, i - 1, i};
    for (int k = 0; k < 3; ++k) {
      add_corner(b, x[fan[k]], y[fan[k]], clipped[fan[k]].depth, surface);
    }
  }
}

/* The depth does not matter: the fragment shader writes it. */
static void add_rectangle(builder *b, const rectangle *box, const range *depth, uint32_t surface) {
  const double x[6] = {box->low_x, box->high_x, box->high_x, box->low_x, box->high_x, box->low_x};
  const double y[6] = {box->low_y, box->low_y, box->high_y, box->low_y, box->high_y, box->high_y};
  for (int i = 0; i < 6; ++i) {
    add_corner(b, x[i], y[i], depth->farthest, surface);
  }
  range_join(&b->depth, depth);
}

/* A new record, all zero but for its material. There are as many as surfaces, and each makes one at most. */
static surface_record *add_surface(builder *b, uint32_t material) {
  surface_record *record = &b->made->surfaces[b->made->surface_count++];
  record->material = material;
  return record;
}

static void set_plane(surface_record *record, const double normal[3], const double point[3]) {
  for (int i = 0; i < 3; ++i) {
    record->plane[i] = normal[i];
    record->plane[3] += normal[i] * point[i];
  }
}

static void add_triangle(builder *b, size_t index) {
  double p[3][3];
  for (size_t i = 0; i < 3; ++i) {
    camera_point(&b->eye, b->scene->vertices + 9 * index + 3 * i, p[i]);
  }
  double e[3];
  double f[3];
  for (int i = 0; i < 3; ++i) {
    e[i] = p[1][i] - p[0][i];
    f[i] = p[2][i] - p[0][i];
  }
  double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
  double k = n[0] * p[0][0] + n[1] * p[0][1] + n[2] * p[0][2];
  /* A triangle without area, or seen exactly from the side, covers nothing. */
  if ((b->eye.perspective ? k : n[2]) == 0.0) {
    return;
  }
  clip_vertex clipped[CLIP_CAPACITY];
  size_t count = camera_clip(&b->eye, (const double(*)[3])p, 3, clipped);
  if (count == 0) {
    return;
  }
  uint32_t surface = (uint32_t)b->made->surface_count;
  surface_record *record = add_surface(b, b->scene->triangle_material[index]);
  make_unit(n);
  set_plane(record, n, p[0]);
  add_clipped(b, clipped, count, surface);
}

static void add_disc(builder *b, size_t index) {
  const asc_disc *disc = &b->scene->discs[index];
  double centre[3];
  double normal[3];
  camera_point(&b->eye, disc->centre, centre);
  camera_direction(&b->eye, disc->normal, normal);
  make_unit(normal);
  rectangle box;
  range depth;
  if (!camera_disc(&b->eye, centre, normal, disc->radius, &box, &depth)) {
    return;
  }
  uint32_t surface = (uint32_t)b->made->surface_count;
  surface_record *record = add_surface(b, disc->material);
  memcpy(record->form, centre, sizeof centre);
  record->form[3] = disc->radius;
  set_plane(record, normal, centre);
  add_rectangle(b, &box, &depth, surface);
}

static void add_sphere(builder *b, size_t index) {
  const asc_sphere *sphere = &b->scene->spheres[index];
  double centre[3];
  camera_point(&b->eye, sphere->centre, centre);
  rectangle box;
  range depth;
  if (!camera_sphere(&b->eye, centre, sphere->radius, &box, &depth)) {
    return;
  }
  uint32_t surface = (uint32_t)b->made->surface_count;
  surface_record *record = add_surface(b, sphere->material);
  memcpy(record->form, centre, sizeof centre);
  record->form[3] = sphere->radius;
  add_rectangle(b, &box, &depth, surface);
}

static void add_plane(builder *b, size_t index) {
  const asc_plane *plane = &b->scene->planes[index];
  surface_record fresh = {.material = plane->material};
  double point[3];
  double normal[3];
  camera_point(&b->eye, plane->point, point);
  camera_direction(&b->eye, plane->normal, normal);
  make_unit(normal);
  set_plane(&fresh, normal, point);
  rectangle box;
  range depth;
  if (!camera_plane(&b->eye, normal, fresh.plane[3], &box, &depth)) {
    return;
  }
  uint32_t surface = (uint32_t)b->made->surface_count;
  *add_surface(b, plane->material) = fresh;
  add_rectangle(b, &box, &depth, surface);
}

static size_t shape_count(const asc_scene *scene, shape what) {
  switch (what) {
  case SHAPE_TRIANGLE: return scene->triangle_count;
  case SHAPE_DISC: return scene->disc_count;
  case SHAPE_SPHERE: return scene->sphere_count;
  default: return scene->plane_count;
  }
}

static uint32_t shape_material(const asc_scene *scene, shape what, size_t index) {
  switch (what) {
  case SHAPE_TRIANGLE: return scene->triangle_material[index];
  case SHAPE_DISC: return scene->discs[index].material;
  case SHAPE_SPHERE: return scene->spheres[index].material;
  default: return scene->planes[index].material;
  }
}

static bool add_batch(builder *b, size_t batch) {
  static void (*const add[SHAPE_COUNT])(builder *, size_t) = {add_triangle, add_disc, add_sphere, add_plane};
  const batch_kind kind = batch_at(batch);
  b->made->first[batch] = b->count;
  size_t count = shape_count(b->scene, kind.what);
  for (size_t i = 0; i < count; ++i) {
    const asc_material *material = &b->scene->materials[shape_material(b->scene, kind.what, i)];
    const bool lit = b->scene->light_count > 0 && lighting_takes(material);
    if (material->pattern.kind != kind.pattern || lit != kind.lit) {
      continue;
    }
    b->made->has_surfaces[batch] = true;
    if (!reserve(b)) {
      return false;
    }
    add[kind.what](b, i);
  }
  return true;
}

/* Fills in the maps from picture positions to rays and from z to depth. */
static void set_maps(const builder *b) {
  const asc_view *view = &b->scene->view;
  geometry *made = b->made;
  made->scale[0] = 2.0 * view->half_width / view->width;
  made->scale[1] = -2.0 * view->half_height / view->height;
  made->base[0] = -view->half_width - b->eye.skew[0];
  made->base[1] = view->half_height - b->eye.skew[1];
  if (!(b->depth.nearest <= b->depth.farthest)) {
    return; /* nothing is in the picture, and no depth is asked for */
  }
  if (b->eye.perspective) {
    /* The floor keeps the reversed depth of the farthest well above the smallest float. */
    made->depth[0] = fmax(b->depth.nearest, ldexp(b->depth.farthest, -100));
    made->depth[1] = 0.0;
    return;
  }
  /* From 1/4 to 3/4, for the rounding of the ends. */
  double extent = b->depth.farthest - b->depth.nearest;
  made->depth[1] = extent > 0.0 ? -0.5 / extent : 0.0;
  made->depth[0] = 0.75 - made->depth[1] * b->depth.nearest;
}

static double reversed_depth(const builder *b, double z) {
  return b->eye.perspective ? b->made->depth[0] / z : b->made->depth[0] + b->made->depth[1] * z;
}

/* The depth over a triangle's plane n . p = k as a linear form in the picture position. */
static void set_triangle_depth(const builder *b, surface_record *record) {
  const geometry *made = b->made;
  const double *n = record->plane;
  /* Perspective: depth0 / z = depth0 (n . direction) / k. Orthographic: z = (k - n.x x - n.y y) / n.z. */
  double factor = b->eye.perspective ? made->depth[0] / n[3] : -made->depth[1] / n[2];
  record->form[0] = factor * n[0] * made->scale[0];
  record->form[1] = factor * n[1] * made->scale[1];
  record->form[2] = factor * (n[0] * made->base[0] + n[1] * made->base[1]);
  record->form[2] += b->eye.perspective ? factor * n[2] : made->depth[0] - factor * n[3];
}

static asc_status finish(builder *b, asc_error *error) {
  geometry *made = b->made;
  if (b->count > INT32_MAX) {
    return asc_fail(error, ASC_UNSUPPORTED, "the scene has %zu vertices in the picture: OpenGL draws 2^31 - 1",
                    b->count);
  }
  set_maps(b);
  made->vertices = calloc(b->count + EMPTY_TRIANGLE, sizeof *made->vertices);
  if (!made->vertices) {
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu vertices", b->count);
  }
  for (size_t i = 0; i < b->count; ++i) {
    const corner *from = &b->corners[i];
    vertex to = {{(float)from->x, (float)-from->y, (float)reversed_depth(b, from->depth)}, from->surface};
    made->vertices[i] = to;
  }
  const size_t triangles_end = made->first[BATCHES_OF_SHAPE]; /* their batches come first */
  for (size_t i = 0; i < triangles_end; i += 3) {
    set_triangle_depth(b, &made->surfaces[made->vertices[i].surface]);
  }
  return ASC_OK;
}

static void copy_colour(float to[4], const double from[3]) {
  for (int i = 0; i < 3; ++i) {
    to[i] = (float)from[i];
  }
}

static void unturn(const turn *by, const double moved[3], double rest[3]) {
  for (int i = 0; i < 3; ++i) { /* the inverse of a rotation is its transpose */
    rest[i] = by->matrix[0][i] * moved[0] + by->matrix[1][i] * moved[1] + by->matrix[2][i] * moved[2];
  }
}

/* Where a checker's origin lies from the eye, along the axes of the world. */
static void checker_origin(const camera *eye, const double origin[3], double found[3]) {
  const asc_view *view = eye->view;
  for (int i = 0; i < 3; ++i) {
    found[i] = origin[i] - view->eye[i];
    found[i] -= eye->lens[0] * view->right[i] + eye->lens[1] * view->up[i];
  }
}

/* Takes a checker to the axes of its surface. */
static void turn_checker(const builder *b, size_t material) {
  const asc_view *view = &b->scene->view;
  const double *world[3] = {view->right, view->up, view->forward};
  for (int column = 0; column < 3; ++column) {
    unturn(&b->turns[material], world[column], b->made->axes[material].columns[column]);
  }
  double *origin = b->made->materials[material].origin;
  const double untouched[3] = {origin[0], origin[1], origin[2]};
  unturn(&b->turns[material], untouched, origin);
}

static void set_materials(const builder *b) {
  for (size_t i = 0; i < b->scene->material_count; ++i) {
    const asc_material *from = &b->scene->materials[i];
    material_record *to = &b->made->materials[i];
    copy_colour(to->emission, from->emission);
    copy_colour(to->albedo, from->albedo);
    if (from->pattern.kind != ASC_PATTERN_NONE) {
      if (from->pattern.kind == ASC_PATTERN_CHECKER) {
        checker_origin(&b->eye, from->pattern.origin, to->origin);
      } else {
        camera_point(&b->eye, from->pattern.origin, to->origin);
      }
      to->scale = from->pattern.scale;
      copy_colour(to->low, from->pattern.low);
      copy_colour(to->high, from->pattern.high);
    }
    if (b->turns && from->pattern.kind == ASC_PATTERN_CHECKER) {
      turn_checker(b, i);
    }
  }
}

static asc_status build(builder *b, asc_error *error) {
  geometry *made = b->made;
  const asc_scene *scene = b->scene;
  size_t surfaces = scene->triangle_count + scene->disc_count + scene->sphere_count + scene->plane_count;
  made->material_count = scene->material_count;
  /* One more than needed: a buffer of OpenGL is never empty. */
  made->surfaces = calloc(surfaces + 1, sizeof *made->surfaces);
  made->materials = calloc(scene->material_count + 1, sizeof *made->materials);
  made->axes = b->turns ? calloc(scene->material_count + 1, sizeof *made->axes) : NULL;
  if (!made->surfaces || !made->materials || (b->turns && !made->axes)) {
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %zu surfaces", surfaces);
  }
  set_materials(b);
  for (size_t batch = 0; batch < BATCH_COUNT; ++batch) {
    if (!add_batch(b, batch)) {
      return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for the corners of %zu surfaces", surfaces);
    }
  }
  made->first[BATCH_COUNT] = b->count;
  return finish(b, error);
}

asc_status geometry_create(const asc_scene *scene, const camera *eye, const turn *turns, geometry *made,
                           asc_error *error) {
  memset(made, 0, sizeof *made);
  builder b = {.scene = scene, .eye = *eye, .turns = turns, .made = made, .depth = {INFINITY, 0.0}};
  asc_status status = build(&b, error);
  free(b.corners);
  if (status != ASC_OK) {
    geometry_destroy(made);
  }
  return status;
}

void geometry_destroy(geometry *made) {
  free(made->vertices);
  free(made->surfaces);
  free(made->materials);
  free(made->axes);
  memset(made, 0, sizeof *made);
}

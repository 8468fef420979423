#include "moment.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "camera.h"
#include "motion.h"

enum { TRIANGLES = 0, DISCS = 1, SPHERES = 2, PLANES = 3, KINDS = 4 };

/* What of a scene moves. */
typedef struct places {
  double *vertices;
  asc_disc *discs;
  asc_sphere *spheres;
  asc_plane *planes;
} places;

/* A material that rides on a motion. */
typedef struct rider {
  uint32_t material, motion; /* motion: its index */
} rider;

struct moment {
  asc_scene still;
  places rest, now;
  asc_material *materials; /* those of the scene, then the riders' */
  size_t given;            /* how many are the scene's */
  rider *riders;
  size_t rider_count, rider_capacity;
  uint32_t *triangle_material;
  asc_light *lights;
  asc_motion *motions; /* axes of length 1 */
  size_t motion_count;
  placing *placings;          /* by motion; nothing of those of frames */
  double **frames;            /* by motion, as in asc_motion */
  size_t *placed;             /* by motion of frames, how many triangles are in their place */
  uint32_t *motion_of[KINDS]; /* as in asc_scene; NULL: all of a kind stand still */
  turn *turns;
};

static void *copy_of(const void *from, size_t count, size_t size) {
  void *made = calloc(count + 1, size);
  if (made && count > 0) {
    memcpy(made, from, count * size);
  }
  return made;
}

static bool take_places(const asc_scene *from, places *to) {
  to->vertices = copy_of(from->vertices, from->triangle_count, 9 * sizeof(double));
  to->discs = copy_of(from->discs, from->disc_count, sizeof *to->discs);
  to->spheres = copy_of(from->spheres, from->sphere_count, sizeof *to->spheres);
  to->planes = copy_of(from->planes, from->plane_count, sizeof *to->planes);
  return to->vertices && to->discs && to->spheres && to->planes;
}

static void drop_places(places *of) {
  free(of->vertices);
  free(of->discs);
  free(of->spheres);
  free(of->planes);
}

static void counts_of(const asc_scene *scene, size_t counts[KINDS]) {
  counts[TRIANGLES] = scene->triangle_count;
  counts[DISCS] = scene->disc_count;
  counts[SPHERES] = scene->sphere_count;
  counts[PLANES] = scene->plane_count;
}

static bool take_motions(moment *made, const asc_scene *from) {
  made->motion_count = from->motion_count;
  made->motions = copy_of(from->motions, from->motion_count, sizeof *made->motions);
  made->placings = calloc(from->motion_count + 1, sizeof *made->placings);
  if (!made->motions || !made->placings) {
    return false;
  }
  made->frames = calloc(from->motion_count + 1, sizeof *made->frames);
  made->placed = calloc(from->motion_count + 1, sizeof *made->placed);
  if (!made->frames || !made->placed) {
    return false;
  }
  for (size_t i = 0; i < made->motion_count; ++i) {
    const asc_motion *motion = &made->motions[i];
    if (motion->kind == ASC_MOTION_ROTATE) {
      make_unit(made->motions[i].axis);
    } else if (motion->kind == ASC_MOTION_FRAMES) {
      const size_t triangles = motion->frame_count * motion->frame_triangles;
      made->frames[i] = copy_of(motion->frames, triangles, 9 * sizeof(double));
      if (!made->frames[i]) {
        return false;
      }
    }
  }
  size_t counts[KINDS];
  counts_of(from, counts);
  const uint32_t *given[KINDS] = {from->triangle_motion, from->disc_motion, from->sphere_motion, from->plane_motion};
  for (int kind = 0; kind < KINDS; ++kind) {
    if (from->motion_count == 0 || !given[kind]) {
      continue;
    }
    made->motion_of[kind] = copy_of(given[kind], counts[kind], sizeof(uint32_t));
    if (!made->motion_of[kind]) {
      return false;
    }
  }
  return true;
}

/* The motion of a surface, or NULL. */
static const placing *placing_of(const moment *of, int kind, size_t index) {
  const uint32_t *motions = of->motion_of[kind];
  return motions && motions[index] > 0 ? &of->placings[motions[index] - 1] : NULL;
}

static uint32_t *material_of(moment *of, int kind, size_t index) {
  switch (kind) {
  case TRIANGLES: return &of->triangle_material[index];
  case DISCS: return &of->now.discs[index].material;
  case SPHERES: return &of->now.spheres[index].material;
  default: return &of->now.planes[index].material;
  }
}

/* The index of the material that rides on the motion; one surface's is mostly that of the one before. */
static bool add_rider(moment *made, uint32_t *material, uint32_t motion) {
  const rider wanted = {*material, motion};
  const size_t count = made->rider_count;
  const rider *last = count > 0 ? &made->riders[count - 1] : NULL;
  if (!last || last->material != wanted.material || last->motion != wanted.motion) {
    if (!made->riders || count == made->rider_capacity) {
      const size_t capacity = 2 * count + 16;
      rider *grown = realloc(made->riders, capacity * sizeof *grown);
      if (!grown) {
        return false;
      }
      made->riders = grown;
      made->rider_capacity = capacity;
    }
    made->riders[made->rider_count++] = wanted;
  }
  *material = (uint32_t)(made->given + made->rider_count - 1);
  return true;
}

static bool add_riders(moment *made, const asc_scene *scene) {
  size_t counts[KINDS];
  counts_of(scene, counts);
  for (int kind = 0; kind < KINDS; ++kind) {
    for (size_t i = 0; made->motion_of[kind] && i < counts[kind]; ++i) {
      uint32_t *material = material_of(made, kind, i);
      const uint32_t motion = made->motion_of[kind][i];
      if (motion > 0 && scene->materials[*material].pattern.kind != ASC_PATTERN_NONE &&
          !add_rider(made, material, motion - 1)) {
        return false;
      }
    }
  }
  return true;
}

/* Whether a checker rides on a motion that turns. */
static bool turns_a_checker(const moment *of, const asc_scene *scene) {
  for (size_t i = 0; i < of->rider_count; ++i) {
    if (of->motions[of->riders[i].motion].kind == ASC_MOTION_ROTATE &&
        scene->materials[of->riders[i].material].pattern.kind == ASC_PATTERN_CHECKER) {
      return true;
    }
  }
  return false;
}

static bool take_materials(moment *made, const asc_scene *scene) {
  made->given = scene->material_count;
  made->triangle_material = copy_of(scene->triangle_material, scene->triangle_count, sizeof(uint32_t));
  if (!made->triangle_material || !add_riders(made, scene)) {
    return false;
  }
  const size_t count = made->given + made->rider_count;
  made->materials = calloc(count + 1, sizeof *made->materials);
  if (!made->materials) {
    return false;
  }
  for (size_t i = 0; i < count; ++i) {
    made->materials[i] = scene->materials[i < made->given ? i : made->riders[i - made->given].material];
  }
  if (!turns_a_checker(made, scene)) {
    return true;
  }
  made->turns = calloc(count + 1, sizeof *made->turns);
  for (size_t i = 0; made->turns && i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      made->turns[i].matrix[axis][axis] = 1.0;
    }
  }
  return made->turns != NULL;
}

/* The scene that is seen: the given one with arrays of the moment's own. */
static void set_still(moment *made, const asc_scene *scene) {
  made->still = *scene;
  made->still.materials = made->materials;
  made->still.material_count = made->given + made->rider_count;
  made->still.vertices = made->now.vertices;
  made->still.triangle_material = made->triangle_material;
  made->still.discs = made->now.discs;
  made->still.spheres = made->now.spheres;
  made->still.planes = made->now.planes;
  made->still.lights = made->lights;
  made->still.motions = NULL;
  made->still.motion_count = 0;
  made->still.triangle_motion = made->still.disc_motion = NULL;
  made->still.sphere_motion = made->still.plane_motion = NULL;
}

asc_status moment_create(const asc_scene *scene, moment **made, asc_error *error) {
  moment *fresh = calloc(1, sizeof *fresh);
  if (!fresh) {
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for a scene");
  }
  fresh->lights = copy_of(scene->lights, scene->light_count, sizeof *fresh->lights);
  if (!fresh->lights || !take_places(scene, &fresh->rest) || !take_places(scene, &fresh->now) ||
      !take_motions(fresh, scene) || !take_materials(fresh, scene)) {
    moment_destroy(fresh);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for the surfaces of a scene");
  }
  set_still(fresh, scene);
  *made = fresh;
  return ASC_OK;
}

void moment_destroy(moment *made) {
  if (!made) {
    return;
  }
  drop_places(&made->rest);
  drop_places(&made->now);
  for (int kind = 0; kind < KINDS; ++kind) {
    free(made->motion_of[kind]);
  }
  free(made->materials);
  free(made->riders);
  free(made->triangle_material);
  free(made->lights);
  for (size_t i = 0; made->frames && i < made->motion_count; ++i) {
    free(made->frames[i]);
  }
  free(made->frames);
  free(made->placed);
  free(made->motions);
  free(made->placings);
  free(made->turns);
  free(made);
}

static void place_round(moment *to) {
  const places *rest = &to->rest;
  for (size_t i = 0; to->motion_of[DISCS] && i < to->still.disc_count; ++i) {
    const placing *at = placing_of(to, DISCS, i);
    if (at) {
      motion_place(at, rest->discs[i].centre, to->now.discs[i].centre);
      motion_turn(at, rest->discs[i].normal, to->now.discs[i].normal);
    }
  }
  for (size_t i = 0; to->motion_of[SPHERES] && i < to->still.sphere_count; ++i) {
    const placing *at = placing_of(to, SPHERES, i);
    if (at) {
      motion_place(at, rest->spheres[i].centre, to->now.spheres[i].centre);
    }
  }
}

/* A triangle of a motion of frames, between the two around the time. */
static void place_between(moment *to, size_t motion, size_t triangle, double time) {
  const asc_motion *by = &to->motions[motion];
  const size_t own = to->placed[motion]++;
  const double steps = (double)by->frame_count;
  const double before = fmin(fmax(floor(time * steps), 0.0), steps - 1.0);
  const double share = time * steps - before;
  const double *last = to->frames[motion] + 9 * ((size_t)before * by->frame_triangles + own);
  const double *first = before == 0.0 ? to->rest.vertices + 9 * triangle : last - 9 * by->frame_triangles;
  for (size_t k = 0; k < 9; ++k) {
    to->now.vertices[9 * triangle + k] = (1.0 - share) * first[k] + share * last[k];
  }
}

static void place_triangles(moment *to, double time) {
  for (size_t i = 0; i < to->motion_count; ++i) {
    to->placed[i] = 0;
  }
  for (size_t i = 0; to->motion_of[TRIANGLES] && i < to->still.triangle_count; ++i) {
    const placing *at = placing_of(to, TRIANGLES, i);
    if (!at) {
      continue;
    }
    const size_t motion = to->motion_of[TRIANGLES][i] - 1;
    if (to->motions[motion].kind == ASC_MOTION_FRAMES) {
      place_between(to, motion, i, time);
      continue;
    }
    for (size_t k = 3 * i; k < 3 * i + 3; ++k) {
      motion_place(at, to->rest.vertices + 3 * k, to->now.vertices + 3 * k);
    }
  }
}

static void place_planes(moment *to) {
  const places *rest = &to->rest;
  for (size_t i = 0; to->motion_of[PLANES] && i < to->still.plane_count; ++i) {
    const placing *at = placing_of(to, PLANES, i);
    if (at) {
      motion_place(at, rest->planes[i].point, to->now.planes[i].point);
      motion_turn(at, rest->planes[i].normal, to->now.planes[i].normal);
    }
  }
}

static turn turn_of(const placing *at) {
  turn made;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      made.matrix[i][j] = at->matrix[i][j];
    }
  }
  return made;
}

void moment_set(moment *to, double time) {
  for (size_t i = 0; i < to->motion_count; ++i) {
    to->placings[i] = motion_at(&to->motions[i], time);
  }
  place_triangles(to, time);
  place_planes(to);
  place_round(to);
  for (size_t i = 0; i < to->rider_count; ++i) {
    const placing *at = &to->placings[to->riders[i].motion];
    const size_t own = to->given + i;
    motion_place(at, to->materials[to->riders[i].material].pattern.origin, to->materials[own].pattern.origin);
    if (to->turns) {
      to->turns[own] = turn_of(at);
    }
  }
}

const asc_scene *moment_scene(const moment *of) { return &of->still; }

const turn *moment_turns(const moment *of) { return of->turns; }

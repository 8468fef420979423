/* The lights of a scene, and what can stand before them, as the shaders take them.
 *
 * Shadows are exact: the fragment shader tests the way to each light against every surface of the scene, in the picture
 * or not, in double. That is fine for scenes of few surfaces, and what is more is refused (RASTER_MOST_SHADOW_TESTS).
 */
#ifndef RASTER_LIGHTING_H
#define RASTER_LIGHTING_H

#include <stdbool.h>
#include <stddef.h>

#include "aliascope/base.h"
#include "aliascope/scene.h"
#include "camera.h"

/* Laid out as `Light` in shader_text.c (std430). */
typedef struct light_record {
  double place[4];     /* w 1: position of a point light; w 0: unit direction toward a directional one */
  double intensity[4]; /* w 1: divided by the squared distance */
  /* w LIGHT_POINT: nothing. LIGHT_FACE: the normal of the side to which it shines where it falls off, `place` the point
   * of it. LIGHT_BALL: x and y a point of the unit disc, z the radius; which part of it is seen is up to the shader */
  double extent[4];
} light_record;

enum { LIGHT_POINT = 0, LIGHT_FACE = 1, LIGHT_BALL = 2 };

typedef struct light_counts {
  size_t lights, spheres, planes, discs, triangles;
  bool any_area; /* whether any light has an area */
} light_counts;

/* Spheres: centre, radius. Then planes: normal . p = w. Then discs: centre, radius; plane. Then triangles: plane; and
 * two forms u and v, u = xyz . p + w, by which a point p of the plane is inside where u >= 0, v >= 0, u + v <= 1; all
 * 0, which nothing meets, where a triangle has no area. All normals have length 1. */
typedef struct occluder_four {
  double xyzw[4];
} occluder_four;

typedef struct lighting {
  light_counts counts; /* all 0 where no surface takes light */
  light_record *lights;
  occluder_four *occluders;
  size_t occluder_fours;
} lighting;

/* Whether a surface of this material changes with the light on it. */
bool lighting_takes(const asc_material *material);

/* Whether any material of the scene does, and there is light. */
bool lighting_is_needed(const asc_scene *scene);

bool lighting_has_area(const asc_light *given);

/* `scene` must have passed raster_validate. `numbers`, [lights with an area][2] in [0, 1): choose the point of each, as
 * tracer.h says; NULL: the middle of it. */
asc_status lighting_create(const asc_scene *scene, const camera *eye, const double *numbers, lighting *made,
                           asc_error *error);
void lighting_destroy(lighting *made);

#endif

/* A scene as the shaders take it: vertices in the picture, and one record for each surface.
 *
 * Everything is taken to the frame of the camera (x along right, y along up, z along forward, the eye at 0) in double,
 * clipped and projected there, and becomes float last. Vertices have no perspective left: all that varies over a
 * surface is its depth, which is linear in the picture, and what the fragment shader solves for itself.
 *
 * Depth is reversed, 1 near and 0 far: nearest / z in perspective, which in float has the same relative precision
 * everywhere, and linear between the farthest and the nearest corner in an orthographic view.
 */
#ifndef RASTER_GEOMETRY_H
#define RASTER_GEOMETRY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "aliascope/base.h"
#include "aliascope/scene.h"

typedef enum shape { SHAPE_TRIANGLE = 0, SHAPE_DISC = 1, SHAPE_SPHERE = 2, SHAPE_COUNT = 3 } shape;

/* Surfaces that one shader program draws: of one shape, with or without a pattern. */
enum { BATCH_COUNT = 2 * SHAPE_COUNT };
static inline size_t batch_of(shape what, bool patterned) { return 2u * (size_t)what + (patterned ? 1u : 0u); }

typedef struct vertex {
  float position[3]; /* normalised device coordinates; y as in the picture, down; z the reversed depth */
  uint32_t surface;  /* index of its record */
} vertex;

/* Laid out as `Surface` in shaders.c (std430). */
typedef struct surface_record {
  /* triangle: reversed depth at picture position (px, py), in pixels, = form[0] px + form[1] py + form[2].
   * disc, sphere: centre, radius */
  double form[4];
  double plane[4]; /* triangle, disc: normal . p = plane[3] for a point p of its plane; the disc's normal is a unit */
  uint32_t material;
  uint32_t padding[7];
} surface_record;

/* Laid out as `Material` in shaders.c (std430). */
typedef struct material_record {
  double origin[3], scale;
  float emission[4], low[4], high[4];
  float padding[4];
} material_record;

typedef struct geometry {
  vertex *vertices;
  size_t first[BATCH_COUNT + 1]; /* batch b has the vertices first[b] to first[b + 1] */
  surface_record *surfaces;
  size_t surface_count;
  material_record *materials;
  size_t material_count;
  /* ray direction, or the point where an orthographic ray starts, at picture position p: base + scale p */
  double scale[2], base[2];
  double depth[2]; /* reversed depth: depth[0] / z in perspective, depth[0] + depth[1] z in an orthographic view */
} geometry;

/* `scene` must have passed raster_validate. */
asc_status geometry_create(const asc_scene *scene, geometry *made, asc_error *error);
void geometry_destroy(geometry *made);

#endif

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
#include "camera.h"
#include "moment.h"

typedef enum shape { SHAPE_TRIANGLE = 0, SHAPE_DISC = 1, SHAPE_SPHERE = 2, SHAPE_PLANE = 3, SHAPE_COUNT = 4 } shape;

/* Surfaces that one shader program draws: of one shape and kind of pattern, in the light or not. */
typedef struct batch_kind {
  shape what;
  asc_pattern_kind pattern;
  bool lit;
} batch_kind;

/* Batches are numbered, those of one shape in a row. */
enum { PATTERN_COUNT = 3, BATCHES_OF_SHAPE = 2 * PATTERN_COUNT, BATCH_COUNT = SHAPE_COUNT * BATCHES_OF_SHAPE };
static inline batch_kind batch_at(size_t batch) {
  batch_kind kind = {(shape)(batch / BATCHES_OF_SHAPE), (asc_pattern_kind)(batch / 2 % PATTERN_COUNT), batch % 2 == 1};
  return kind;
}

/* After the last batch there are so many vertices more, of a triangle that covers nothing. */
enum { EMPTY_TRIANGLE = 3 };

typedef struct vertex {
  float position[3]; /* normalised device coordinates; y as in the picture, down; z the reversed depth */
  uint32_t surface;  /* index of its record */
} vertex;

/* Laid out as `Surface` in shaders.c (std430). */
typedef struct surface_record {
  /* triangle: reversed depth at picture position (px, py), in pixels, = form[0] px + form[1] py + form[2].
   * disc, sphere: centre, radius; plane: nothing */
  double form[4];
  double plane[4]; /* not sphere: normal . p = plane[3] for a point p of its plane, the normal of length 1 */
  uint32_t material;
  uint32_t padding[7];
} surface_record;

/* Laid out as `Material` in shaders.c (std430). */
typedef struct material_record {
  /* origin: of a zone plate in camera coordinates, of a checker from the eye, along its surface's axes */
  double origin[3], scale;
  float emission[4], low[4], high[4], albedo[4];
} material_record;

/* The axes of a checker's surface, which were those of the world at time 0: right, up and forward of the camera along
 * them. Laid out as an element of `Axes` in shaders.c (std430). */
typedef struct checker_axes {
  double columns[3][4];
} checker_axes;

typedef struct geometry {
  vertex *vertices;
  size_t first[BATCH_COUNT + 1];  /* batch b has the vertices first[b] to first[b + 1] */
  bool has_surfaces[BATCH_COUNT]; /* within the picture or not */
  surface_record *surfaces;
  size_t surface_count;
  material_record *materials;
  size_t material_count;
  checker_axes *axes; /* by material; NULL where no checker has turned */
  /* ray direction, or the point where an orthographic ray starts, at picture position p: base + scale p */
  double scale[2], base[2];
  double depth[2]; /* reversed depth: depth[0] / z in perspective, depth[0] + depth[1] z in an orthographic view */
} geometry;

/* `scene` must have passed raster_validate. `turns`, by material: how its surfaces have turned; NULL: none has. */
asc_status geometry_create(const asc_scene *scene, const camera *eye, const turn *turns, geometry *made,
                           asc_error *error);
void geometry_destroy(geometry *made);

#endif

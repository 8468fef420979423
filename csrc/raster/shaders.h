/* The shader programs: one for each batch of the geometry and each way of sampling, with what the scene needs of it. */
#ifndef RASTER_SHADERS_H
#define RASTER_SHADERS_H

#include <stdbool.h>
#include <stddef.h>

#include "aliascope/base.h"
#include "geometry.h"
#include "gl.h"
#include "lighting.h"

/* Binding points. */
enum {
  BINDING_SURFACES = 0,
  BINDING_MATERIALS = 1,
  BINDING_LIGHTS = 2,
  BINDING_OCCLUDERS = 3,
  BINDING_AXES = 4,
  BINDING_PASS = 0
};
/* Vertex attributes. */
enum { ATTRIBUTE_POSITION = 0, ATTRIBUTE_SURFACE = 1 };

/* How a pass samples: one sample a pixel; four, patterns and light evaluated once a pixel; four, evaluated for each. */
typedef enum way { WAY_SINGLE = 0, WAY_PIXEL = 1, WAY_SAMPLE = 2, WAY_COUNT = 3 } way;

/* Laid out as `Pass` in shader_text.c (std140). */
typedef struct pass_block {
  double scale[2], base[2], depth[2]; /* of the geometry */
  double shift[2];                    /* from gl_FragCoord to the picture position that is sampled, pixels */
  double frame[3][4];                 /* right, up, forward: camera to world */
  float move[2];                      /* of the vertices, normalised device coordinates */
  float padding[2];
} pass_block;

/* Whether the program runs once for each sample: the shapes that it cuts out itself do where there are several. */
static inline bool runs_for_samples(size_t batch, way how) {
  return how == WAY_SAMPLE || (how == WAY_PIXEL && batch_at(batch).what != SHAPE_TRIANGLE);
}

/* What of a scene its programs depend on. */
typedef struct program_needs {
  bool perspective;
  bool turned_checkers; /* they have axes of their own */
  light_counts lit_by;
} program_needs;

/* Compiles and links; needs a current context. ASC_UNAVAILABLE with the compiler's first line where that fails. */
asc_status shaders_create(size_t batch, way how, const program_needs *needs, GLuint *program, asc_error *error);

#endif

/* The shader programs: one for each batch of the geometry, and for one or four samples a pixel. */
#ifndef RASTER_SHADERS_H
#define RASTER_SHADERS_H

#include <stdbool.h>
#include <stddef.h>

#include "aliascope/base.h"
#include "geometry.h"
#include "gl.h"

/* Binding points. */
enum { BINDING_SURFACES = 0, BINDING_MATERIALS = 1, BINDING_PASS = 0 };
/* Vertex attributes. */
enum { ATTRIBUTE_POSITION = 0, ATTRIBUTE_SURFACE = 1 };

/* Laid out as `Pass` in shaders.c (std140). */
typedef struct pass_block {
  double scale[2], base[2], depth[2]; /* of the geometry */
  double shift[2];                    /* from gl_FragCoord to the picture position that is sampled, pixels */
  float move[2];                      /* of the vertices, normalised device coordinates */
  float padding[2];
} pass_block;

/* Whether the program runs once for each sample where there are several: the round shapes, which it cuts out itself. */
static inline bool shades_samples(size_t batch) { return batch >= batch_of(SHAPE_DISC, false); }

/* Compiles and links; needs a current context. ASC_UNAVAILABLE with the compiler's first line where that fails. */
asc_status shaders_create(size_t batch, bool perspective, bool multisampled, GLuint *program, asc_error *error);

#endif

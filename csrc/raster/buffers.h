/* The buffers of OpenGL that the shaders read: a scene's surfaces, materials and lights. */
#ifndef RASTER_BUFFERS_H
#define RASTER_BUFFERS_H

#include "aliascope/base.h"
#include "geometry.h"
#include "gl.h"
#include "lighting.h"

/* All 0: not made. Their context owns them. */
typedef struct buffers {
  GLuint vertex_array, vertices, surfaces, materials, axes, lights, occluders;
} buffers;

/* Puts it into the buffers, which are made when they are first needed, in place of what they held. Need a current
 * context. ASC_UNSUPPORTED where OpenGL has no room. */
asc_status buffers_load_geometry(buffers *into, const geometry *shapes, asc_error *error);
asc_status buffers_load_lighting(buffers *into, const lighting *light, asc_error *error);

#endif

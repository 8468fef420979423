/* What is drawn into: framebuffer objects of RGBA32F and a depth buffer of 32 bits float. */
#ifndef RASTER_TARGET_H
#define RASTER_TARGET_H

#include <stddef.h>
#include <stdint.h>

#include "aliascope/base.h"
#include "gl.h"

/* llvmpipe has one sample a pixel, or this many. */
enum { MULTISAMPLES = 4 };

typedef struct target {
  GLuint framebuffer, colour, depth; /* all 0: not made */
} target;

/* samples: 1, or 4 for a multisample target; with_depth: 0 for one that only takes a resolved picture. Needs a current
 * context. ASC_OUT_OF_MEMORY where OpenGL has no room, ASC_UNSUPPORTED where it has not so many samples. */
asc_status target_create(uint32_t width, uint32_t height, uint32_t samples, int with_depth, target *made,
                         asc_error *error);
void target_destroy(target *made);

#endif

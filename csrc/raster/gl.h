/* OpenGL with prototypes. Without the macro a call of a newer function is an implicit declaration, and its float
 * arguments pass as double. */
#ifndef RASTER_GL_H
#define RASTER_GL_H

#ifndef GL_GLEXT_PROTOTYPES
#define GL_GLEXT_PROTOTYPES 1
#endif
#include <GL/gl.h>
#include <GL/glext.h>

#include "aliascope/base.h"

/* Fails where OpenGL has met an error since the last call; `doing` ends the message: "drawing". */
asc_status gl_check(const char *doing, asc_error *error);

#endif

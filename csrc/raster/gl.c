#include "gl.h"

asc_status gl_check(const char *doing, asc_error *error) {
  GLenum problem = glGetError();
  if (problem == GL_NO_ERROR) {
    return ASC_OK;
  }
  return asc_fail(error, problem == GL_OUT_OF_MEMORY ? ASC_OUT_OF_MEMORY : ASC_UNAVAILABLE, "OpenGL error 0x%x %s",
                  (unsigned)problem, doing);
}

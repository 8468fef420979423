#include "context.h"

#include <GL/osmesa.h>
#include <stdlib.h>

struct context {
  OSMesaContext mesa;
  /* OSMesa wants a picture of its own to draw into; all drawing goes to framebuffer objects, so one pixel will do */
  unsigned char window[4];
};

asc_status context_create(context **made, asc_error *error) {
  static const int attributes[] = {OSMESA_FORMAT,
                                   OSMESA_RGBA,
                                   OSMESA_PROFILE,
                                   OSMESA_CORE_PROFILE,
                                   OSMESA_CONTEXT_MAJOR_VERSION,
                                   4,
                                   OSMESA_CONTEXT_MINOR_VERSION,
                                   5,
                                   0};
  context *fresh = calloc(1, sizeof *fresh);
  if (!fresh) {
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for an OSMesa context");
  }
  fresh->mesa = OSMesaCreateContextAttribs(attributes, NULL);
  if (!fresh->mesa) {
    free(fresh);
    return asc_fail(error, ASC_UNAVAILABLE, "OSMesa gives no context of OpenGL 4.5: a Mesa with llvmpipe is needed");
  }
  *made = fresh;
  return ASC_OK;
}

void context_destroy(context *made) {
  if (made) {
    OSMesaDestroyContext(made->mesa);
    free(made);
  }
}

asc_status context_enter(context *made, asc_error *error) {
  if (!OSMesaMakeCurrent(made->mesa, made->window, GL_UNSIGNED_BYTE, 1, 1)) {
    return asc_fail(error, ASC_UNAVAILABLE, "OSMesa does not make its context current");
  }
  return ASC_OK;
}

void context_leave(void) { (void)OSMesaMakeCurrent(NULL, NULL, 0, 0, 0); }

context_function context_address(const char *name) { return (context_function)OSMesaGetProcAddress(name); }

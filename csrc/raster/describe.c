/* What OpenGL says of itself. */
#include <stdio.h>

#include "context.h"
#include "gl.h"
#include "raster.h"
#include "target.h"

/* Runs `ask` with a context of its own. */
static asc_status with_context(asc_status (*ask)(void *, asc_error *), void *answer, asc_error *error) {
  context *gl = NULL;
  asc_status status = context_create(&gl, error);
  if (status == ASC_OK) {
    status = context_enter(gl, error);
  }
  if (status == ASC_OK) {
    status = ask(answer, error);
    context_leave();
  }
  context_destroy(gl);
  return status;
}

typedef struct description {
  char *text;
  size_t capacity;
} description;

static asc_status ask_names(void *answer, asc_error *error) {
  const description *to = answer;
  const char *renderer = (const char *)glGetString(GL_RENDERER);
  const char *version = (const char *)glGetString(GL_VERSION);
  if (!renderer || !version) {
    return asc_fail(error, ASC_UNAVAILABLE, "OpenGL does not say its name");
  }
  (void)snprintf(to->text, to->capacity, "%s; %s", renderer, version);
  return ASC_OK;
}

asc_status raster_describe(char *text, size_t capacity) {
  if (!text || capacity < 1) {
    return ASC_INVALID_ARGUMENT;
  }
  description to = {text, capacity};
  return with_context(ask_names, &to, NULL);
}

static asc_status ask_limits(void *answer, asc_error *error) {
  raster_limits *limits = answer;
  GLint most = 0, samples = 0, bits = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  glGetIntegerv(GL_SUBPIXEL_BITS, &bits);
  target one = {0, 0, 0};
  if (most >= MULTISAMPLES) {
    asc_status status = target_create(1, 1, MULTISAMPLES, 0, &one, error);
    if (status != ASC_OK) {
      return status;
    }
    glGetIntegerv(GL_SAMPLES, &samples); /* of the framebuffer, which is bound */
    target_destroy(&one);
  }
  const raster_limits found = {(uint32_t)most, (uint32_t)samples, (uint32_t)bits};
  *limits = found;
  return gl_check("asking for its limits", error);
}

asc_status raster_ask_limits(raster_limits *limits, asc_error *error) {
  if (!limits) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "nowhere to put the limits");
  }
  return with_context(ask_limits, limits, error);
}

static asc_status ask_positions(void *answer, asc_error *error) {
  double *positions = answer;
  target one = {0, 0, 0};
  asc_status status = target_create(1, 1, MULTISAMPLES, 0, &one, error);
  if (status != ASC_OK) {
    return status;
  }
  for (size_t i = 0; i < MULTISAMPLES; ++i) {
    GLfloat at[2] = {0.0F, 0.0F};
    glGetMultisamplefv(GL_SAMPLE_POSITION, (GLuint)i, at);
    /* From OpenGL's lower border, which is where the picture has its top. */
    positions[2 * i] = (double)at[0];
    positions[2 * i + 1] = (double)at[1];
  }
  status = gl_check("asking for sample positions", error);
  target_destroy(&one);
  return status;
}

asc_status raster_sample_positions(double *positions, asc_error *error) {
  if (!positions) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "nowhere to put the sample positions");
  }
  return with_context(ask_positions, positions, error);
}

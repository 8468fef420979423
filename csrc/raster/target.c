#include "target.h"

static GLuint attach(GLenum where, GLenum format, uint32_t width, uint32_t height, uint32_t samples) {
  GLuint buffer = 0;
  glGenRenderbuffers(1, &buffer);
  glBindRenderbuffer(GL_RENDERBUFFER, buffer);
  if (samples > 1) {
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, (GLsizei)samples, format, (GLsizei)width, (GLsizei)height);
  } else {
    /* Asked for one sample through the call above, Mesa gives four. */
    glRenderbufferStorage(GL_RENDERBUFFER, format, (GLsizei)width, (GLsizei)height);
  }
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, where, GL_RENDERBUFFER, buffer);
  return buffer;
}

asc_status target_create(uint32_t width, uint32_t height, uint32_t samples, int with_depth, target *made,
                         asc_error *error) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  if (samples > 1 && (GLint)samples > most) {
    return asc_fail(error, ASC_UNSUPPORTED, "this OpenGL has %d samples a pixel at most, not %u", most, samples);
  }
  target fresh = {0, 0, 0};
  glGenFramebuffers(1, &fresh.framebuffer);
  glBindFramebuffer(GL_FRAMEBUFFER, fresh.framebuffer);
  fresh.colour = attach(GL_COLOR_ATTACHMENT0, GL_RGBA32F, width, height, samples);
  if (with_depth) {
    fresh.depth = attach(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT32F, width, height, samples);
  }
  GLenum state = glCheckFramebufferStatus(GL_FRAMEBUFFER);
  GLenum problem = glGetError();
  if (state != GL_FRAMEBUFFER_COMPLETE || problem != GL_NO_ERROR) {
    target_destroy(&fresh);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "OpenGL makes no framebuffer of %u x %u pixels, %u samples (0x%x, 0x%x)",
                    width, height, samples, (unsigned)state, (unsigned)problem);
  }
  *made = fresh;
  return ASC_OK;
}

void target_destroy(target *made) {
  glDeleteFramebuffers(1, &made->framebuffer); /* 0 is ignored */
  glDeleteRenderbuffers(1, &made->colour);
  glDeleteRenderbuffers(1, &made->depth);
  const target none = {0, 0, 0};
  *made = none;
}

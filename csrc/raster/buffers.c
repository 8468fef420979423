#include "buffers.h"

#include <stddef.h>

#include "shaders.h"

/* Makes the buffer where it is not there yet. */
static asc_status load_storage(GLuint *buffer, GLuint binding, const void *bytes, size_t size, asc_error *error) {
  GLint64 most = 0;
  glGetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if ((uint64_t)size > (uint64_t)most) {
    return asc_fail(error, ASC_UNSUPPORTED, "the scene's surfaces take %zu bytes, and this OpenGL has %lld for them",
                    size, (long long)most);
  }
  if (!*buffer) {
    glGenBuffers(1, buffer);
  }
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, *buffer);
  glBufferData(GL_SHADER_STORAGE_BUFFER, (GLsizeiptr)size, bytes, GL_STATIC_DRAW);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, *buffer);
  return ASC_OK;
}

static void load_vertices(buffers *into, const geometry *shapes) {
  const bool fresh = !into->vertices;
  if (fresh) {
    glGenVertexArrays(1, &into->vertex_array);
    glBindVertexArray(into->vertex_array);
    glGenBuffers(1, &into->vertices);
  }
  glBindBuffer(GL_ARRAY_BUFFER, into->vertices);
  const size_t count = shapes->first[BATCH_COUNT] + EMPTY_TRIANGLE;
  glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof(vertex)), shapes->vertices, GL_STATIC_DRAW);
  if (fresh) {
    glVertexAttribPointer(ATTRIBUTE_POSITION, 3, GL_FLOAT, GL_FALSE, sizeof(vertex), NULL);
    glVertexAttribIPointer(ATTRIBUTE_SURFACE, 1, GL_UNSIGNED_INT, sizeof(vertex),
                           (const char *)NULL + offsetof(vertex, surface));
    glEnableVertexAttribArray(ATTRIBUTE_POSITION);
    glEnableVertexAttribArray(ATTRIBUTE_SURFACE);
  }
}

asc_status buffers_load_geometry(buffers *into, const geometry *shapes, asc_error *error) {
  load_vertices(into, shapes);
  /* Nothing in it is read where there are no surfaces, but a buffer of 0 bytes is no buffer. */
  asc_status status = load_storage(&into->surfaces, BINDING_SURFACES, shapes->surfaces,
                                   (shapes->surface_count + 1) * sizeof *shapes->surfaces, error);
  if (status == ASC_OK) {
    status = load_storage(&into->materials, BINDING_MATERIALS, shapes->materials,
                          (shapes->material_count + 1) * sizeof *shapes->materials, error);
  }
  if (status == ASC_OK && shapes->axes) {
    status = load_storage(&into->axes, BINDING_AXES, shapes->axes, (shapes->material_count + 1) * sizeof *shapes->axes,
                          error);
  }
  return status == ASC_OK ? gl_check("loading the scene", error) : status;
}

asc_status buffers_load_lighting(buffers *into, const lighting *light, asc_error *error) {
  if (light->counts.lights == 0) {
    return ASC_OK;
  }
  asc_status status =
      load_storage(&into->lights, BINDING_LIGHTS, light->lights, light->counts.lights * sizeof *light->lights, error);
  if (status == ASC_OK) {
    status = load_storage(&into->occluders, BINDING_OCCLUDERS, light->occluders,
                          (light->occluder_fours + 1) * sizeof *light->occluders, error);
  }
  return status == ASC_OK ? gl_check("loading the lights", error) : status;
}

/* Programs, put together from the texts of shader_text.c.
 *
 * A triangle is cut out by the rasteriser. A disc, a sphere or an endless plane is a rectangle, out of which the
 * fragment shader takes what the ray through the sample hits, so that its outline, or its horizon, is exact; with
 * several samples a pixel it runs for each. Patterns and light are evaluated once a pixel, at its centre, or for each
 * sample.
 *
 * A triangle's depth is written by the shader too where it runs for each sample. The rasteriser's interpolation in
 * float loses 2^-24 of the depth at the nearest corner; where the shader runs once for several samples it is the only
 * one that knows their places.
 */
#include "shaders.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "shader_text.h"

enum { MOST_SOURCES = 12, MOST_DEFINES = 500, LOG_CAPACITY = 256 };

typedef struct source_list {
  const char *texts[MOST_SOURCES];
  GLsizei count;
} source_list;

static void add(source_list *list, const char *text) { list->texts[list->count++] = text; }

static const char *define_if(bool wanted, const char *line) { return wanted ? line : ""; }

/* What the texts ask for. LIFT: a few thousand roundings of a double, and a few ten-thousandths of one of a float. */
static void write_defines(char *to, batch_kind kind, way how, const program_needs *needs) {
  const light_counts *counts = &needs->lit_by;
  (void)snprintf(
      to, MOST_DEFINES,
      "%s%s%s%s%s%s%s%s%s"
      "#define LIFT 9.094947017729282e-13LF\n" /* 2^-40 */
      "#define LIGHTS %zu\n#define SPHERES %zu\n#define PLANES %zu\n"
      "#define DISCS %zu\n#define TRIANGLES %zu\n",
      define_if(needs->perspective, "#define PERSPECTIVE\n"), define_if(how == WAY_PIXEL, "#define ONCE_A_PIXEL\n"),
      define_if(kind.pattern != ASC_PATTERN_NONE, "#define PATTERN\n"), define_if(kind.lit, "#define LIT\n"),
      define_if(kind.lit || kind.pattern != ASC_PATTERN_NONE, "#define SHADED\n"),
      define_if(kind.what == SHAPE_DISC, "#define DISC\n"), define_if(kind.what != SHAPE_TRIANGLE, "#define CUT_OUT\n"),
      define_if(needs->turned_checkers, "#define TURNED\n"), define_if(counts->any_area, "#define AREA_LIGHTS\n"),
      counts->lights, counts->spheres, counts->planes, counts->discs, counts->triangles);
}

static source_list fragment_sources(batch_kind kind, const program_needs *needs, const char *defines) {
  source_list list = {.count = 0};
  add(&list, text_version);
  add(&list, defines);
  add(&list, text_blocks);
  add(&list, text_inputs);
  add(&list, kind.what == SHAPE_SPHERE ? text_sphere : text_flat);
  if (kind.pattern != ASC_PATTERN_NONE) {
    add(&list, kind.pattern == ASC_PATTERN_CHECKER ? text_checker : text_zone_plate);
  }
  if (kind.lit) {
    add(&list, text_shadow);
    if (needs->lit_by.any_area) {
      add(&list, text_sphere_light);
    }
    add(&list, text_light);
  }
  add(&list, text_main);
  return list;
}

static asc_status report(const char *what, char log[LOG_CAPACITY], asc_error *error) {
  log[strcspn(log, "\r\n")] = '\0';
  return asc_fail(error, ASC_UNAVAILABLE, "%s: %s", what, log[0] ? log : "no reason given");
}

static asc_status compile(GLenum kind, const source_list *list, GLuint *made, asc_error *error) {
  GLuint shader = glCreateShader(kind);
  glShaderSource(shader, list->count, list->texts, NULL);
  glCompileShader(shader);
  GLint fine = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &fine);
  if (!fine) {
    char log[LOG_CAPACITY] = "";
    glGetShaderInfoLog(shader, LOG_CAPACITY, NULL, log);
    glDeleteShader(shader);
    return report("a shader does not compile with this OpenGL", log, error);
  }
  *made = shader;
  return ASC_OK;
}

static asc_status link(GLuint vertex_shader, GLuint fragment_shader, GLuint *made, asc_error *error) {
  GLuint program = glCreateProgram();
  glAttachShader(program, vertex_shader);
  glAttachShader(program, fragment_shader);
  glLinkProgram(program);
  GLint fine = GL_FALSE;
  glGetProgramiv(program, GL_LINK_STATUS, &fine);
  if (!fine) {
    char log[LOG_CAPACITY] = "";
    glGetProgramInfoLog(program, LOG_CAPACITY, NULL, log);
    glDeleteProgram(program);
    return report("the shaders do not link with this OpenGL", log, error);
  }
  *made = program;
  return ASC_OK;
}

asc_status shaders_create(size_t batch, way how, const program_needs *needs, GLuint *program, asc_error *error) {
  source_list vertex_list = {.count = 0};
  add(&vertex_list, text_version);
  add(&vertex_list, text_blocks);
  add(&vertex_list, text_vertex);
  char defines[MOST_DEFINES];
  write_defines(defines, batch_at(batch), how, needs);
  const source_list fragment_list = fragment_sources(batch_at(batch), needs, defines);
  GLuint vertex_shader = 0;
  GLuint fragment_shader = 0;
  asc_status status = compile(GL_VERTEX_SHADER, &vertex_list, &vertex_shader, error);
  if (status == ASC_OK) {
    status = compile(GL_FRAGMENT_SHADER, &fragment_list, &fragment_shader, error);
  }
  if (status == ASC_OK) {
    status = link(vertex_shader, fragment_shader, program, error);
  }
  glDeleteShader(vertex_shader); /* 0 is ignored; a linked program keeps what it needs */
  glDeleteShader(fragment_shader);
  return status;
}

/* The shaders.
 *
 * A triangle is cut out by the rasteriser. A disc or a sphere is a rectangle, out of which the fragment shader takes
 * what the ray through the sample hits, so that its outline is exact; with several samples a pixel it runs for each.
 * Patterns are evaluated once a pixel, at its centre, with the hit and the phase in double: a phase of thousands of
 * radians has no digits left in float.
 *
 * A triangle's depth is written by the shader too where there is one sample. The rasteriser's interpolation in float
 * loses 2^-24 of the depth at the nearest corner; with several samples it is the only one that knows their places.
 */
#include "shaders.h"

#include <stdlib.h>
#include <string.h>

/* The sources stay below 4095 characters each, the longest literal that C11 promises. */
static const char version_line[] = "#version 450 core\n";

static const char blocks[] = "struct Surface { dvec4 form; dvec4 plane; uint material; };\n"
                             "struct Material { dvec4 origin_scale; vec4 emission; vec4 low; vec4 high; };\n"
                             "layout(std430, binding = 0) readonly buffer Surfaces { Surface surfaces[]; };\n"
                             "layout(std430, binding = 1) readonly buffer Materials { Material materials[]; };\n"
                             "layout(std140, binding = 0) uniform Pass {\n"
                             "  dvec2 scale; dvec2 base; dvec2 depth; dvec2 shift; vec2 move;\n"
                             "};\n";

static const char vertex_source[] = "layout(location = 0) in vec3 position;\n"
                                    "layout(location = 1) in uint surface;\n"
                                    "flat out dvec4 form;\n"
                                    "flat out dvec4 plane;\n"
                                    "flat out vec3 emission;\n"
                                    "flat out uint material;\n"
                                    "void main() {\n"
                                    "  gl_Position = vec4(position.xy + move, position.z, 1.0);\n"
                                    "  form = surfaces[surface].form;\n"
                                    "  plane = surfaces[surface].plane;\n"
                                    "  material = surfaces[surface].material;\n"
                                    "  emission = materials[material].emission.rgb;\n"
                                    "}\n";

static const char fragment_inputs[] = "flat in dvec4 form;\n"
                                      "flat in dvec4 plane;\n"
                                      "flat in vec3 emission;\n"
                                      "flat in uint material;\n"
                                      "layout(location = 0) out vec4 colour;\n"
                                      /* u, v of the ray through a picture position, in pixels */
                                      "dvec2 ray(dvec2 at) { return base + scale * at; }\n"
                                      "float reversed_depth(double z) {\n"
                                      "#ifdef PERSPECTIVE\n"
                                      "  return min(float(depth.x / z), 1.0);\n"
                                      "#else\n"
                                      "  return float(depth.x + depth.y * z);\n"
                                      "#endif\n"
                                      "}\n";

/* hit(uv, p): where the ray meets the surface, in camera coordinates. nearest(uv, p): where its unbounded surface is
 * met, or nearly, for a pixel's centre that lies beside the surface; false where that says nothing. */
static const char plane_source[] = "bool nearest(dvec2 uv, out dvec3 p) {\n"
                                   "#ifdef PERSPECTIVE\n"
                                   "  double z = plane.w / (plane.x * uv.x + plane.y * uv.y + plane.z);\n"
                                   "  p = dvec3(uv * z, z);\n"
                                   "#else\n"
                                   "  double z = (plane.w - plane.x * uv.x - plane.y * uv.y) / plane.z;\n"
                                   "  p = dvec3(uv, z);\n"
                                   "#endif\n"
                                   /* false for infinity and NaN too */
                                   "  return z > 0.0 && z < 1.0e40LF;\n"
                                   "}\n"
                                   "#ifdef DISC\n"
                                   "bool hit(dvec2 uv, out dvec3 p) {\n"
                                   "  if (!nearest(uv, p)) return false;\n"
                                   "  dvec3 r = p - form.xyz;\n"
                                   "  return dot(r, r) <= form.w * form.w;\n"
                                   "}\n"
                                   "#endif\n";

/* The ray is start + t direction; q is where it passes the centre, so that nothing large cancels. */
static const char sphere_source[] = "bool meet(dvec2 uv, bool clamped, out dvec3 p) {\n"
                                    "#ifdef PERSPECTIVE\n"
                                    "  dvec3 start = dvec3(0.0), direction = dvec3(uv, 1.0);\n"
                                    "#else\n"
                                    "  dvec3 start = dvec3(uv, 0.0), direction = dvec3(0.0, 0.0, 1.0);\n"
                                    "#endif\n"
                                    "  double square = dot(direction, direction);\n"
                                    "  double middle = dot(direction, form.xyz - start) / square;\n"
                                    "  dvec3 q = start + middle * direction - form.xyz;\n"
                                    "  double inside = form.w * form.w - dot(q, q);\n"
                                    "  double half_chord = sqrt(max(inside, 0.0LF) / square);\n"
                                    "  double near = middle - half_chord, far = middle + half_chord;\n"
                                    "  double t = near > 0.0 ? near : far;\n"
                                    "  p = start + t * direction;\n"
                                    "  return t > 0.0 && (clamped || inside >= 0.0);\n"
                                    "}\n"
                                    "bool hit(dvec2 uv, out dvec3 p) { return meet(uv, false, p); }\n"
                                    "bool nearest(dvec2 uv, out dvec3 p) { return meet(uv, true, p); }\n";

static const char pattern_source[] = "vec3 pattern(dvec2 at) {\n"
                                     "  Material m = materials[material];\n"
                                     "  dvec3 p;\n"
                                     /* a plane seen from the side: as much of the one as of the other */
                                     "  if (!nearest(ray(at), p)) return mix(m.low.rgb, m.high.rgb, 0.5);\n"
                                     "  p -= m.origin_scale.xyz;\n"
                                     "  double turns = m.origin_scale.w * dot(p, p) * 0.15915494309189533577LF;\n"
                                     "  float angle = float((turns - floor(turns + 0.5LF)) * "
                                     "6.28318530717958647693LF);\n"
                                     "  return m.low.rgb + (m.high.rgb - m.low.rgb) * (0.5 + 0.5 * cos(angle));\n"
                                     "}\n";

static const char fragment_main[] = "void main() {\n"
                                    "  dvec2 at = dvec2(gl_FragCoord.xy) + shift;\n"
                                    "#ifdef ROUND\n"
                                    "  dvec3 p;\n"
                                    "  if (!hit(ray(at), p)) discard;\n"
                                    "  gl_FragDepth = reversed_depth(p.z);\n"
                                    "#elif !defined(MULTISAMPLED)\n"
                                    "  gl_FragDepth = clamp(float(form.x * at.x + form.y * at.y + form.z), 0.0, 1.0);\n"
                                    "#endif\n"
                                    "  colour = vec4(emission, 1.0);\n"
                                    "#ifdef PATTERN\n"
                                    "  colour.rgb *= pattern(dvec2(floor(gl_FragCoord.xy) + 0.5) + shift);\n"
                                    "#endif\n"
                                    "}\n";

enum { MOST_SOURCES = 12, LOG_CAPACITY = 256 };

typedef struct source_list {
  const char *texts[MOST_SOURCES];
  GLsizei count;
} source_list;

static void add(source_list *list, const char *text) { list->texts[list->count++] = text; }

static source_list fragment_sources(size_t batch, bool perspective, bool multisampled) {
  const bool patterned = batch % 2 == 1;
  const shape what = (shape)(batch / 2);
  source_list list = {.count = 0};
  add(&list, version_line);
  if (perspective) {
    add(&list, "#define PERSPECTIVE\n");
  }
  if (multisampled) {
    add(&list, "#define MULTISAMPLED\n");
  }
  if (patterned) {
    add(&list, "#define PATTERN\n");
  }
  if (what == SHAPE_DISC) {
    add(&list, "#define DISC\n");
  }
  if (what != SHAPE_TRIANGLE) {
    add(&list, "#define ROUND\n");
  }
  add(&list, blocks);
  add(&list, fragment_inputs);
  if (what == SHAPE_SPHERE) {
    add(&list, sphere_source);
  } else {
    add(&list, plane_source);
  }
  if (patterned) {
    add(&list, pattern_source);
  }
  add(&list, fragment_main);
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

asc_status shaders_create(size_t batch, bool perspective, bool multisampled, GLuint *program, asc_error *error) {
  source_list vertex_list = {.count = 0};
  add(&vertex_list, version_line);
  add(&vertex_list, blocks);
  add(&vertex_list, vertex_source);
  const source_list fragment_list = fragment_sources(batch, perspective, multisampled);
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

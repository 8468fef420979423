#define _POSIX_C_SOURCE 200112L /* clock_gettime */

#include "raster.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "buffers.h"
#include "context.h"
#include "geometry.h"
#include "gl.h"
#include "lighting.h"
#include "moment.h"
#include "shaders.h"
#include "target.h"
#include "validate.h"

/* llvmpipe snaps corners to 1/256 pixel, on which grid its samples lie too. An edge along an axis then meets samples
 * exactly, and as the top-left rule gives it those, sits 1/512 pixel low in x and y; an edge of any slope that meets no
 * sample sits right. Moving everything by half of that leaves either with .001 pixel (.0014 for a falling diagonal),
 * which is the least of the worst: measured over all phases, along an axis -.0020 to .0000, aslant .0000 to +.0028, as
 * the move goes from 0 to 1/512. One pass has the snapping of its corners besides, up to 1/512 pixel. */
#define EDGE_BIAS_PX (1.0 / 1024.0)

struct raster {
  context *gl;
  uint32_t width, height;
  float background[4];
  pass_block pass;
  size_t first[BATCH_COUNT + 1];
  bool has_surfaces[BATCH_COUNT]; /* in a picture that a pass may see */
  program_needs needs;
  buffers loaded;
  GLuint pass_buffer;
  moment *scene;           /* NULL where all passes see the same from the same place in the same light */
  pass_choices varies;     /* from pass to pass */
  target single, multiple; /* made when first asked for */
  GLuint programs[WAY_COUNT][BATCH_COUNT];
  bool warm[WAY_COUNT]; /* the driver's code for the programs is there */
  float *frame;         /* [height][width][4] */
  double *sum;          /* [height][width][3] */
};

static double seconds(clockid_t which) {
  struct timespec now = {0, 0};
  (void)clock_gettime(which, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static asc_status set_state(asc_error *error) {
  /* Of OpenGL 4.5, but libOSMesa 22.3 does not export it. */
  context_function address = context_address("glClipControl");
  PFNGLCLIPCONTROLPROC clip_control = (PFNGLCLIPCONTROLPROC)address;
  if (!clip_control) {
    return asc_fail(error, ASC_UNAVAILABLE, "this OSMesa has no glClipControl");
  }
  clip_control(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GEQUAL); /* reversed; equal, so that what is infinitely far covers the background */
  /* The near and the far corner lie on the ends of the range: nothing shall go for their rounding. */
  glEnable(GL_DEPTH_CLAMP);
  glEnable(GL_MULTISAMPLE);
  glMinSampleShading(1.0F);
  glDisable(GL_CULL_FACE);
  glDisable(GL_DITHER);
  return gl_check("setting its state", error);
}

static asc_status load_surfaces(raster *made, const asc_scene *scene, const camera *eye, asc_error *error) {
  const turn *turns = made->scene ? moment_turns(made->scene) : NULL;
  geometry shapes;
  asc_status status = geometry_create(scene, eye, turns, &shapes, error);
  if (status != ASC_OK) {
    return status;
  }
  made->needs.turned_checkers = turns != NULL;
  memcpy(made->first, shapes.first, sizeof made->first);
  for (size_t batch = 0; batch < BATCH_COUNT; ++batch) {
    made->has_surfaces[batch] =
        made->scene ? shapes.has_surfaces[batch] : shapes.first[batch] < shapes.first[batch + 1];
  }
  memcpy(made->pass.scale, shapes.scale, sizeof shapes.scale);
  memcpy(made->pass.base, shapes.base, sizeof shapes.base);
  memcpy(made->pass.depth, shapes.depth, sizeof shapes.depth);
  status = buffers_load_geometry(&made->loaded, &shapes, error);
  geometry_destroy(&shapes);
  return status;
}

/* numbers: of the points of lights with an area; see lighting_create. */
static asc_status load_lights(raster *made, const asc_scene *scene, const camera *eye, const double *numbers,
                              asc_error *error) {
  lighting light;
  asc_status status = lighting_create(scene, eye, numbers, &light, error);
  if (status == ASC_OK) {
    made->needs.lit_by = light.counts;
    status = buffers_load_lighting(&made->loaded, &light, error);
    lighting_destroy(&light);
  }
  return status;
}

static asc_status set_up(raster *made, const asc_scene *scene, asc_error *error) {
  asc_status status = set_state(error);
  if (status != ASC_OK) {
    return status;
  }
  glGenBuffers(1, &made->pass_buffer);
  glBindBuffer(GL_UNIFORM_BUFFER, made->pass_buffer);
  glBufferData(GL_UNIFORM_BUFFER, sizeof made->pass, NULL, GL_DYNAMIC_DRAW);
  glBindBufferBase(GL_UNIFORM_BUFFER, BINDING_PASS, made->pass_buffer);
  const camera eye = camera_create(&scene->view, NULL);
  status = load_surfaces(made, scene, &eye, error);
  return status == ASC_OK ? load_lights(made, scene, &eye, NULL, error) : status;
}

/* What differs from pass to pass, and the scene where anything does. */
static asc_status take_scene(raster *made, const asc_scene *scene, asc_error *error) {
  pass_choices *varies = &made->varies;
  varies->lens_radius = scene->view.lens_radius;
  varies->time = scene->motion_count > 0;
  for (size_t i = 0; i < scene->light_count; ++i) {
    varies->area_lights += lighting_has_area(&scene->lights[i]);
  }
  if (!(varies->lens_radius > 0.0) && !varies->time && varies->area_lights == 0) {
    return ASC_OK;
  }
  return moment_create(scene, &made->scene, error);
}

asc_status raster_create(const asc_scene *scene, raster **made, asc_error *error) {
  if (!made) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "nowhere to put the raster");
  }
  asc_status status = raster_validate(scene, error);
  if (status != ASC_OK) {
    return status;
  }
  raster *fresh = calloc(1, sizeof *fresh);
  if (!fresh) {
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for a raster");
  }
  fresh->width = scene->view.width;
  fresh->height = scene->view.height;
  fresh->needs.perspective = scene->view.projection == ASC_PERSPECTIVE;
  for (int i = 0; i < 3; ++i) {
    fresh->background[i] = (float)scene->view.background[i];
    fresh->pass.frame[0][i] = scene->view.right[i];
    fresh->pass.frame[1][i] = scene->view.up[i];
    fresh->pass.frame[2][i] = scene->view.forward[i];
  }
  fresh->background[3] = 1.0F;
  status = context_create(&fresh->gl, error);
  if (status == ASC_OK) {
    status = context_enter(fresh->gl, error);
  }
  if (status == ASC_OK) {
    status = take_scene(fresh, scene, error);
    if (status == ASC_OK) {
      status = set_up(fresh, fresh->scene ? moment_scene(fresh->scene) : scene, error);
    }
    context_leave();
  }
  if (status != ASC_OK) {
    raster_destroy(fresh);
    return status;
  }
  *made = fresh;
  return ASC_OK;
}

void raster_destroy(raster *made) {
  if (made) {
    context_destroy(made->gl); /* and with it all that was made in it */
    moment_destroy(made->scene);
    free(made->frame);
    free(made->sum);
    free(made);
  }
}

/* What a way of drawing needs and does not have yet: targets, programs, room for the picture. */
static asc_status prepare(raster *by, way how, asc_error *error) {
  const size_t pixels = (size_t)by->width * by->height;
  if (!by->frame) {
    by->frame = malloc(pixels * 4 * sizeof *by->frame);
  }
  if (!by->sum) {
    by->sum = malloc(pixels * 3 * sizeof *by->sum);
  }
  if (!by->frame || !by->sum) {
    return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for %u x %u pixels", by->width, by->height);
  }
  asc_status status = ASC_OK;
  if (!by->single.framebuffer) {
    status = target_create(by->width, by->height, 1, 1, &by->single, error);
  }
  if (status == ASC_OK && how != WAY_SINGLE && !by->multiple.framebuffer) {
    status = target_create(by->width, by->height, MULTISAMPLES, 1, &by->multiple, error);
  }
  for (size_t batch = 0; batch < BATCH_COUNT && status == ASC_OK; ++batch) {
    GLuint *program = &by->programs[how][batch];
    if (by->has_surfaces[batch] && !*program) {
      status = shaders_create(batch, how, &by->needs, program, error);
    }
  }
  return status;
}

/* Shows the scene as a pass sees it: from its point of the lens, at its time, by its points of the lights. */
static asc_status look(raster *by, const raster_desc *desc, size_t i, asc_error *error) {
  if (!by->scene) {
    return ASC_OK;
  }
  if (desc->times) {
    moment_set(by->scene, desc->times[i]);
  }
  const asc_scene *scene = moment_scene(by->scene);
  const camera eye = camera_create(&scene->view, desc->lens ? desc->lens + 2 * i : NULL);
  asc_status status = desc->times || desc->lens ? load_surfaces(by, scene, &eye, error) : ASC_OK;
  if (status != ASC_OK) {
    return status;
  }
  return load_lights(by, scene, &eye, desc->lights ? desc->lights + 2 * by->varies.area_lights * i : NULL, error);
}

/* Draws one pass. `warming`: the first triangle of each batch, for the driver to make its code. */
static void draw(raster *by, way how, const double offset[2], bool warming) {
  pass_block pass = by->pass;
  pass.shift[0] = offset[0] - 0.5;
  pass.shift[1] = offset[1] - 0.5;
  pass.move[0] = (float)(2.0 * (EDGE_BIAS_PX - pass.shift[0]) / by->width);
  pass.move[1] = (float)(2.0 * (EDGE_BIAS_PX - pass.shift[1]) / by->height);
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof pass, &pass);
  glBindFramebuffer(GL_FRAMEBUFFER, how == WAY_SINGLE ? by->single.framebuffer : by->multiple.framebuffer);
  glViewport(0, 0, (GLsizei)by->width, (GLsizei)by->height);
  static const GLfloat farthest = 0.0F;
  glClearBufferfv(GL_COLOR, 0, by->background);
  glClearBufferfv(GL_DEPTH, 0, &farthest);
  for (size_t batch = 0; batch < BATCH_COUNT; ++batch) {
    const bool is_empty = by->first[batch] == by->first[batch + 1];
    if (is_empty && !(warming && by->has_surfaces[batch])) {
      continue;
    }
    const size_t from = is_empty ? by->first[BATCH_COUNT] : by->first[batch];
    const size_t count = warming ? EMPTY_TRIANGLE : by->first[batch + 1] - from;
    if (runs_for_samples(batch, how)) {
      glEnable(GL_SAMPLE_SHADING);
    } else {
      glDisable(GL_SAMPLE_SHADING);
    }
    glUseProgram(by->programs[how][batch]);
    glDrawArrays(GL_TRIANGLES, (GLint)from, (GLsizei)count);
  }
}

/* Brings the pass into by->frame. The picture was drawn with y down, so OpenGL's lowest row is the top one. */
static void read_back(raster *by, way how) {
  const GLint width = (GLint)by->width;
  const GLint height = (GLint)by->height;
  if (how != WAY_SINGLE) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, by->multiple.framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, by->single.framebuffer);
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  glBindFramebuffer(GL_READ_FRAMEBUFFER, by->single.framebuffer);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, by->frame);
}

static void add_frame(raster *by, double weight) {
  const size_t pixels = (size_t)by->width * by->height;
  for (size_t i = 0; i < pixels; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      by->sum[3 * i + c] += weight * (double)by->frame[4 * i + c];
    }
  }
}

static asc_status hand_out(const raster *by, float *pixels, asc_error *error) {
  const size_t count = (size_t)by->width * by->height * 3;
  for (size_t i = 0; i < count; ++i) {
    pixels[i] = (float)by->sum[i];
    if (!isfinite(pixels[i])) {
      return asc_fail(error, ASC_NUMERIC, "pixel (%zu, %zu) is not finite: a colour is too large for float",
                      i / 3 % by->width, i / 3 / by->width);
    }
  }
  return ASC_OK;
}

static asc_status render(raster *by, const raster_desc *desc, float *pixels, raster_cost *cost, asc_error *error) {
  const way how = desc->samples_per_pass == 1 ? WAY_SINGLE : desc->sample_shading ? WAY_SAMPLE : WAY_PIXEL;
  asc_status status = prepare(by, how, error);
  if (status != ASC_OK) {
    return status;
  }
  if (!by->warm[how]) {
    status = look(by, desc, 0, error);
    if (status != ASC_OK) {
      return status;
    }
    draw(by, how, desc->offsets, true);
    read_back(by, how);
    by->warm[how] = true;
  }
  /* Of the process: llvmpipe may have been left threads of its own, and their time counts. */
  const double cpu_start = seconds(CLOCK_PROCESS_CPUTIME_ID);
  const double wall_start = seconds(CLOCK_MONOTONIC);
  memset(by->sum, 0, (size_t)by->width * by->height * 3 * sizeof *by->sum);
  for (size_t i = 0; i < desc->pass_count; ++i) {
    status = look(by, desc, i, error);
    if (status != ASC_OK) {
      return status;
    }
    draw(by, how, desc->offsets + 2 * i, false);
    read_back(by, how);
    add_frame(by, desc->weights[i]);
  }
  status = hand_out(by, pixels, error);
  if (cost) {
    cost->cpu_seconds = seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu_start;
    cost->wall_seconds = seconds(CLOCK_MONOTONIC) - wall_start;
    cost->samples = (uint64_t)desc->pass_count * desc->samples_per_pass * by->width * by->height;
  }
  return status == ASC_OK ? gl_check("drawing", error) : status;
}

asc_status raster_render(raster *made, const raster_desc *desc, float *pixels, raster_cost *cost, asc_error *error) {
  if (!made || !pixels) {
    return asc_fail(error, ASC_INVALID_ARGUMENT, "no raster, or nowhere to put the picture");
  }
  asc_status status = raster_validate_desc(desc, &made->varies, error);
  if (status == ASC_OK) {
    status = context_enter(made->gl, error);
  }
  if (status == ASC_OK) {
    status = render(made, desc, pixels, cost, error);
    context_leave();
  }
  return status;
}

/* Scenes made by hand for the tests of the rasteriser, and pictures of them. In the orthographic ones a world unit is a
 * pixel. */
#ifndef TESTS_RASTER_SCENES_H
#define TESTS_RASTER_SCENES_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <math.h>

#include "raster.h"

enum { WIDTH = 20, HEIGHT = 14, PIXELS = WIDTH * HEIGHT, MOST = 8, POSITIONS = 4 };

static const double unmoved[2] = {0.5, 0.5};
static const double one[1] = {1.0};

typedef struct stage {
  asc_scene scene;
  asc_material materials[MOST];
  double vertices[MOST][3][3];
  uint32_t triangle_material[MOST];
  asc_disc discs[MOST];
  asc_sphere spheres[MOST];
  asc_plane planes[MOST];
  asc_light lights[MOST];
  asc_motion motions[MOST];
  uint32_t motion_of[4][MOST]; /* of triangles, discs, spheres, planes */
} stage;

static inline stage *new_stage(asc_projection projection) {
  stage *s = calloc(1, sizeof *s);
  assert_non_null(s);
  const asc_view view = {.projection = projection,
                         .width = WIDTH,
                         .height = HEIGHT,
                         .eye = {0.0, 0.0, 10.0},
                         .right = {1.0, 0.0, 0.0},
                         .up = {0.0, 1.0, 0.0},
                         .forward = {0.0, 0.0, -1.0},
                         .half_width = projection == ASC_PERSPECTIVE ? 0.5 * WIDTH / HEIGHT : 0.5 * WIDTH,
                         .half_height = projection == ASC_PERSPECTIVE ? 0.5 : 0.5 * HEIGHT};
  s->scene.struct_size = sizeof s->scene;
  s->scene.view = view;
  s->scene.materials = s->materials;
  s->scene.vertices = &s->vertices[0][0][0];
  s->scene.triangle_material = s->triangle_material;
  s->scene.discs = s->discs;
  s->scene.spheres = s->spheres;
  s->scene.planes = s->planes;
  s->scene.lights = s->lights;
  s->scene.motions = s->motions;
  s->scene.triangle_motion = s->motion_of[0];
  s->scene.disc_motion = s->motion_of[1];
  s->scene.sphere_motion = s->motion_of[2];
  s->scene.plane_motion = s->motion_of[3];
  return s;
}

static inline uint32_t add_material(stage *s, double red, double green, double blue) {
  const asc_material fresh = {.emission = {red, green, blue}};
  s->materials[s->scene.material_count] = fresh;
  return (uint32_t)s->scene.material_count++;
}

static inline void add_triangle(stage *s, const double p[3][3], uint32_t material) {
  memcpy(s->vertices[s->scene.triangle_count], p, sizeof s->vertices[0]);
  s->triangle_material[s->scene.triangle_count++] = material;
}

/* A quadrilateral, its corners in picture positions, at world depth z. */
static inline void add_quad(stage *s, const double p[4][2], double z, uint32_t material) {
  for (int half = 0; half < 2; ++half) {
    double corners[3][3];
    for (int i = 0; i < 3; ++i) {
      const double *from = p[i == 0 ? 0 : i + half];
      corners[i][0] = from[0] - 0.5 * WIDTH;
      corners[i][1] = 0.5 * HEIGHT - from[1];
      corners[i][2] = z;
    }
    add_triangle(s, (const double(*)[3])corners, material);
  }
}

static inline void add_disc(stage *s, double px, double py, double radius, uint32_t material) {
  const asc_disc fresh = {{px - 0.5 * WIDTH, 0.5 * HEIGHT - py, 0.0}, {0.0, 0.0, -2.0}, radius, material};
  s->discs[s->scene.disc_count++] = fresh;
}

static inline void add_sphere(stage *s, double x, double y, double z, double radius, uint32_t material) {
  const asc_sphere fresh = {{x, y, z}, radius, material};
  s->spheres[s->scene.sphere_count++] = fresh;
}

static inline asc_plane *add_plane(stage *s, const double point[3], const double normal[3], uint32_t material) {
  asc_plane *fresh = &s->planes[s->scene.plane_count++];
  memcpy(fresh->point, point, sizeof fresh->point);
  memcpy(fresh->normal, normal, sizeof fresh->normal);
  fresh->material = material;
  return fresh;
}

/* Of intensity (1, 1/2, 1/4). */
static inline asc_light *add_light(stage *s, asc_light_kind kind, double x, double y, double z) {
  const asc_light fresh = {.kind = kind, .place = {x, y, z}, .intensity = {1.0, 0.5, 0.25}};
  s->lights[s->scene.light_count] = fresh;
  return &s->lights[s->scene.light_count++];
}

static inline raster *made_of(const stage *s) {
  raster *made = NULL;
  asc_error error = {""};
  if (raster_create(&s->scene, &made, &error) != ASC_OK) {
    fail_msg("%s", error.text);
  }
  return made;
}

/* Passes of so many samples a pixel each. */
static inline raster_desc passes_of(uint32_t samples, const double *offsets, const double *weights, size_t count,
                                    uint32_t sample_shading) {
  const raster_desc desc = {.struct_size = sizeof desc,
                            .samples_per_pass = samples,
                            .offsets = offsets,
                            .weights = weights,
                            .pass_count = count,
                            .sample_shading = sample_shading};
  return desc;
}

static inline void render_desc(raster *made, const raster_desc *desc, float *pixels) {
  asc_error error = {""};
  raster_cost cost;
  if (raster_render(made, desc, pixels, &cost, &error) != ASC_OK) {
    fail_msg("%s", error.text);
  }
  assert_int_equal(cost.samples, desc->pass_count * desc->samples_per_pass * PIXELS);
  assert_true(cost.cpu_seconds > 0.0 && cost.wall_seconds > 0.0);
}

/* How rendering ends, which says why where it does not end well. */
static inline asc_status try_desc(raster *made, const raster_desc *desc) {
  float pixels[3 * PIXELS];
  asc_error error = {""};
  const asc_status status = raster_render(made, desc, pixels, NULL, &error);
  assert_int_equal(status == ASC_OK, error.text[0] == '\0');
  return status;
}

static inline void render(raster *made, uint32_t samples, const double *offsets, const double *weights, size_t count,
                          float *pixels) {
  const raster_desc desc = passes_of(samples, offsets, weights, count, 0);
  render_desc(made, &desc, pixels);
}

/* One picture of the scene, which is done with then. */
static inline void render_once(stage *s, uint32_t samples, const double offset[2], float *pixels) {
  raster *made = made_of(s);
  render(made, samples, offset, one, 1, pixels);
  raster_destroy(made);
  free(s);
}

/* One pass with what it chooses; NULL for what it does not. */
static inline void render_pass(const stage *s, const double *time, const double *lens, const double *light,
                               float *pixels) {
  raster *made = made_of(s);
  raster_desc desc = passes_of(1, unmoved, one, 1, 0);
  desc.times = time;
  desc.lens = lens;
  desc.lights = light;
  render_desc(made, &desc, pixels);
  raster_destroy(made);
}

static inline double red(const float *pixels, int x, int y) { return (double)pixels[3 * (y * WIDTH + x)]; }

static inline double red_sum(const float *pixels) {
  double sum = 0.0;
  for (int i = 0; i < PIXELS; ++i) {
    sum += (double)pixels[3 * i];
  }
  return sum;
}

/* Passes of the R2 sequence (Roberts 2018), equal weights. */
static inline void fill_passes(size_t count, double *offsets, double *weights) {
  for (size_t i = 0; i < count; ++i) {
    offsets[2 * i] = fmod(0.5 + 0.7548776662466927 * (double)i, 1.0);
    offsets[2 * i + 1] = fmod(0.5 + 0.5698402909980532 * (double)i, 1.0);
    weights[i] = 1.0 / (double)count;
  }
}

enum { MOST_PASSES = 4096 };

/* Passes of a rank-1 lattice, evenly spaced along both axes, equal weights. */
static inline void fill_lattice(size_t count, size_t generator, double *offsets, double *weights) {
  for (size_t i = 0; i < count; ++i) {
    offsets[2 * i] = ((double)i + 0.5) / (double)count;
    offsets[2 * i + 1] = ((double)(i * generator % count) + 0.5) / (double)count;
    weights[i] = 1.0 / (double)count;
  }
}

/* The sum over the red of the picture, of so many passes of R2, or of a lattice with this generator. */
static inline double mean_area(stage *s, uint32_t samples, size_t count, size_t generator) {
  static double offsets[MOST_PASSES][2];
  static double weights[MOST_PASSES];
  if (generator) {
    fill_lattice(count, generator, &offsets[0][0], weights);
  } else {
    fill_passes(count, &offsets[0][0], weights);
  }
  float pixels[3 * PIXELS];
  raster *made = made_of(s);
  render(made, samples, &offsets[0][0], weights, count, pixels);
  raster_destroy(made);
  free(s);
  return red_sum(pixels);
}

/* Whether the picture position (px, py) is on the surface, by a pass that samples just there. */
static inline bool is_seen(raster *made, double px, double py) {
  const double offset[2] = {px - floor(px), py - floor(py)};
  float pixels[3 * PIXELS];
  render(made, 1, offset, one, 1, pixels);
  return red(pixels, (int)px, (int)py) == 1.0;
}

/* The ray through picture position (px, py) of the perspective stage. */
static inline void ray_through(double px, double py, double direction[3]) {
  direction[0] = (2.0 * px / WIDTH - 1.0) * 0.5 * WIDTH / HEIGHT;
  direction[1] = (1.0 - 2.0 * py / HEIGHT) * 0.5;
  direction[2] = -1.0;
}

#endif

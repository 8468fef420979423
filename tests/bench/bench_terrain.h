/* What the benchmarks of the tracer look at: a generated mesh of 10^5 triangles under a sun, in perspective. */
#ifndef BENCH_TERRAIN_H
#define BENCH_TERRAIN_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "aliascope/scene.h"

#define CELLS 224u /* a side */
#define TRIANGLES (2u * CELLS * CELLS)
#define MATERIALS 7u

static double terrain_vertices[TRIANGLES * 9];
static uint32_t terrain_materials[TRIANGLES];
static asc_material terrain_colours[MATERIALS];
static const asc_light terrain_sun = {
    .kind = ASC_LIGHT_DIRECTIONAL, .place = {0.8137, -0.4371, -0.3919}, .intensity = {1, 1, 1}};

static void terrain_corner(size_t at, uint32_t i, uint32_t j) {
  const double x = 2.0 * i / CELLS - 1.0, y = 2.0 * j / CELLS - 1.0;
  terrain_vertices[at] = x;
  terrain_vertices[at + 1] =
      0.21 * sin(5.1 * x + 0.3) * cos(4.3 * y) + 0.07 * sin(17.7 * x + 9.1 * y) + 0.02 * cos(41.0 * y - 13.0 * x);
  terrain_vertices[at + 2] = y;
}

static void make_mesh(void) {
  size_t at = 0;
  for (uint32_t j = 0; j < CELLS; j++) {
    for (uint32_t i = 0; i < CELLS; i++) {
      const uint32_t order[6][2] = {{i, j}, {i + 1, j}, {i + 1, j + 1}, {i, j}, {i + 1, j + 1}, {i, j + 1}};
      for (int k = 0; k < 6; k++, at += 3) terrain_corner(at, order[k][0], order[k][1]);
    }
  }
  for (size_t i = 0; i < TRIANGLES; i++) terrain_materials[i] = (uint32_t)(i % MATERIALS);
  for (int i = 0; i < (int)MATERIALS; i++) {
    terrain_colours[i].emission[i % 3] = 0.1 + 0.1 * i;
    terrain_colours[i].albedo[i % 3] = 0.5;
  }
}

/* Seen from above at 37 degrees, so that the mesh fills about half of the picture. Without its light. */
static asc_scene make_terrain(uint32_t width, uint32_t height) {
  const double slope = 0.6457718232379019; /* 37 degrees, in radians */
  make_mesh();
  return (asc_scene){.struct_size = sizeof(asc_scene),
                     .view = {.projection = ASC_PERSPECTIVE,
                              .width = width,
                              .height = height,
                              .eye = {0.05, 1.5, 1.9},
                              .right = {1, 0, 0},
                              .up = {0, cos(slope), -sin(slope)},
                              .forward = {0, -sin(slope), -cos(slope)},
                              .half_width = 0.42 * width / height,
                              .half_height = 0.42},
                     .materials = terrain_colours,
                     .material_count = MATERIALS,
                     .vertices = terrain_vertices,
                     .triangle_material = terrain_materials,
                     .triangle_count = TRIANGLES};
}

#endif

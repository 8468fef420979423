/* The rasteriser on OSMesa (llvmpipe): its whole interface.
 *
 * The same surfaces as the tracer draws, through an RGBA32F framebuffer object. One pass has one sample at the centre
 * of each pixel, or the four of llvmpipe's multisampling; more passes move the picture by a sub-pixel offset each and
 * are summed in double (Haeberli and Akeley 1990, "The accumulation buffer").
 *
 * Triangles are cut out by the rasteriser, which snaps corners to 1/256 pixel: an edge is seen within .004 pixel in one
 * pass, and within .0014 in the mean of passes over the pixel. Discs, spheres and endless planes are cut out by the
 * shader at the place of each sample, exactly: a horizon is an edge, and multisampled as one. Patterns, light and
 * shadows are evaluated in double once a pixel and pass, at the centre of the pixel as the pass is moved, with
 * multisampling too, which therefore smooths outlines only; or, with sample_shading, at the place of each sample. Where
 * the centre of a pixel sees nothing of a plane that a sample of the pixel sees, the sample's place stands in for it; a
 * triangle that reaches its own horizon there has the mean of its pattern's colours, and no light.
 *
 * Shadows are hard and exact: the shader tests the way to each light against every surface of the scene, also those
 * outside of the picture. There is no cheaper way that is exact, and so no picture beyond RASTER_MOST_SHADOW_TESTS.
 *
 * A lens, what moves, and lights with an area are sums over passes as well: each pass looks through one point of the
 * lens (the eye moves there and the frustum is skewed, so that what is in focus keeps its place), at one time, and each
 * light is the point of it that the pass has chosen, with the cosine there where it falls off, and with its shadows. So
 * a pass is one sample of every pixel, and what the tracer would find for it; the mean goes to the tracer's. The scene
 * is moved, clipped and loaded again for each pass; context, shaders and targets stay.
 *
 * A part of a triangle that lies nearer to the plane of a perspective eye than 2^-40 of the triangle's largest
 * coordinate is not drawn. With multisampling depths of triangles are told apart by 2^-23 of the depth of what lies
 * nearest, as by a depth buffer of 24 bits; with one sample, or sample_shading, by 2^-23 of themselves. In an
 * orthographic view it is 2^-23 of the whole range of depths in the picture, which a plane seen nearly from the side
 * makes long.
 *
 * Mesa reads LP_NUM_THREADS from the environment when the first context is made; set it to 0 before, and it draws in
 * the calling thread.
 */
#ifndef RASTER_H
#define RASTER_H

#include "aliascope/base.h"
#include "aliascope/scene.h"

typedef struct raster raster;

/* Tests for shadow a pixel, in a scene with lights and a surface that takes light: (triangles + discs + spheres +
 * planes) x lights. A scene that needs more is ASC_UNSUPPORTED. A test was measured to take 9 to 15 ns, so that this
 * many take .15 s of 128 x 96 pixels, where a flat picture takes .0002 s; and llvmpipe leaves loops, without a word,
 * after 65,535 rounds in a pixel. */
enum { RASTER_MOST_SHADOW_TESTS = 1024 };

/* ASC_UNAVAILABLE where OSMesa gives no context of OpenGL 4.5 or a shader does not compile; ASC_INVALID_ARGUMENT for a
 * scene that is not finite or names a material it does not have; ASC_UNSUPPORTED for one with too many surfaces for its
 * lights, or for OpenGL's buffers. One raster belongs to one thread. */
ASC_API asc_status raster_create(const asc_scene *scene, raster **made, asc_error *error);
ASC_API void raster_destroy(raster *made);

typedef struct raster_desc {
  size_t struct_size;
  /* 1, or 4 for llvmpipe's multisampling; any other is ASC_UNSUPPORTED */
  uint32_t samples_per_pass;
  /* [pass_count][2]: where in the pixel, in [0, 1) from its left and top border, the pass samples: (0.5, 0.5) is an
   * unmoved pass. With multisampling the pattern of 4 is moved as a whole, by offset - 0.5. */
  const double *offsets;
  /* [pass_count]: they should sum to 1 */
  const double *weights;
  size_t pass_count;
  /* 1: with multisampling patterns, light and shadows are evaluated for each sample, at its place; 0: once a pixel */
  uint32_t sample_shading;
  /* [pass_count]: when each pass sees the scene; NULL where nothing moves */
  const double *times;
  /* [pass_count][2]: the point of the lens through which it looks, along right and up from the middle, in the scene's
   * units; NULL without a lens */
  const double *lens;
  /* [pass_count][lights with an area][2] in [0, 1): choose the point of each light, in the scene's order, as tracer.h
   * says; NULL where no light has an area */
  const double *lights;
} raster_desc;

typedef struct raster_cost {
  uint64_t samples;                 /* all of them: passes x samples_per_pass x pixels */
  double cpu_seconds, wall_seconds; /* drawing, reading back and summing; without making context, shaders, buffers */
} raster_cost;

/* Renders into `pixels`, [height][width][3] float, linear RGB, row 0 on top. `cost` may be NULL. */
ASC_API asc_status raster_render(raster *made, const raster_desc *desc, float *pixels, raster_cost *cost,
                                 asc_error *error);

/* GL_RENDERER and GL_VERSION of a context, "llvmpipe (...); 4.5 ..." . ASC_UNAVAILABLE as above. */
ASC_API asc_status raster_describe(char *text, size_t capacity);

/* What OpenGL says of its rasteriser. samples: of a multisample buffer that was asked for 4, 0 where there is none. */
typedef struct raster_limits {
  uint32_t max_samples, samples, subpixel_bits;
} raster_limits;

/* ASC_UNAVAILABLE as above. */
ASC_API asc_status raster_ask_limits(raster_limits *limits, asc_error *error);

/* The sample positions of the multisample buffer, [4][2], from the left and top border of the pixel. */
ASC_API asc_status raster_sample_positions(double *positions, asc_error *error);

#endif

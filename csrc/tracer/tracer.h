/* The distribution ray tracer on Embree 3: its whole interface.
 *
 * The same scene, desc and seed give the same bits, whatever the number of threads or the order of tiles: which rays
 * share a packet, and the order of every sum, follow from the pixel alone.
 */
#ifndef TRACER_H
#define TRACER_H

#include "aliascope/base.h"
#include "aliascope/estimate.h"
#include "aliascope/filter.h"
#include "aliascope/sampler.h"
#include "aliascope/scene.h"

typedef struct tracer tracer;

/* Builds the acceleration structure. ASC_UNAVAILABLE where Embree will not start, ASC_INVALID_ARGUMENT for a scene
 * that is not finite or names a material it does not have. */
ASC_API asc_status tracer_create(const asc_scene *scene, tracer **made, asc_error *error);

/* In what the samples of a picture are added up. */
typedef enum tracer_film {
  TRACER_FILM_DOUBLE = 0,
  /* In float each of N additions may be off by half a unit in the last place of the sum so far: the mean of N samples,
   * none negative, by (N - 1) 2^-24 of itself at most. Like samples are rounded alike, so that it may come to a good
   * part of that. Every picture of more than one sample differs in last bits. */
  TRACER_FILM_FLOAT = 1,
  /* In two floats, the second what the first rounds away (film.h), as where there is no double: off by 2^-47 of the sum
   * so far with each addition, so with 2^22 samples nearer than half the last place of a picture. Takes the memory of
   * doubles. */
  TRACER_FILM_COMPENSATED = 2
} tracer_film;

/* What a tracer pays for safety and speed. 0: the default. */
typedef struct tracer_options {
  size_t struct_size;
  /* Rays that Embree traces together: 1, 4, 8, 16 or 0: 16. Its kernels of each width round differently: the pictures
   * are the same but where a sample lies within some roundings of an edge. */
  uint32_t packet;
  /* 1: without Embree's robust mode. Rays that meet an edge to within their roundings may then pass between the two
   * triangles that share it (one in ten of those aimed at one; in robust mode none), or at a corner (one in four; in
   * robust mode a few in a hundred, but for `look_once`), and pictures of meshes may have samples of what lies behind.
   * Others differ at edges, by roundings. */
  uint32_t not_robust;
  /* 1: places are rounded to float in the world, before the eye is subtracted, as in tracers whose vertices are floats
   * of the world; and lengths are those of the scene, whatever float holds of them. */
  uint32_t not_relative;
  /* 1: rays from the eye that meet nothing, beside others that meet something, are not looked at again. In robust mode
   * too rays pass between triangles that share a corner, a few in a hundred of those aimed at it to the last bit. Where
   * no corner has triangles all round it, nothing is looked at again. */
  uint32_t look_once;
  tracer_film film; /* of pictures with as many samples in every pixel; adaptive ones have the estimator's own sums */
} tracer_options;

/* The same with options, which may be NULL. ASC_INVALID_ARGUMENT too for options that there are not. */
ASC_API asc_status tracer_create_with(const asc_scene *scene, const tracer_options *options, tracer **made,
                                      asc_error *error);
ASC_API void tracer_destroy(tracer *made);

/* How many numbers each sample has: the dimensions that a sampler needs. What a scene does not ask for has none. In
 * this order, so many each:
 *
 *   2      the place in the pixel
 *   1      the time, where something moves while the shutter is open: the inverse of the response's distribution
 *   2      the point of the lens, where there is one: the disc by the concentric map; of a polygon's corners a_k, with
 *          k = floor(blades u), f = blades u - k and w the second, sqrt(w) ((1 - f) a_k + f a_(k + 1))
 *   2      each light with an area, in the scene's order: its point, uniform by area; of discs and of the cap of a
 *          sphere that is seen by the concentric map
 *   2      the place on a surface that shines, where there is one but for planes and meshes of frames, and gloss or
 *          diffuse bounces: the first also says which, each as often as its power is of all
 *   then for each bounce, `mirror_bounces` where a surface reflects and `diffuse_bounces` where one scatters:
 *   1      how the path goes on, or ends, where there are diffuse bounces
 *   2      the direction, where there are gloss or diffuse bounces
 *
 * Every vertex of a path takes the same numbers for a light. The estimate at each is unbiased by itself, and the sum so
 * too. */
ASC_API uint32_t tracer_dimensions(const tracer *made);

/* The sizes of these groups, in their order: what asc_sampler_arrange takes. `count` gets how many there are; `sizes`,
 * where it is not NULL, has room for them. */
ASC_API void tracer_groups(const tracer *made, uint32_t *sizes, size_t *count);

typedef struct tracer_desc {
  size_t struct_size;
  const asc_sampler *sampler; /* its N is the number of samples a pixel; at least tracer_dimensions; not owned */
  uint32_t threads;           /* 0: 1 */
  const asc_filter *filter;   /* NULL: box; not owned */
} tracer_desc;

typedef struct tracer_cost {
  uint64_t samples; /* all of them, those in pixels beyond the picture that a filter reaches too */
  uint64_t primary_rays;
  double cpu_seconds; /* of the rendering threads together, without the build */
  double wall_seconds;
  double build_cpu_seconds; /* of the acceleration structure */
  uint64_t shadow_rays;
  uint64_t reflection_rays; /* along mirrors, and in their lobes */
  uint64_t bounce_rays;     /* scattered by an albedo */
} tracer_cost;

/* Renders into `pixels`, [height][width][3] float, linear RGB, summed as the options say. With the box, each pixel's
 * mean. With another filter, samples count in all pixels whose filter holds them, and pixels beyond the picture's
 * border are sampled for those within; film.h says how a pixel is made of them. `cost` may be NULL. */
ASC_API asc_status tracer_render(tracer *made, const tracer_desc *desc, float *pixels, tracer_cost *cost,
                                 asc_error *error);

typedef struct tracer_adaptive_desc {
  size_t struct_size;
  const asc_estimator *estimator; /* of three channels, its sampler of at least tracer_dimensions; not owned */
  uint32_t threads;               /* 0: 1 */
} tracer_adaptive_desc;

/* Renders with as many samples in each pixel as the estimator finds that it needs: the box filter, the estimate of each
 * pixel being its value. `counts`, [height][width] or NULL, gets the samples of each pixel; those that two pixels share
 * count in both. `cost` has every sample once, those in pixels beyond the border of a tile that the estimator looks at
 * too. */
ASC_API asc_status tracer_render_adaptive(tracer *made, const tracer_adaptive_desc *desc, float *pixels,
                                          uint32_t *counts, tracer_cost *cost, asc_error *error);

/* Embree's version, as 31305 for 3.13.5: the one that this was compiled with. */
ASC_API uint32_t tracer_embree_version(void);

/* Of the Embree that is loaded, and of how a scene is traced with it. */
typedef struct tracer_kernel {
  uint32_t version; /* as above */
  uint32_t packet;  /* rays that are traced together: of the options */
  uint32_t native;  /* the largest packet that the machine's instructions hold: 4 (SSE), 8 (AVX) or 16 (AVX-512) */
  uint32_t robust;  /* 1: no ray passes between triangles that share an edge */
} tracer_kernel;

ASC_API void tracer_describe(const tracer *made, tracer_kernel *kernel);

#endif

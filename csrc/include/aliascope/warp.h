/* Warps: maps that turn uniform points of the unit square into points of a stated density elsewhere, each with its
 * inverse and its density.
 *
 * Every function works on n points, row-major, so that what asc_sampler_fill wrote can be given on. `u` has two
 * columns (one for a density in one dimension), each in [0, 1], both ends included. Densities (pdf) are with respect to
 * area or, for directions, solid angle in steradian; they are 0 outside the domain. Directions are unit vectors
 * (x, y, z), z the axis of the hemisphere; a length within 1e-6 of 1 is taken as rounding. All warps are continuous and
 * map equal areas of the square to equal probabilities.
 *
 * inverse(sample(u)) is u within ASC_WARP_ROUND_TRIP, on the edges and corners of the square too; where a density is
 * above 1, within that many times the density, as steps of the point are that many times larger in u.
 *
 * ASC_INVALID_ARGUMENT: a null pointer, or a row with a value outside its range or not a number; the rows before it
 * have then been written. The arrays of a call must not overlap. All functions may be called from any thread. */
#ifndef ASC_WARP_H
#define ASC_WARP_H

#include "aliascope/base.h"

#define ASC_WARP_ROUND_TRIP 4.5e-16 /* four steps of a double below 1; three were met */

/* The unit disc, concentric: Shirley and Chiu 1997, "A low distortion map between disk and square". Points (n, 2).
 * pdf 1/pi. The inverse takes points up to a radius of 1 + 1e-6. */
ASC_API asc_status asc_disc_sample(const double *u, size_t n, double *points);
ASC_API asc_status asc_disc_inverse(const double *points, size_t n, double *u);
ASC_API asc_status asc_disc_pdf(const double *points, size_t n, double *pdf);

/* Directions with z >= 0 by the cosine z: the concentric disc lifted to the hemisphere (Malley's method). Directions
 * (n, 3). pdf z/pi. On the edge of the square z and the pdf are 0: a sample there weighs nothing; do not divide by its
 * pdf. */
ASC_API asc_status asc_cosine_hemisphere_sample(const double *u, size_t n, double *directions);
ASC_API asc_status asc_cosine_hemisphere_inverse(const double *directions, size_t n, double *u);
ASC_API asc_status asc_cosine_hemisphere_pdf(const double *directions, size_t n, double *pdf);

/* Directions with z >= 0, uniform: Shirley and Chiu 1997, section 3, z = 1 - r^2. pdf 1/(2 pi). */
ASC_API asc_status asc_uniform_hemisphere_sample(const double *u, size_t n, double *directions);
ASC_API asc_status asc_uniform_hemisphere_inverse(const double *directions, size_t n, double *u);
ASC_API asc_status asc_uniform_hemisphere_pdf(const double *directions, size_t n, double *pdf);

/* All directions, uniform: Clarberg 2008, "Fast equal-area mapping of the (hemi)sphere using SIMD", the square folded
 * as an octahedron. pdf 1/(4 pi). The edge of the square is glued to itself: (u, 0) and (1 - u, 0) are one direction,
 * and the four corners are (0, 0, -1); the sign of a zero in x or y tells the inverse which. */
ASC_API asc_status asc_sphere_sample(const double *u, size_t n, double *directions);
ASC_API asc_status asc_sphere_inverse(const double *directions, size_t n, double *u);
ASC_API asc_status asc_sphere_pdf(const double *directions, size_t n, double *pdf);

/* A triangle, uniform: Heitz 2019, "A low-distortion map between triangle and square". Barycentric coordinates (n, 3),
 * not negative, of sum 1 but for rounding; no edge of the square shrinks to a corner. The inverse takes a sum within
 * 1e-6 of 1, and reads the first two. */
ASC_API asc_status asc_triangle_sample(const double *u, size_t n, double *barycentrics);
ASC_API asc_status asc_triangle_inverse(const double *barycentrics, size_t n, double *u);

/* One over the area of the triangle of three vertices (x, y, z). ASC_INVALID_ARGUMENT where the area is 0, as for
 * vertices on one line, or it or its inverse is not finite. */
ASC_API asc_status asc_triangle_pdf(const double vertices[9], double *pdf, asc_error *error);

/* A density that is constant in each cell of a regular grid over [0, 1) or [0, 1)^2. Immutable once made. */
typedef struct asc_density asc_density;

typedef struct asc_density_desc {
  size_t struct_size;    /* sizeof(asc_density_desc) */
  const double *weights; /* (rows, columns), row-major, finite, not negative, not all zero; copied */
  size_t columns;        /* cells along x, 1 to 2^31 */
  size_t rows;           /* cells along y, 1 to 2^31; 0: a density in one dimension */
} asc_density_desc;

/* Makes a density by the inverse of its distribution function: of the row, then within it. Takes time and 16 bytes of
 * memory a cell. ASC_INVALID_VALUE for weights that are no density, ASC_INVALID_ARGUMENT, ASC_OUT_OF_MEMORY. */
ASC_API asc_status asc_density_create(const asc_density_desc *desc, asc_density **density, asc_error *error);
ASC_API void asc_density_destroy(asc_density *density);

/* Columns of u and of points: 1 or 2. 0 for NULL. */
ASC_API uint32_t asc_density_dimensions(const asc_density *density);

/* u to points (x) or (x, y) in [0, 1); (size_t)(x * columns) is the column of one. A cell of weight 0 is never met, for
 * no u; one that holds less than 2^-53 of the whole (in two dimensions: of its row, or its row of the whole) cannot be
 * met either, for want of digits in u. Logarithmic time in columns and rows. */
ASC_API asc_status asc_density_sample(const asc_density *density, const double *u, size_t n, double *points);

/* ASC_INVALID_ARGUMENT for a point where the density is 0. */
ASC_API asc_status asc_density_inverse(const asc_density *density, const double *points, size_t n, double *u);

/* Weight over mean weight, of integral 1; 0 outside [0, 1). */
ASC_API asc_status asc_density_pdf(const asc_density *density, const double *points, size_t n, double *pdf);

#endif

/* The check of a scene, before anything is made of it. */
#ifndef RASTER_VALIDATE_H
#define RASTER_VALIDATE_H

#include <stdbool.h>
#include <stddef.h>

#include "aliascope/base.h"
#include "aliascope/scene.h"
#include "raster.h"

/* Pixels along a side at most: the largest renderbuffer of llvmpipe. */
#define RASTER_LARGEST_SIDE 16384u
/* Coordinates and colours beyond this are refused: products of three still fit in double, colours in float. */
#define RASTER_LARGEST_NUMBER 1e30

/* ASC_INVALID_ARGUMENT and a text for the first thing that is wrong: numbers that are not finite or too large, indices
 * of materials that are not there, sizes, radii and normals out of range. ASC_UNSUPPORTED where there are more
 * surfaces and lights than shadows are tested for. */
asc_status raster_validate(const asc_scene *scene, asc_error *error);

/* What the passes of a scene choose, beside their place in the pixel. */
typedef struct pass_choices {
  double lens_radius; /* 0: none */
  bool time;
  size_t area_lights;
} pass_choices;

/* ASC_INVALID_ARGUMENT where the passes are not as raster.h has them. */
asc_status raster_validate_desc(const raster_desc *desc, const pass_choices *varies, asc_error *error);

#endif

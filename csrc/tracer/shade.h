/* Radiance along a ray whose hit Embree found. */
#ifndef TRACER_SHADE_H
#define TRACER_SHADE_H

#include <math.h>

#include "scene.h"

/* The pattern's colour at a point of the camera frame, times emission. */
void shade_pattern(const tracer *made, uint32_t geometry, uint32_t primitive, double sample_x, double sample_y,
                   const asc_material *material, double radiance[3]);

/* Linear RGB: a constant of the scene, or `patterned` after writing it. (sample_x, sample_y): in the picture, pixels.
 */
static inline const double *shade(const tracer *made, uint32_t geometry, uint32_t primitive, double sample_x,
                                  double sample_y, double patterned[3]) {
  if (geometry == RTC_INVALID_GEOMETRY_ID) return made->view.background;
  const asc_material *material = &made->materials[made->material_of[geometry][primitive]];
  if (material->pattern.kind == ASC_PATTERN_NONE) return material->emission;
  shade_pattern(made, geometry, primitive, sample_x, sample_y, material, patterned);
  return patterned;
}

#endif

#include "shade.h"

void shade_pattern(const tracer *made, uint32_t geometry, uint32_t primitive, double sample_x, double sample_y,
                   const asc_material *material, double radiance[3]) {
  /* The ray again, in double: a phase of many turns has no digits left in float. */
  const asc_view *view = &made->view;
  const double u = (2.0 * sample_x / view->width - 1.0) * view->half_width;
  const double v = (1.0 - 2.0 * sample_y / view->height) * view->half_height;
  const int perspective = view->projection == ASC_PERSPECTIVE;
  const double origin[3] = {perspective ? 0.0 : u, perspective ? 0.0 : v, 0.0};
  const double direction[3] = {perspective ? u : 0.0, perspective ? v : 0.0, 1.0};
  double point[3];
  tracer_hit_point(made, geometry, primitive, origin, direction, point);

  const asc_pattern *pattern = &material->pattern;
  double away[3];
  for (int i = 0; i < 3; i++) away[i] = point[i] - pattern->origin[i];
  const double mix = 0.5 * (1.0 + cos(pattern->scale * dot(away, away)));
  for (int i = 0; i < 3; i++)
    radiance[i] = material->emission[i] * (pattern->low[i] + (pattern->high[i] - pattern->low[i]) * mix);
}

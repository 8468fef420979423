#include "lens.h"

#include "concentric.h"

static void polygon_point(uint32_t blades, const double u[2], double point[2]) {
  const double turned = blades * u[0];
  const double first = fmin(floor(turned), blades - 1.0), step = 2.0 * ASC_PI / blades;
  const double share = turned - first, out = sqrt(u[1]);
  point[0] = out * ((1.0 - share) * sin(step * first) + share * sin(step * (first + 1.0)));
  point[1] = out * ((1.0 - share) * cos(step * first) + share * cos(step * (first + 1.0)));
}

void lens_points(const asc_view *view, size_t count, const double (*u)[2], double (*points)[2]) {
  for (size_t i = 0; i < count; i++) {
    if (view->blades)
      polygon_point(view->blades, u[i], points[i]);
    else
      (void)asc_to_disc(u[i], points[i]);
    points[i][0] *= view->lens_radius;
    points[i][1] *= view->lens_radius;
  }
}

#include "lens.h"

#include "concentric.h"
#include "vectorise.h"

void lens_make(const asc_view *view, lens *made) {
  *made = (lens){.radius = view->lens_radius, .blades = view->blades};
  if (!view->blades) return;
  const double step = 2.0 * ASC_PI / view->blades;
  for (uint32_t i = 0; i <= view->blades; i++) {
    made->corners[i][0] = sin(step * i);
    made->corners[i][1] = cos(step * i);
  }
}

ASC_VECTORISE static void round_points(size_t count, double radius, const double (*u)[2], double (*points)[2]) {
  for (size_t i = 0; i < count; i++) {
    (void)asc_to_disc(u[i], points[i]);
    points[i][0] *= radius;
    points[i][1] *= radius;
  }
}

static void polygon_point(const lens *through, const double u[2], double point[2]) {
  const double turned = through->blades * u[0];
  const uint32_t last = through->blades - 1, whole = (uint32_t)turned, first = whole < last ? whole : last;
  const double share = turned - first, out = through->radius * sqrt(u[1]);
  const double *from = through->corners[first], *to = through->corners[first + 1];
  for (int i = 0; i < 2; i++) point[i] = out * ((1.0 - share) * from[i] + share * to[i]);
}

void lens_points(const lens *through, size_t count, const double (*u)[2], double (*points)[2]) {
  if (!through->blades) {
    round_points(count, through->radius, u, points);
    return;
  }
  for (size_t i = 0; i < count; i++) polygon_point(through, u[i], points[i]);
}

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

#define TILE 64

ASC_INLINE void take_columns(const double *restrict u, size_t stride, size_t rows, double *restrict a,
                             double *restrict b) {
  for (size_t i = 0; i < rows; i++) {
    a[i] = u[i * stride];
    b[i] = u[i * stride + 1];
  }
}

/* A tile at a time, in columns. Steps of a point wait for each other, so the loop over them is long enough that the
 * machine has several points under way. */
ASC_VECTORISE static void round_points(double radius, size_t count, const double *restrict u, size_t stride,
                                       double (*restrict points)[2]) {
  for (size_t first = 0; first < count; first += TILE) {
    const size_t rows = count - first < TILE ? count - first : TILE;
    double a[TILE], b[TILE];
    if (stride == 4) /* of scenes with a lens alone; a known step is vectorised */
      take_columns(u + first * 4, 4, rows, a, b);
    else
      take_columns(u + first * stride, stride, rows, a, b);
    for (size_t i = 0; i < rows; i++) {
      const double from[2] = {a[i], b[i]};
      double to[2];
      (void)asc_to_disc(from, to);
      a[i] = radius * to[0];
      b[i] = radius * to[1];
    }
    for (size_t i = 0; i < rows; i++) {
      points[first + i][0] = a[i];
      points[first + i][1] = b[i];
    }
  }
}

static void polygon_point(const lens *through, const double u[2], double point[2]) {
  const double turned = through->blades * u[0];
  const uint32_t last = through->blades - 1, whole = (uint32_t)turned, first = whole < last ? whole : last;
  const double share = turned - first, out = through->radius * sqrt(u[1]);
  const double *from = through->corners[first], *to = through->corners[first + 1];
  for (int i = 0; i < 2; i++) point[i] = out * ((1.0 - share) * from[i] + share * to[i]);
}

void lens_points(const lens *through, size_t count, const double *u, size_t stride, double (*points)[2]) {
  if (!through->blades) {
    round_points(through->radius, count, u, stride, points);
    return;
  }
  for (size_t i = 0; i < count; i++) polygon_point(through, u + i * stride, points[i]);
}

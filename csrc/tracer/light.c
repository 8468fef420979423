#include "light.h"

#include <float.h>

#include "concentric.h"
#include "vector.h"

int light_has_area(const asc_light *given) {
  return given->kind != ASC_LIGHT_POINT && given->kind != ASC_LIGHT_DIRECTIONAL;
}

/* A point of a parallelogram or a disc, uniform by area. */
static void flat_point(const asc_light *given, const double u[2], double chosen[3]) {
  double along[2] = {u[0], u[1]};
  if (given->kind == ASC_LIGHT_DISC) (void)asc_to_disc(u, along);
  for (int i = 0; i < 3; i++)
    chosen[i] = given->place[i] + along[0] * given->edges[0][i] + along[1] * given->edges[1][i];
}

/* A point of the cap of a sphere that is seen from a point, uniform by area, and the normal there. The cap is that with
 * cosines of 1 - share to 1 about the way to the point. Gives `share`; 0 from within the sphere. */
static double cap_point(const asc_light *given, const double u[2], const double seen_from[3], double chosen[3],
                        double normal[3]) {
  double axis[3], a[3], b[3], disc[2];
  for (int i = 0; i < 3; i++) axis[i] = seen_from[i] - given->place[i];
  const double distance = sqrt(dot(axis, axis));
  if (!(distance > given->radius)) return 0.0;
  for (int i = 0; i < 3; i++) axis[i] /= distance;
  const double share = 1.0 - given->radius / distance;
  (void)asc_to_disc(u, disc);
  across(axis, a, b);
  const double cosine = 1.0 - share * (disc[0] * disc[0] + disc[1] * disc[1]), sine = sqrt(share * (1.0 + cosine));
  for (int i = 0; i < 3; i++) {
    normal[i] = cosine * axis[i] + sine * (disc[0] * a[i] + disc[1] * b[i]);
    chosen[i] = given->place[i] + given->radius * normal[i];
  }
  return share;
}

/* Of those: a surface through the light that is seen so flat that the way runs along it for longer than this may stand
 * in its way; below that the way ends before it. */
#define FREE_END 8.0

/* How near to a light the tracer cannot tell what lies where: a few roundings of float, of the larger coordinates. */
static double blur(const double chosen[3], const double point[3]) {
  double largest = 0.0;
  for (int i = 0; i < 3; i++) largest = fmax(largest, fmax(fabs(chosen[i]), fabs(point[i])));
  return 128.0 * FLT_EPSILON * largest;
}

static double toward_point(const double chosen[3], const double point[3], double toward[3]) {
  for (int i = 0; i < 3; i++) toward[i] = chosen[i] - point[i];
  const double distance = sqrt(dot(toward, toward));
  for (int i = 0; i < 3; i++) toward[i] /= distance;
  return distance;
}

double light_toward(const light_source *from, const double u[2], const double point[3], double toward[3],
                    double *arriving) {
  const asc_light *given = &from->given;
  *arriving = 1.0;
  for (int i = 0; i < 3; i++) toward[i] = 0.0;
  if (given->kind == ASC_LIGHT_DIRECTIONAL) {
    for (int i = 0; i < 3; i++) toward[i] = given->place[i];
    return INFINITY;
  }
  double chosen[3] = {0.0}, normal[3] = {0.0}, seen = 1.0;
  if (given->kind == ASC_LIGHT_POINT) {
    for (int i = 0; i < 3; i++) chosen[i] = given->place[i];
  } else if (given->kind == ASC_LIGHT_SPHERE) {
    const double share = cap_point(given, u, point, chosen, normal);
    if (share == 0.0) {
      *arriving = 0.0;
      return 0.0;
    }
    seen = 2.0 * share; /* the cap has the area 2 pi r^2 share, and the radiance is pi intensity / (pi r^2) */
  } else {
    flat_point(given, u, chosen);
    for (int i = 0; i < 3; i++) normal[i] = from->normal[i];
  }
  const double distance = toward_point(chosen, point, toward), near = blur(chosen, point);
  if (!(distance > near)) {
    *arriving = 0.0;
    return 0.0;
  }
  const double leaving = given->kind == ASC_LIGHT_POINT ? 1.0 : fmax(0.0, -dot(normal, toward));
  if (given->inverse_square) *arriving = seen * leaving / (distance * distance);
  return fmax(distance - FREE_END * near, 0.0);
}

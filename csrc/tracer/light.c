#include "light.h"

#include <float.h>

#include "concentric.h"
#include "vectorise.h"

int light_has_area(const asc_light *given) {
  return given->kind != ASC_LIGHT_POINT && given->kind != ASC_LIGHT_DIRECTIONAL;
}

/* Points of a light, as lanes see them. */
typedef struct chosen_points {
  vectors place, normal;
  alignas(64) double seen[PACKET]; /* of a sphere's light, how much these stand for; 0: none is seen; else 1 */
  alignas(64) double away[PACKET]; /* their distance, where it is not too short */
} chosen_points;

ASC_INLINE void on_parallelogram(const light_source *from, double along_a, double along_b, uint32_t lane,
                                 chosen_points *chosen) {
  const asc_light *given = &from->given;
  for (int i = 0; i < 3; i++) {
    chosen->place.row[i][lane] = given->place[i] + along_a * given->edges[0][i] + along_b * given->edges[1][i];
    chosen->normal.row[i][lane] = from->normal[i];
  }
  chosen->seen[lane] = 1.0;
}

ASC_VECTORISE static void choose_of_parallelogram(const light_source *restrict from, const pairs *restrict u,
                                                  chosen_points *restrict chosen) {
  for (uint32_t lane = 0; lane < PACKET; lane++) on_parallelogram(from, u->row[0][lane], u->row[1][lane], lane, chosen);
}

ASC_VECTORISE static void choose_of_point(const light_source *restrict from, chosen_points *restrict chosen) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    for (int i = 0; i < 3; i++) chosen->place.row[i][lane] = from->given.place[i];
    chosen->seen[lane] = 1.0;
  }
}

ASC_VECTORISE static void choose_of_disc(const light_source *restrict from, const pairs *restrict u,
                                         chosen_points *restrict chosen) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double numbers[2] = {u->row[0][lane], u->row[1][lane]};
    double disc[2];
    (void)asc_to_disc(numbers, disc);
    on_parallelogram(from, disc[0], disc[1], lane, chosen);
  }
}

/* Of the cap of a sphere that is seen from a point, uniform by area: that with cosines of 1 - share to 1 about the way
 * to the point. It has the area 2 pi r^2 share, and the radiance is pi intensity / (pi r^2). From within the sphere
 * nothing is seen. */
ASC_VECTORISE static void choose_of_sphere(const light_source *restrict from, const pairs *restrict u,
                                           const vectors *restrict seen_from, chosen_points *restrict chosen) {
  const asc_light *given = &from->given;
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double numbers[2] = {u->row[0][lane], u->row[1][lane]};
    double axis[3], a[3], b[3], disc[2];
    for (int i = 0; i < 3; i++) axis[i] = seen_from->row[i][lane] - given->place[i];
    const double distance = sqrt(dot(axis, axis));
    const int outside = distance > given->radius;
    const double length = outside ? distance : 1.0, share = outside ? 1.0 - given->radius / length : 0.0;
    for (int i = 0; i < 3; i++) axis[i] /= length;
    (void)asc_to_disc(numbers, disc);
    across(axis, a, b);
    const double cosine = 1.0 - share * (disc[0] * disc[0] + disc[1] * disc[1]), sine = sqrt(share * (1.0 + cosine));
    for (int i = 0; i < 3; i++) {
      const double normal = cosine * axis[i] + sine * (disc[0] * a[i] + disc[1] * b[i]);
      chosen->normal.row[i][lane] = normal;
      chosen->place.row[i][lane] = given->place[i] + given->radius * normal;
    }
    chosen->seen[lane] = 2.0 * share;
  }
}

/* A surface through the light that is seen so flat that the way runs along it for longer than this may stand in its
 * way; below that the way ends before it. In what follows. */
#define FREE_END 8.0

/* How near to a light the tracer cannot tell what lies where: a few roundings of float, of the larger coordinates. */
ASC_INLINE double blur(const double chosen[3], const double point[3]) {
  double largest = 0.0;
  for (int i = 0; i < 3; i++) largest = larger(larger(fabs(point[i]), fabs(chosen[i])), largest);
  return 128.0 * FLT_EPSILON * largest;
}

ASC_VECTORISE static void turn_toward(chosen_points *restrict chosen, const vectors *restrict from,
                                      light_ways *restrict found) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double place[3] = {chosen->place.row[0][lane], chosen->place.row[1][lane], chosen->place.row[2][lane]};
    const double point[3] = {from->row[0][lane], from->row[1][lane], from->row[2][lane]};
    const double way[3] = {place[0] - point[0], place[1] - point[1], place[2] - point[2]};
    const double distance = sqrt(dot(way, way)), near = blur(place, point);
    const int apart = distance > near;
    const double away = apart ? distance : 1.0;
    for (int i = 0; i < 3; i++) found->toward.row[i][lane] = way[i] / away;
    found->arriving[lane] = apart && chosen->seen[lane] > 0.0 ? 1.0 : 0.0;
    found->distance[lane] = larger(distance - FREE_END * near, 0.0);
    chosen->away[lane] = away;
  }
}

/* The inverse square of the distance, with the cosine at a light that has an area. */
ASC_VECTORISE static void fall_off(const chosen_points *restrict chosen, int has_area, light_ways *restrict found) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    double leaving = 1.0;
    if (has_area) {
      const double normal[3] = {chosen->normal.row[0][lane], chosen->normal.row[1][lane], chosen->normal.row[2][lane]};
      const double toward[3] = {found->toward.row[0][lane], found->toward.row[1][lane], found->toward.row[2][lane]};
      leaving = larger(-dot(normal, toward), 0.0);
    }
    const double away = chosen->away[lane], squared = away * away;
    found->arriving[lane] *= chosen->seen[lane] * leaving / squared;
  }
}

static void along_direction(const light_source *from, light_ways *found) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    for (int i = 0; i < 3; i++) found->toward.row[i][lane] = from->given.place[i];
    found->arriving[lane] = 1.0;
    found->distance[lane] = INFINITY;
  }
}

void light_toward(const light_source *from, const pairs *u, const vectors *point, light_ways *found) {
  chosen_points chosen;
  switch (from->given.kind) {
  case ASC_LIGHT_DIRECTIONAL: along_direction(from, found); return;
  case ASC_LIGHT_POINT: choose_of_point(from, &chosen); break;
  case ASC_LIGHT_PARALLELOGRAM: choose_of_parallelogram(from, u, &chosen); break;
  case ASC_LIGHT_DISC: choose_of_disc(from, u, &chosen); break;
  case ASC_LIGHT_SPHERE: choose_of_sphere(from, u, point, &chosen); break;
  }
  turn_toward(&chosen, point, found);
  if (from->given.inverse_square) fall_off(&chosen, light_has_area(&from->given), found);
}

#include "split.h"

#include <stdlib.h>
#include <string.h>

/* An edge is cut that is so many times longer than it is far away: then corners are off by 17 2^-24 of the distance of
 * what they are corners of, at most, about what meeting_lift allows for. */
#define RATIO 16.0
/* Nearer than 2^-36 of the farthest corner all is as far. */
#define LEAST_SHARE 0x1p-36
/* Of one triangle; a bound for what cannot come to it. */
#define PIECES_MOST 65536

typedef struct triangle {
  double corner[3][3];
} triangle;

typedef struct stack {
  triangle *of;
  size_t count, room;
} stack;

/* What distances are: from the eye; of an orthographic view, whose rays start side by side, from its middle one, across
 * the view, and not below what is seen all at once. */
typedef struct nearness {
  int flat;
  double least; /* squared */
} nearness;

static int in_order(const double a[3], const double b[3]) {
  for (int i = 0; i < 3; i++)
    if (a[i] != b[i]) return a[i] < b[i];
  return 1;
}

/* How much longer than far an edge is, squared, over RATIO^2; the same to the bit from either end. */
static double excess(const nearness *by, const double first[3], const double second[3]) {
  const double *a = in_order(first, second) ? first : second, *b = a == first ? second : first;
  const int axes = by->flat ? 2 : 3;
  double squared = 0.0, toward = 0.0, distance = 0.0;
  for (int i = 0; i < axes; i++) {
    squared += (b[i] - a[i]) * (b[i] - a[i]);
    toward -= a[i] * (b[i] - a[i]);
  }
  const double share = squared > 0.0 ? fmin(fmax(toward / squared, 0.0), 1.0) : 0.0;
  for (int i = 0; i < axes; i++) {
    const double nearest = a[i] + share * (b[i] - a[i]);
    distance += nearest * nearest;
  }
  return squared / (RATIO * RATIO * fmax(distance, by->least));
}

/* Gives whether the triangle's nearest point lies within it, and too near. */
static int find_foot(const nearness *by, const triangle *of, double foot[3]) {
  const plane met = plane_of(of->corner);
  double longest = 0.0;
  if (by->flat || dot(met.normal, met.normal) == 0.0) return 0;
  for (int i = 0; i < 3; i++) foot[i] = met.normal[i] * met.offset;
  for (int k = 0; k < 3; k++) {
    const double *a = of->corner[k], *b = of->corner[(k + 1) % 3];
    double side[3], out[3], turned[3];
    for (int i = 0; i < 3; i++) {
      side[i] = b[i] - a[i];
      out[i] = foot[i] - a[i];
    }
    cross(side, out, turned);
    if (!(dot(turned, met.normal) > 0.0)) return 0;
    longest = fmax(longest, dot(side, side));
  }
  return longest > RATIO * RATIO * fmax(met.offset * met.offset, by->least);
}

static int push(stack *to, const double a[3], const double b[3], const double c[3]) {
  if (to->count == to->room) {
    const size_t room = 2 * to->room + 64;
    triangle *grown = realloc(to->of, room * sizeof *grown);
    if (!grown) return 0;
    to->of = grown;
    to->room = room;
  }
  triangle *fresh = &to->of[to->count++];
  memcpy(fresh->corner[0], a, sizeof fresh->corner[0]);
  memcpy(fresh->corner[1], b, sizeof fresh->corner[1]);
  memcpy(fresh->corner[2], c, sizeof fresh->corner[2]);
  return 1;
}

static int keep(pieces *to, const triangle *piece, uint32_t owner) {
  if (to->count == to->room) {
    const size_t room = 2 * to->room + 64;
    double *corners = realloc(to->corners, 9 * room * sizeof *corners);
    if (corners) to->corners = corners;
    uint32_t *owners = realloc(to->owner, room * sizeof *owners);
    if (owners) to->owner = owners;
    if (!corners || !owners) return 0;
    to->room = room;
  }
  memcpy(to->corners + 9 * to->count, piece->corner, sizeof piece->corner);
  to->owner[to->count++] = owner;
  return 1;
}

/* Pushes the parts of a triangle; gives 0 where it needs no cut, -1 without memory. */
static int cut_once(const nearness *by, const triangle *of, stack *left) {
  int worst = 0;
  double most = 0.0, middle[3];
  for (int k = 0; k < 3; k++) {
    const double here = excess(by, of->corner[k], of->corner[(k + 1) % 3]);
    if (here > most) {
      most = here;
      worst = k;
    }
  }
  const double *a = of->corner[worst], *b = of->corner[(worst + 1) % 3], *c = of->corner[(worst + 2) % 3];
  if (most > 1.0) {
    for (int i = 0; i < 3; i++) middle[i] = 0.5 * (a[i] + b[i]);
    return push(left, a, middle, c) && push(left, middle, b, c) ? 1 : -1;
  }
  if (!find_foot(by, of, middle)) return 0;
  return push(left, a, b, middle) && push(left, b, c, middle) && push(left, c, a, middle) ? 1 : -1;
}

static int cut_triangle(const nearness *by, const triangle *whole, uint32_t owner, stack *left, pieces *cut) {
  const size_t before = cut->count;
  if (!push(left, whole->corner[0], whole->corner[1], whole->corner[2])) return 0;
  while (left->count > 0) {
    const triangle next = left->of[--left->count];
    const int more = cut->count - before + left->count < PIECES_MOST ? cut_once(by, &next, left) : 0;
    if (more < 0 || (more == 0 && !keep(cut, &next, owner))) return 0;
  }
  return 1;
}

static triangle corners_of(const tracer *made, const asc_scene *scene, size_t number) {
  triangle of;
  for (size_t k = 0; k < 3; k++) tracer_to_camera(&made->view, scene->vertices + 9 * number + 3 * k, of.corner[k]);
  return of;
}

/* Most triangles are so far away that no part of them can be near. */
static int is_far(const nearness *by, const triangle *of) {
  double nearest = INFINITY, longest = 0.0;
  for (int k = 0; k < 3; k++) {
    const double *a = of->corner[k], *b = of->corner[(k + 1) % 3];
    double squared = 0.0, distance = 0.0;
    for (int i = 0; i < (by->flat ? 2 : 3); i++) {
      squared += (b[i] - a[i]) * (b[i] - a[i]);
      distance += a[i] * a[i];
    }
    longest = larger(longest, squared);
    nearest = nearest < distance ? nearest : distance;
  }
  return (RATIO + 2.0) * (RATIO + 2.0) * longest < nearest;
}

static int needs_cut(const nearness *by, const triangle *of) {
  double foot[3];
  if (is_far(by, of)) return 0;
  for (int k = 0; k < 3; k++)
    if (excess(by, of->corner[k], of->corner[(k + 1) % 3]) > 1.0) return 1;
  return find_foot(by, of, foot);
}

static nearness nearness_of(const tracer *made, const asc_scene *scene) {
  double largest = 0.0;
  for (size_t i = 0; i < scene->triangle_count; i++) {
    const triangle of = corners_of(made, scene, i);
    for (int k = 0; k < 9; k++) largest = larger(largest, fabs(of.corner[k / 3][k % 3]));
  }
  const int flat = made->view.projection == ASC_ORTHOGRAPHIC;
  const double least = fmax(LEAST_SHARE * largest, flat ? made->view.half_height : 0.0);
  return (nearness){flat, least * least};
}

asc_status split_triangles(const tracer *made, const asc_scene *scene, pieces *cut, asc_error *error) {
  *cut = (pieces){0};
  if (made->options.not_relative || made->ahead > 0.0) return ASC_OK; /* what is far ahead is smaller than far */
  const nearness by = nearness_of(made, scene);
  size_t needing = 0;
  for (size_t i = 0; i < scene->triangle_count; i++) {
    const triangle of = corners_of(made, scene, i);
    needing += (size_t)needs_cut(&by, &of);
  }
  if (needing == 0) return ASC_OK;
  stack left = {0};
  int there = 1;
  for (uint32_t i = 0; i < scene->triangle_count && there; i++) {
    const triangle of = corners_of(made, scene, i);
    there = cut_triangle(&by, &of, i, &left, cut);
  }
  free(left.of);
  if (there) return ASC_OK;
  split_free(cut);
  return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory for the pieces of %zu triangles", scene->triangle_count);
}

void split_free(pieces *cut) {
  free(cut->corners);
  free(cut->owner);
  *cut = (pieces){0};
}

#include "camera.h"

#include <math.h>

camera camera_create(const asc_view *view, const double lens[2]) {
  camera made = {.view = view, .perspective = view->projection == ASC_PERSPECTIVE};
  for (int i = 0; lens && view->lens_radius > 0.0 && i < 2; ++i) {
    made.lens[i] = lens[i];
    made.skew[i] = lens[i] / view->focus_distance;
  }
  made.skew[0] += 2.0 * view->half_width * view->shift[0] / view->width;
  made.skew[1] -= 2.0 * view->half_height * view->shift[1] / view->height;
  made.margin_x = 4.0 / view->width;
  made.margin_y = 4.0 / view->height;
  made.guard_x = 1.5 + 2.0 * made.margin_x;
  made.guard_y = 1.5 + 2.0 * made.margin_y;
  return made;
}

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void camera_direction(const camera *from, const double world[3], double local[3]) {
  double x = dot(world, from->view->right);
  double y = dot(world, from->view->up);
  local[2] = dot(world, from->view->forward);
  local[0] = x;
  local[1] = y;
}

void camera_point(const camera *from, const double world[3], double local[3]) {
  double offset[3] = {world[0] - from->view->eye[0], world[1] - from->view->eye[1], world[2] - from->view->eye[2]};
  camera_direction(from, offset, local);
  local[0] -= from->lens[0];
  local[1] -= from->lens[1];
}

void make_unit(double v[3]) {
  /* By the largest component first: the square of a very short one would be 0. */
  double largest = fmax(fabs(v[0]), fmax(fabs(v[1]), fabs(v[2])));
  for (int i = 0; i < 3; ++i) {
    v[i] /= largest;
  }
  double length = sqrt(dot(v, v));
  for (int i = 0; i < 3; ++i) {
    v[i] /= length;
  }
}

size_t camera_clip(const camera *by, const double (*corners)[3], size_t count, clip_vertex clipped[CLIP_CAPACITY]) {
  double largest = 0.0;
  for (size_t i = 0; i < count; ++i) {
    const double *p = corners[i];
    const double weight = by->perspective ? p[2] : 1.0;
    const double x = p[0] + by->skew[0] * weight;
    const double y = p[1] + by->skew[1] * weight;
    clip_vertex v = {x / by->view->half_width, y / by->view->half_height, weight, p[2]};
    clipped[i] = v;
    largest = fmax(largest, fmax(fabs(p[0]), fmax(fabs(p[1]), fabs(p[2]))));
  }
  /* In perspective not 0: a corner at the eye itself has no place in the picture. */
  clip_volume volume = {by->guard_x, by->guard_y, by->perspective ? ldexp(largest, -40) : 0.0};
  size_t left = clip_polygon(clipped, count, &volume);
  return left < 3 ? 0 : left;
}

void range_join(range *all, const range *one) {
  all->nearest = fmin(all->nearest, one->nearest);
  all->farthest = fmax(all->farthest, one->farthest);
}

/* Grown by the margin and cut to the guard. False where that leaves nothing. */
static bool fit(const camera *by, rectangle *box) {
  box->low_x = fmax(box->low_x - by->margin_x, -by->guard_x);
  box->low_y = fmax(box->low_y - by->margin_y, -by->guard_y);
  box->high_x = fmin(box->high_x + by->margin_x, by->guard_x);
  box->high_y = fmin(box->high_y + by->margin_y, by->guard_y);
  return box->low_x < box->high_x && box->low_y < box->high_y;
}

/* Two unit vectors that make a right angle with `normal` and each other. */
static void plane_axes(const double normal[3], double first[3], double second[3]) {
  /* The axis that the normal leans to least gives the best conditioned product. */
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    axis = fabs(normal[i]) < fabs(normal[axis]) ? i : axis;
  }
  double other[3] = {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0};
  double along = dot(other, normal);
  for (int i = 0; i < 3; ++i) {
    first[i] = other[i] - along * normal[i];
  }
  double length = sqrt(dot(first, first));
  for (int i = 0; i < 3; ++i) {
    first[i] /= length;
  }
  second[0] = normal[1] * first[2] - normal[2] * first[1];
  second[1] = normal[2] * first[0] - normal[0] * first[2];
  second[2] = normal[0] * first[1] - normal[1] * first[0];
}

bool camera_disc(const camera *by, const double centre[3], const double normal[3], double radius, rectangle *box,
                 range *depth) {
  double first[3];
  double second[3];
  plane_axes(normal, first, second);
  static const double signs[4][2] = {{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}};
  double square[4][3];
  for (int corner = 0; corner < 4; ++corner) {
    for (int i = 0; i < 3; ++i) {
      square[corner][i] = centre[i] + radius * (signs[corner][0] * first[i] + signs[corner][1] * second[i]);
    }
  }
  clip_vertex clipped[CLIP_CAPACITY];
  size_t count = camera_clip(by, (const double(*)[3])square, 4, clipped);
  if (count == 0) {
    return false;
  }
  rectangle found = {INFINITY, INFINITY, -INFINITY, -INFINITY};
  range seen = {INFINITY, 0.0};
  for (size_t i = 0; i < count; ++i) {
    double x = clipped[i].x / clipped[i].weight;
    double y = clipped[i].y / clipped[i].weight;
    found.low_x = fmin(found.low_x, x);
    found.low_y = fmin(found.low_y, y);
    found.high_x = fmax(found.high_x, x);
    found.high_y = fmax(found.high_y, y);
    range here = {clipped[i].depth, clipped[i].depth};
    range_join(&seen, &here);
  }
  *box = found;
  *depth = seen;
  return fit(by, box);
}

/* The slopes s = x / z of the two lines through the eye that touch the circle of this radius around (x, z):
 * (x - s z)^2 = radius^2 (1 + s^2). Where the circle reaches the eye's plane, everything. */
static void tangents(double x, double z, double radius, double *low, double *high) {
  if (z <= radius) {
    *low = -INFINITY;
    *high = INFINITY;
    return;
  }
  double square = (z - radius) * (z + radius);
  double root = radius * sqrt(x * x + square);
  *low = (x * z - root) / square;
  *high = (x * z + root) / square;
}

bool camera_sphere(const camera *by, const double centre[3], double radius, rectangle *box, range *depth) {
  double half_width = by->view->half_width;
  double half_height = by->view->half_height;
  if (centre[2] + radius <= 0.0) {
    return false;
  }
  if (!by->perspective) {
    const double x = centre[0] + by->skew[0];
    const double y = centre[1] + by->skew[1];
    rectangle found = {(x - radius) / half_width, (y - radius) / half_height, (x + radius) / half_width,
                       (y + radius) / half_height};
    *box = found;
    depth->nearest = fmax(centre[2] - radius, 0.0);
    depth->farthest = centre[2] + radius;
    return fit(by, box);
  }
  tangents(centre[0], centre[2], radius, &box->low_x, &box->high_x);
  tangents(centre[1], centre[2], radius, &box->low_y, &box->high_y);
  box->low_x = (box->low_x + by->skew[0]) / half_width;
  box->high_x = (box->high_x + by->skew[0]) / half_width;
  box->low_y = (box->low_y + by->skew[1]) / half_height;
  box->high_y = (box->high_y + by->skew[1]) / half_height;
  /* No point of the sphere is nearer to the eye than this, and within the picture z is at least this part of it. */
  const double gap = fabs(sqrt(dot(centre, centre)) - radius);
  const double steepest_x = by->guard_x * half_width + fabs(by->skew[0]);
  const double steepest_y = by->guard_y * half_height + fabs(by->skew[1]);
  depth->nearest = fmax(centre[2] - radius, gap / sqrt(1.0 + steepest_x * steepest_x + steepest_y * steepest_y));
  depth->farthest = centre[2] + radius;
  return fit(by, box);
}

bool camera_plane(const camera *by, const double normal[3], double offset, rectangle *box, range *depth) {
  if ((by->perspective ? offset : normal[2]) == 0.0) {
    return false;
  }
  const rectangle all = {-1.0 - by->margin_x, -1.0 - by->margin_y, 1.0 + by->margin_x, 1.0 + by->margin_y};
  /* Linear in the picture, so that the corners have the extremes: 1 / z in perspective, z in an orthographic view. */
  double low = INFINITY;
  double high = -INFINITY;
  for (int corner = 0; corner < 4; ++corner) {
    double u = by->view->half_width * (corner % 2 ? all.high_x : all.low_x) - by->skew[0];
    double v = by->view->half_height * (corner / 2 ? all.high_y : all.low_y) - by->skew[1];
    double across = normal[0] * u + normal[1] * v;
    double here = by->perspective ? (across + normal[2]) / offset : (offset - across) / normal[2];
    low = fmin(low, here);
    high = fmax(high, here);
  }
  if (!(high > 0.0)) {
    return false;
  }
  *box = all;
  depth->nearest = by->perspective ? 1.0 / high : fmax(low, 0.0);
  /* In perspective what lies at the horizon is infinitely far, and its reversed depth 0. */
  depth->farthest = !by->perspective ? high : low > 0.0 ? 1.0 / low : depth->nearest;
  return true;
}

#include "motion.h"

#include <math.h>

placing motion_at(const asc_motion *motion, double time) {
  placing at = {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}, {0.0}};
  if (motion->kind == ASC_MOTION_TRANSLATE) {
    for (int i = 0; i < 3; i++) at.offset[i] = time * motion->by[i];
    return at;
  }
  /* Rodrigues' formula, I + sin K + (1 - cos) K^2 with K^2 = a a^T - I; 1 - cos without its cancellation. */
  const double *a = motion->axis;
  const double cross[3][3] = {{0.0, -a[2], a[1]}, {a[2], 0.0, -a[0]}, {-a[1], a[0], 0.0}};
  const double angle = motion->angle * time, half = sin(0.5 * angle), versine = 2.0 * half * half;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      at.matrix[i][j] += sin(angle) * cross[i][j] + versine * (a[i] * a[j] - (i == j ? 1.0 : 0.0));
  double turned[3];
  motion_turn(&at, motion->centre, turned);
  for (int i = 0; i < 3; i++) at.offset[i] = motion->centre[i] - turned[i];
  return at;
}

void motion_turn(const placing *at, const double rest[3], double moved[3]) {
  for (int i = 0; i < 3; i++)
    moved[i] = at->matrix[i][0] * rest[0] + at->matrix[i][1] * rest[1] + at->matrix[i][2] * rest[2];
}

void motion_place(const placing *at, const double rest[3], double moved[3]) {
  motion_turn(at, rest, moved);
  for (int i = 0; i < 3; i++) moved[i] += at->offset[i];
}

void motion_ray_to_rest(const placing *at, const double origin[3], const double direction[3], double rest_origin[3],
                        double rest_direction[3]) {
  for (int i = 0; i < 3; i++) { /* the inverse of a rotation is its transpose */
    rest_origin[i] = rest_direction[i] = 0.0;
    for (int j = 0; j < 3; j++) {
      rest_origin[i] += at->matrix[j][i] * (origin[j] - at->offset[j]);
      rest_direction[i] += at->matrix[j][i] * direction[j];
    }
  }
}

size_t motion_segments(const asc_motion *motion, double duration) {
  if (motion->kind == ASC_MOTION_TRANSLATE) return 1;
  /* A chord of angle b is off its circle by 1 - cos(b/2) of the radius. */
  const double needed = ceil(fabs(motion->angle) * duration / (2.0 * acos(1.0 - 1e-5)));
  return needed < 1.0 ? 1 : needed < MOTION_SEGMENTS_MOST ? (size_t)needed : MOTION_SEGMENTS_MOST;
}

double motion_sagitta(const asc_motion *motion, double duration) {
  if (motion->kind == ASC_MOTION_TRANSLATE) return 0.0;
  const double half = sin(0.25 * motion->angle * duration / (double)motion_segments(motion, duration));
  return 2.0 * half * half;
}

double shutter_moment(asc_response response, double u) {
  if (response == ASC_RESPONSE_BOX) return u;
  return u < 0.5 ? sqrt(0.5 * u) : 1.0 - sqrt(0.5 * (1.0 - u));
}

/* The shutter, and where what moves is at a time. */
#ifndef TRACER_MOTION_H
#define TRACER_MOTION_H

#include <stddef.h>

#include "aliascope/scene.h"

/* From the place at time 0 to that at another: p to matrix p + offset. */
typedef struct placing {
  double matrix[3][3], offset[3];
} placing;

placing motion_at(const asc_motion *motion, double time);
void motion_place(const placing *at, const double rest[3], double moved[3]);
void motion_turn(const placing *at, const double rest[3], double moved[3]);

/* The ray that meets a surface at rest where this one meets it moved, at the same distance. */
void motion_ray_to_rest(const placing *at, const double origin[3], const double direction[3], double rest_origin[3],
                        double rest_direction[3]);

/* How many straight lines a motion is cut into for Embree, which holds MOTION_SEGMENTS_MOST + 1 places: 1 for a
 * translation; for a rotation as many as keep every point within 1e-5 of the radius of its circle, up to the most that
 * there can be. */
#define MOTION_SEGMENTS_MOST 128
size_t motion_segments(const asc_motion *motion, double duration);

/* How far those lines leave the circle, as a share of the radius: up to 1e-5 to a turn of 65 degrees, then growing with
 * its square to 3.1e-4 for a whole one. */
double motion_sagitta(const asc_motion *motion, double duration);

/* Where in the open shutter, from 0 to 1, a share u of its response is over. */
double shutter_moment(asc_response response, double u);

#endif

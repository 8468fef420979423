/* Meshes of frames: triangles whose corners go along straight lines from one frame to the next. */
#ifndef TRACER_FRAMES_H
#define TRACER_FRAMES_H

#include "scene.h"

/* Embree has 129 places of a geometry at most, so 128 frames after the first. */
#define FRAMES_MOST 128

/* The corners of the triangles of one motion, in the camera's frame: [count][triangles][3][3], at times from `begin`
 * to `end`, evenly far apart. These are the frames round the open shutter; or, where all of it lies between two frames,
 * the two places at its opening and closing, so that the shortest shutter has all digits. */
struct mesh_frames {
  double *corners;
  double *rest; /* [triangles][3][3]: at time 0 */
  size_t triangles, count;
  double begin, end;
};

/* Takes the frames of all motions that have some; the motions are in the tracer already, and which triangle has which.
 */
asc_status frames_take(tracer *made, const asc_scene *scene, asc_error *error);
void frames_free(tracer *made);

/* Of a motion, or of none; NULL where it has no frames. */
static inline const mesh_frames *frames_of(const tracer *made, const asc_motion *motion) {
  return motion && motion->kind == ASC_MOTION_FRAMES ? &made->frames[motion - made->motions] : NULL;
}

/* Embree's time range for them: 0 is the shutter's opening, 1 its closing. */
void frames_time_range(const tracer *made, const mesh_frames *of, float *begin, float *end);

/* Where a ray meets the plane of a triangle as it is at a time: its distance; the normal, of length 1; where that point
 * of the triangle was at time 0; and how far Embree's triangle, in float, may be off beyond what its place at that time
 * tells. */
double frames_meet(const tracer *made, uint32_t triangle, double time, const double origin[3],
                   const double direction[3], double normal[3], double rest[3], double *slack);

#endif

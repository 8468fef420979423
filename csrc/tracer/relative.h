/* A scene as its camera sees it: moved, in double, so that the eye, or where its rays begin, is the origin, and in
 * lengths that float holds.
 *
 * A tracer whose vertices are floats of the world loses a scene that stands far from the world's origin: of a
 * coordinate of 10^9 float keeps no less than 64. Here the eye is subtracted first, of doubles, so that float rounds
 * what is left. */
#ifndef TRACER_RELATIVE_H
#define TRACER_RELATIVE_H

#include "tracer.h"

typedef struct relative_scene {
  asc_scene scene; /* the eye at 0; of the axes of the world */
  /* How far before the eye, along `forward`, the origin lies: 0 but for what is seen from so far away that float would
   * not part its depths. Nothing is between. */
  double ahead;
  double *vertices;
  double *frames; /* of all motions, one after the other */
  asc_disc *discs;
  asc_sphere *spheres;
  /* [sphere_count]: how much the square of each ball's centre's distance from the origin is more than that of its
   * radius, of the scene's own doubles, exact to the last bits; infinite where nothing asks for it. */
  double *powers;
  asc_plane *planes;
  asc_light *lights;
  asc_material *materials;
  asc_motion *motions;
} relative_scene;

/* Copies a scene, which may hold what is not finite, and keeps pointers into it to what has no place. */
asc_status relative_take(const asc_scene *world, const tracer_options *options, relative_scene *made, asc_error *error);
void relative_free(relative_scene *made);

#endif

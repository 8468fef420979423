/* A scene whose passes see it through different points of a lens, or at different times: kept, and still at one time
 * after another.
 *
 * Patterns ride on their surfaces: what moves and has a pattern gets a material of its own for each of its motions,
 * whose pattern is moved with it.
 */
#ifndef RASTER_MOMENT_H
#define RASTER_MOMENT_H

#include "aliascope/base.h"
#include "aliascope/scene.h"

/* How a surface has turned since time 0. */
typedef struct turn {
  double matrix[3][3];
} turn;

typedef struct moment moment;

/* Copies the scene, which must have passed raster_validate, as it is at time 0. */
asc_status moment_create(const asc_scene *scene, moment **made, asc_error *error);
void moment_destroy(moment *made);

/* Moves what moves to where it is at a time. */
void moment_set(moment *to, double time);

/* The scene as it was last set; nothing in it moves. Good until the moment is set again. */
const asc_scene *moment_scene(const moment *of);

/* By material of that scene; NULL where no checker turns. */
const turn *moment_turns(const moment *of);

#endif

/* Triangles much larger than they are far away, cut into pieces that are not.
 *
 * Float rounds a corner to 2^-24 of its own distance, and with it the triangle's whole plane and edges: those of a
 * floor from under the eye to the horizon would be off, under the eye, by what is nothing at the horizon. */
#ifndef TRACER_SPLIT_H
#define TRACER_SPLIT_H

#include "scene.h"

typedef struct pieces {
  size_t count;
  double *corners; /* [count][3][3], in the camera's frame */
  uint32_t *owner; /* [count], the triangle */
  size_t room;
} pieces;

/* The triangles of a scene in which nothing moves, those that need it in pieces; count 0 where none does. Pieces meet
 * edge to edge, those of triangles too that share two corners: where an edge is cut follows from its ends alone. */
asc_status split_triangles(const tracer *made, const asc_scene *scene, pieces *cut, asc_error *error);
void split_free(pieces *cut);

#endif

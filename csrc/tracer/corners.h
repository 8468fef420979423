/* Corners of meshes with triangles all round them. */
#ifndef TRACER_CORNERS_H
#define TRACER_CORNERS_H

#include "aliascope/scene.h"

/* Whether there is a corner each of whose edges two triangles or more share: there alone rays pass between triangles of
 * which none is missing. Of many triangles, or without memory, it is taken to be so. */
int corners_any_surrounded(const asc_scene *scene);

#endif

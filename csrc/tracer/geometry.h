/* What Embree holds of the surfaces, in float. */
#ifndef TRACER_GEOMETRY_H
#define TRACER_GEOMETRY_H

#include "scene.h"

/* Attaches the surfaces of a kind, whose places in double are there already: as one geometry where nothing in the scene
 * moves, else as parts, whose surfaces share a motion. */
asc_status geometry_take(tracer *made, const asc_scene *scene, uint32_t kind, size_t count, asc_error *error);

#endif

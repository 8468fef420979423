/* How far light is followed. */
#ifndef TRACER_TRANSPORT_H
#define TRACER_TRANSPORT_H

#include "scene.h"

/* After the materials. */
asc_status transport_take(tracer *made, const asc_scene *scene, asc_error *error);

#endif

/* The scene inside the tracer: in the camera's frame, as Embree holds it and, in double, as shading needs it.
 *
 * Camera frame: x right, y up, z forward, the eye at 0. Coordinates are moved and turned in double before they become
 * float, so that a scene far from the origin keeps its digits. */
#ifndef TRACER_SCENE_H
#define TRACER_SCENE_H

#include <embree3/rtcore.h>

#include "tracer.h"

enum { TRIANGLES = 0, DISCS = 1, SPHERES = 2, GEOMETRY_KINDS = 3 };

typedef struct plane {
  double normal[3], offset; /* normal . p = offset; the normal of any length */
} plane;

typedef struct ball {
  double centre[3], radius;
} ball;

struct tracer {
  RTCDevice device;
  RTCScene scene;
  asc_view view;
  asc_material *materials; /* pattern origins in the camera frame */
  size_t material_count;
  uint32_t *material_of[GEOMETRY_KINDS]; /* by primitive */
  plane *triangle_planes;                /* only where a material has a pattern, else NULL */
  plane *disc_planes;
  ball *balls;
  int patterned; /* some material has a pattern */
  double build_cpu_seconds;
};

/* Copies and checks what is not geometry: view, materials. */
asc_status tracer_take_materials(tracer *made, const asc_scene *scene, asc_error *error);

/* Makes the geometries in the camera frame and builds the acceleration structure. */
asc_status tracer_take_geometry(tracer *made, const asc_scene *scene, asc_error *error);

/* Where the ray from `origin` along `direction` meets a primitive, in double; the primitive was hit, by Embree. */
void tracer_hit_point(const tracer *made, uint32_t geometry, uint32_t primitive, const double origin[3],
                      const double direction[3], double point[3]);

static inline double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

double tracer_thread_cpu_seconds(void);

#endif

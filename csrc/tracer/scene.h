/* The scene inside the tracer: in the camera's frame, as Embree holds it and, in double, as shading needs it.
 *
 * Camera frame: x right, y up, z forward, the eye at (0, 0, -ahead). Coordinates are moved (relative.h) and turned in
 * double before they become float, so that a scene far from the origin keeps its digits. */
#ifndef TRACER_SCENE_H
#define TRACER_SCENE_H

#include <embree3/rtcore.h>

#include "lens.h"
#include "light.h"
#include "motion.h"
#include "relative.h"
#include "tracer.h"
#include "vector.h"

/* The first three are Embree's geometries; planes have no bounds, so they are met here, in double. */
enum { TRIANGLES = 0, DISCS = 1, SPHERES = 2, PLANES = 3, GEOMETRY_KINDS = 4 };

typedef struct plane {
  double normal[3], offset; /* normal . p = offset; the normal of length 1 */
} plane;

typedef struct ball {
  double centre[3], radius;
  double power; /* of the frame's origin: |centre|^2 - radius^2, exact to double's last bits; unset of discs */
  int large;    /* large.h */
} ball;

/* Where a sample has its numbers for each of what it chooses, from the third of them on; tracer.h has their order. */
typedef struct layout {
  uint32_t time;
  uint32_t lens;
  uint32_t emitter;
  uint32_t bounces; /* of the first; `bounce` numbers each */
  uint32_t bounce;
  uint32_t count;
  uint32_t *groups; /* how many numbers belong together, the first two included */
  size_t group_count;
} layout;

/* What one of Embree's geometries holds, where some move, or are held in pieces: surfaces of one kind and motion. */
typedef struct part {
  uint32_t kind;
  uint32_t *members; /* by primitive, the surface's number among those of its kind; NULL: its own */
} part;

/* Surfaces that are met in double, for Embree's functions: large.h. */
typedef struct large_surfaces {
  const struct tracer *made;
  uint32_t id; /* of their part */
} large_surfaces;

/* What finds the light of surfaces that shine: rays sent to them and rays that come upon them, each weighted by its
 * density (the balance heuristic of Veach and Guibas 1995), or, for tests, one of the two alone. */
typedef enum emission_from { FROM_BOTH = 0, FROM_EMITTERS = 1, FROM_RAYS = 2 } emission_from;

/* How far light is followed. */
typedef struct transport {
  uint32_t bounces; /* the most of one path; 0 where no surface sends it on */
  uint32_t mirror_bounces;
  uint32_t diffuse_bounces;
  int spreads;          /* gloss or diffuse bounces: directions are chosen */
  int samples_emitters; /* and there is a surface that shines, other than planes and meshes of frames */
  emission_from emission_from;
  uint32_t roulette_from; /* the bounce from which on a path may end by chance */
} transport;

typedef struct mesh_frames mesh_frames;

struct tracer {
  tracer_options options; /* each as it is, the defaults too */
  RTCDevice device;
  RTCScene scene;
  asc_view view; /* with the eye at 0, in the tracer's own lengths: relative.h */
  double ahead;  /* how far before the eye the camera's frame has its origin, along z */
  lens lens;
  layout further;
  transport transport;
  asc_material *materials; /* pattern origins relative to the frame's: of rings in the camera's frame, of checks
                              along the world's axes, as their cells are */
  size_t material_count;
  int has_patterns;
  light_source *lights;
  size_t light_count;
  uint32_t *material_of[GEOMETRY_KINDS]; /* by primitive */
  plane *triangle_planes;                /* only where shading needs the point that is hit, else NULL */
  plane *disc_planes;
  double *least_lift[GEOMETRY_KINDS]; /* by disc and ball, which are held whole: meeting.h; NULL of others */
  ball *balls;
  ball *disc_balls; /* about the discs */
  large_surfaces large[GEOMETRY_KINDS];
  plane *planes;
  size_t plane_count;
  asc_motion *motions; /* in the camera frame, axes of length 1 */
  size_t motion_count;
  const asc_motion **motion_of[GEOMETRY_KINDS]; /* by surface, NULL where it stands still; NULL: all do */
  mesh_frames *frames;                          /* by motion, empty but for those of frames; NULL: there are none */
  uint32_t *frame_member;                       /* by triangle, where frames.h has it among those of its motion */
  part *parts; /* by Embree's geometry; NULL where it is the kind, with all its surfaces */
  size_t part_count;
  struct emitter *emitters;
  size_t emitter_count;
  uint32_t
      *emitter_of[GEOMETRY_KINDS]; /* by surface, 0 where it does not shine, else one more than its index; or NULL */
  int shines_alone;                /* no light, bounce or motion: what is seen is what surfaces shine by themselves */
  int plain;                       /* no pattern, light, plane or bounce: what Embree finds is all that shading needs */
  int looks_again;                 /* a corner has triangles all round it, between which rays may pass */
  double build_cpu_seconds;
};

/* Copies and checks what is not geometry: view, materials, lights. */
asc_status tracer_take_appearance(tracer *made, const asc_scene *scene, asc_error *error);

/* Makes the geometries in the camera frame and builds the acceleration structure. */
asc_status tracer_take_geometry(tracer *made, const relative_scene *local, asc_error *error);

/* The plane through a triangle's corners; without area its normal is 0. */
plane plane_of(const double corner[3][3]);

/* Copies the motions into the camera frame, and which surface has which. */
asc_status tracer_take_motions(tracer *made, const asc_scene *scene, asc_error *error);

/* The surface that Embree met. */
typedef struct surface {
  uint32_t kind, number;
} surface;

static inline surface tracer_surface(const tracer *made, uint32_t geometry, uint32_t primitive) {
  if (!made->parts) return (surface){geometry, primitive};
  const part *of = &made->parts[geometry];
  return (surface){of->kind, of->members ? of->members[primitive] : primitive};
}

/* How a surface moves; NULL where it stands still. */
static inline const asc_motion *tracer_motion(const tracer *made, surface of) {
  return made->motion_of[of.kind] ? made->motion_of[of.kind][of.number] : NULL;
}

/* Turns a point or a direction of the world into the camera's frame. */
void tracer_to_camera(const asc_view *view, const double world[3], double camera[3]);
void tracer_to_camera_direction(const asc_view *view, const double world[3], double camera[3]);

double tracer_thread_cpu_seconds(void);

#endif

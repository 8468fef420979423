/* The scene as the two renderers written in C take it: plain arrays in world coordinates, in double.
 *
 * World: right-handed, y up. Pictures: row 0 on top, pixel (x, y) covers [x, x+1) x [y, y+1), so the picture position
 * (px, py) lies at (2 px / width - 1) half_width along `right` and (1 - 2 py / height) half_height along `up`; a
 * view with a shift sees there what it would have seen at (px, py) less the shift.
 * Shading: pattern(p) (emission + albedo sum over lights of intensity max(0, n . l) visibility), pattern(p) being 1
 * where a material has none, n the geometric normal turned toward the viewer: light from the other side gives 0. To it
 * come reflection (what is seen along the mirrored ray, or in its lobe) and, with diffuse bounces, pattern(p) albedo /
 * pi (the integral over the hemisphere of the radiance of other surfaces and the background, times the cosine).
 * `lights` are seen in neither; a surface with an emission is. A renderer refuses what it can't draw; nothing is
 * dropped here.
 */
#ifndef ASC_SCENE_H
#define ASC_SCENE_H

#include <stddef.h>
#include <stdint.h>

typedef enum asc_projection { ASC_ORTHOGRAPHIC = 0, ASC_PERSPECTIVE = 1 } asc_projection;

/* How open the shutter is from its opening to its closing: even, or a tent whose peak is in the middle. */
typedef enum asc_response { ASC_RESPONSE_BOX = 0, ASC_RESPONSE_TRIANGLE = 1 } asc_response;

/* right, up, forward: orthonormal. Perspective: half_width and half_height are tangents of half the angles of view.
 * Orthographic: half the picture's width and height in world units; rays start in the plane through `eye`. */
typedef struct asc_view {
  asc_projection projection;
  uint32_t width, height; /* pixels */
  double eye[3], right[3], up[3], forward[3];
  double half_width, half_height;
  /* Pixels to the right and down by which all that is seen is moved on the film: pixel (x, y) covers [x - shift[0], x +
   * 1 - shift[0]) of the unmoved picture, and so for y. A move of the film alone: the eye and what is in focus stay. */
  double shift[2];
  double background[3]; /* linear RGB */
  /* A thin lens in the plane through `eye`, whose points are sharp at the depth focus_distance along `forward`: from
   * the lens point (x, y) along right and up the ray goes along forward + (u - x / focus_distance) right + (v - y /
   * focus_distance) up, where the eye's goes along forward + u right + v up. The mean is over the lens, by area. */
  double lens_radius;    /* 0: none; else perspective only */
  double focus_distance; /* positive where there is a lens */
  uint32_t blades;       /* 0: round; 3 to 64: a regular polygon inscribed in the circle, one corner upward */
  double shutter_open, shutter_close; /* times; the mean is over them, weighted by the response. Equal where none is */
  asc_response response;
} asc_view;

typedef enum asc_pattern_kind {
  ASC_PATTERN_NONE = 0,
  /* colour = low + (high - low) (1 + cos(scale |p - origin|^2)) / 2, p the point on the surface */
  ASC_PATTERN_ZONE_PLATE = 1,
  /* colour = low where the sum over the axes of floor(scale (p - origin)) is even, else high */
  ASC_PATTERN_CHECKER = 2
} asc_pattern_kind;

typedef struct asc_pattern {
  asc_pattern_kind kind;
  double scale;
  double origin[3];
  double low[3], high[3]; /* linear RGB */
} asc_pattern;

typedef enum asc_lobe_kind {
  ASC_LOBE_MIRROR = 0, /* all goes along the mirrored ray */
  /* (exponent + 1) / (2 pi) cos^exponent of the angle to the mirrored ray, in a steradian; what of it lies below the
   * surface is lost */
  ASC_LOBE_PHONG = 1,
  /* Microfacets without a Fresnel term: D(h) G(v, l) / (4 n . v), D of GGX (Walter et al. 2007, eq. 33) with alpha =
   * roughness, G Smith's for heights that are correlated, 1 / (1 + Lambda(v) + Lambda(l)) (Heitz 2014, eqs. 72, 99) */
  ASC_LOBE_GGX = 2
} asc_lobe_kind;

/* How the light that a surface reflects is spread: what of the radiance from a direction is sent to the viewer, in a
 * steradian, the cosine included. No lobe sends more than what arrives. */
typedef struct asc_lobe {
  asc_lobe_kind kind;
  double exponent;  /* 1 to 1e6 */
  double roughness; /* 1e-3 to 1 */
} asc_lobe;

typedef struct asc_material {
  double emission[3]; /* linear RGB */
  asc_pattern pattern;
  double albedo[3];     /* linear RGB */
  double reflection[3]; /* linear RGB, the share of light that is mirrored; with albedo times pattern at most 1 */
  asc_lobe gloss;       /* of the reflection */
} asc_material;

/* Each surface names its material by index. All surfaces are seen from both sides. */
typedef struct asc_disc {
  double centre[3], normal[3]; /* normal of any length but 0 */
  double radius;
  uint32_t material;
} asc_disc;

typedef struct asc_sphere {
  double centre[3];
  double radius;
  uint32_t material;
} asc_sphere;

/* An endless plane. */
typedef struct asc_plane {
  double point[3], normal[3]; /* normal of any length but 0 */
  uint32_t material;
} asc_plane;

typedef enum asc_motion_kind {
  ASC_MOTION_TRANSLATE = 0, /* by time * by */
  ASC_MOTION_ROTATE = 1,    /* right-handed about the axis through the centre, by time * angle */
  /* Of triangles alone, whose corners go along straight lines from `vertices` at time 0 through frames, 1 / frame_count
   * apart in time. The shutter is open within [0, 1]. A pattern rides by the barycentric coordinates of its point. */
  ASC_MOTION_FRAMES = 2
} asc_motion_kind;

/* Takes a surface from its place at time 0, which is the one that its numbers state, to that at another. Patterns ride
 * on the surface: they are those of the point where it was at time 0. */
typedef struct asc_motion {
  asc_motion_kind kind;
  double by[3];
  double axis[3], centre[3]; /* axis of any length but 0 */
  double angle;              /* radians in a unit of time; the tracer draws at most 2 pi in the open shutter */
  const double *frames;      /* [frame_count][frame_triangles][3][3]: the triangles that name this motion, in order */
  size_t frame_count;        /* the tracer draws at most 128 */
  size_t frame_triangles;
} asc_motion;

typedef enum asc_light_kind {
  ASC_LIGHT_POINT = 0,         /* `place` is its position */
  ASC_LIGHT_DIRECTIONAL = 1,   /* `place` is the direction in which the light travels, of any length but 0 */
  ASC_LIGHT_PARALLELOGRAM = 2, /* `place` is a corner, from which `edges` go */
  ASC_LIGHT_DISC = 3,          /* `place` is its centre, `edges` are two radii at a right angle, of one length */
  ASC_LIGHT_SPHERE = 4         /* `place` is its centre */
} asc_light_kind;

/* Lights with an area are not seen themselves. They add pattern(p) albedo intensity times the mean of max(0, n . l)
 * visibility over their area, both sides alike; of a sphere, over the part of it that is seen from p. With
 * inverse_square they are Lambert emitters of radiance pi intensity / area, and add pattern(p) albedo / pi times the
 * irradiance: times max(0, cosine at the light) / distance^2 in the mean. A parallelogram and a disc then shine to the
 * side of edges[0] x edges[1] alone; the area of a sphere is its cross-section's, pi radius^2, so that one wholly above
 * the horizon lights as a point light of its intensity at its centre. From within, a sphere gives no light. */
typedef struct asc_light {
  asc_light_kind kind;
  double place[3];
  double intensity[3];     /* linear RGB */
  uint32_t inverse_square; /* 1: the intensity is divided by the squared distance */
  double edges[2][3];
  double radius; /* of a sphere */
} asc_light;

/* How far light is followed. */
typedef struct asc_transport {
  uint32_t mirror_bounces;  /* up to 64 reflections of a path; past them there is no light. 0: mirrors are black */
  uint32_t diffuse_bounces; /* up to 64 times that a path is scattered by an albedo; 0: none lights another */
} asc_transport;

typedef struct asc_scene {
  size_t struct_size;
  asc_view view;
  const asc_material *materials;
  size_t material_count;
  const double *vertices;            /* [triangle_count][3][3] */
  const uint32_t *triangle_material; /* [triangle_count] */
  size_t triangle_count;
  const asc_disc *discs;
  size_t disc_count;
  const asc_sphere *spheres;
  size_t sphere_count;
  const asc_plane *planes;
  size_t plane_count;
  const asc_light *lights;
  size_t light_count;
  const asc_motion *motions; /* none unless the shutter is open for a while */
  size_t motion_count;
  /* For each surface of a kind: 0 where it stands still, else one more than the index of its motion. NULL: all do. */
  const uint32_t *triangle_motion, *disc_motion, *sphere_motion, *plane_motion;
  asc_transport transport;
} asc_scene;

#endif

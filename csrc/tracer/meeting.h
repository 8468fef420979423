/* Where rays end, in double: Embree says which surface a ray meets, shading needs the point itself. */
#ifndef TRACER_MEETING_H
#define TRACER_MEETING_H

#include <float.h>

#include "packet.h"

typedef struct meeting {
  const asc_material *material; /* NULL: nowhere */
  surface of;
  double point[3];
  double normal[3]; /* of length 1, toward where the ray came from */
  double lifted[3]; /* the point moved along the normal by more than float can have moved the surface */
  double distance;  /* in lengths of the ray's direction */
  double colour[3]; /* of the pattern */
} meeting;

/* Those of a packet's lanes. Where there is none the material is NULL, the normal and the albedo are 0, the colour is
 * white, the emission the background's, and the rest any numbers. */
typedef struct meetings {
  vectors point, normal, lifted, colour;
  vectors albedo, emission, reflection; /* of the materials; unset where nothing asks for it */
  vectors to_eye;                       /* where the ray came from, of length 1; set where a lane's surface reflects */
  alignas(64) double distance[PACKET];
  const asc_material *material[PACKET];
  surface of[PACKET];
} meetings;

/* The nearest of what Embree met and of the planes, along the rays of the lanes that have one. Gives whether there is
 * any. */
int meeting_find(const tracer *made, const packet *rays, meetings *met);

meeting meeting_of(const meetings *met, uint32_t lane);

/* Which of `lanes`, bits, not none, have the material of the first of them. */
static inline uint32_t meeting_alike(const asc_material *const material[PACKET], uint32_t lanes) {
  const asc_material *first = material[__builtin_ctz(lanes)];
  uint32_t alike = 0;
  for (uint32_t i = 0; i < PACKET; i++)
    if ((lanes >> i) & 1 && material[i] == first) alike |= UINT32_C(1) << i;
  return alike;
}

/* The colours of the patterns of `lanes`, bits, whose materials have one, where their surfaces had points at time 0. */
void meeting_colours(const tracer *made, const asc_material *const material[PACKET], uint32_t lanes,
                     const vectors *rest, vectors *colour);

/* How far Embree's surface may be off, for its motion in straight lines, round a point that it had at time 0. */
double meeting_slack(const tracer *made, const asc_motion *motion, const double rest[3]);

/* How far a point of a surface is to be lifted; `slack` as above. Vertices and origin are rounded to 2^-24 of their
 * largest coordinate, and a triangle's plane by a few times that; and Embree's motion is off. */
static inline double meeting_lift(const double point[3], double slack) {
  double largest = 0.0;
  for (int i = 0; i < 3; i++) largest = larger(largest, fabs(point[i]));
  return 16.0 * FLT_EPSILON * largest + 2.0 * slack;
}

/* What of the size of a surface that is held whole, near which a point may lie much nearer to the origin than the rest
 * of it: Embree has it to some roundings of its largest coordinate. */
static inline double meeting_least_lift(const double centre[3], double radius) {
  double largest = 0.0;
  for (int i = 0; i < 3; i++) largest = larger(largest, fabs(centre[i]));
  return 8.0 * FLT_EPSILON * (largest + radius);
}

static inline double meeting_least_lift_of(const tracer *made, surface of) {
  return made->least_lift[of.kind] ? made->least_lift[of.kind][of.number] : 0.0;
}

/* Whether an endless plane lies on the way. */
int meeting_planes_block(const tracer *made, double time, const double origin[3], const double toward[3],
                         double distance);

#endif

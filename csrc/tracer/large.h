/* Balls and discs that are much larger than they are far from the eye.
 *
 * Embree holds a ball, or the triangle about a disc, whole and in float, and so knows its surface to 2^-24 of its size:
 * of a ball of radius 10^8 that is 6, whatever the eye's height over it. These here Embree only finds, by boxes that
 * are wider than they are; whether and where a ray meets them is worked out in double. */
#ifndef TRACER_LARGE_H
#define TRACER_LARGE_H

#include "scene.h"

/* Says of each surface of a kind whether it is one of these; motions, views and the surfaces are in the tracer already.
 * What moves is one if it is one at any of some times. Gives how many there are. */
size_t large_mark(tracer *made, uint32_t kind, size_t count);

static inline int large_is(const tracer *made, surface of) {
  return (of.kind == SPHERES && made->balls[of.number].large) ||
         (of.kind == DISCS && made->disc_balls[of.number].large);
}

/* Attaches those of a part, which has members. */
void large_attach(tracer *made, uint32_t id, size_t count);

/* How far along a ray it enters and leaves a ball that is marked, in order; without a cancellation that is more than
 * that of their difference. Where it passes by, 0, and the distance at which it is nearest to the centre, twice. */
int large_roots(const ball *of, const double origin[3], const double direction[3], double roots[2]);

#endif

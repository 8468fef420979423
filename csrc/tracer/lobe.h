/* How a reflection spreads, and light that a matt surface scatters: densities over the solid angle, and directions that
 * follow them. All directions have length 1 and go out from the surface. */
#ifndef TRACER_LOBE_H
#define TRACER_LOBE_H

#include "aliascope/scene.h"
#include "vector.h"

typedef struct lobe_at {
  double value;   /* the share of the radiance from there that is reflected, in a steradian: with the cosine */
  double density; /* of lobe_sample, in a steradian */
} lobe_at;

/* Of a lobe, not of a perfect mirror. 0 below the surface. */
lobe_at lobe_towards(const asc_lobe *lobe, const double normal[3], const double to_eye[3], const double way[3]);

/* A direction that u chooses, of a perfect mirror too, and its value over its density: 0 below the surface. */
double lobe_sample(const asc_lobe *lobe, const double normal[3], const double to_eye[3], const double u[2],
                   double way[3]);

/* The lanes' directions of the hemisphere that u chooses, with the density cosine / pi. */
void lobe_cosine(const vectors *normal, const pairs *u, vectors *way);

#endif

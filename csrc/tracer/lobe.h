/* How a reflection spreads, and light that a matt surface scatters: densities over the solid angle, and directions that
 * follow them. All directions have length 1 and go out from the surface. */
#ifndef TRACER_LOBE_H
#define TRACER_LOBE_H

#include "aliascope/scene.h"
#include "vector.h"

/* Those of lanes. */
typedef struct lobe_at {
  scalars value;   /* the share of the radiance from there that is reflected, in a steradian: with the cosine */
  scalars density; /* of lobe_sample, in a steradian */
} lobe_at;

/* Towards the lanes' directions, of a lobe, not of a perfect mirror. 0 below the surface. */
void lobe_towards(const asc_lobe *lobe, const vectors *normal, const vectors *to_eye, const vectors *toward,
                  lobe_at *found);

typedef struct lobe_ways {
  vectors way;
  scalars share; /* its value over its density: 0 below the surface */
  scalars density;
} lobe_ways;

/* The lanes' directions that u chooses. */
void lobe_sample(const asc_lobe *lobe, const vectors *normal, const vectors *to_eye, const pairs *u, lobe_ways *ways);

/* The lanes' directions of the hemisphere that u chooses, with the density cosine / pi. */
void lobe_cosine(const vectors *normal, const pairs *u, vectors *way);

#endif

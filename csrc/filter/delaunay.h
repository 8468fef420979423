/* The Delaunay triangulation of different places in the plane. */
#ifndef ASC_DELAUNAY_H
#define ASC_DELAUNAY_H

#include <stddef.h>

#include "aliascope/base.h"
#include "predicates.h"

#define ASC_NONE UINT32_MAX

/* Edges come in pairs of opposite directions, e and e ^ 1. Those out of one place form a ring, counterclockwise.
 * Between places on one circle the diagonals are arbitrary, but the same for the same places. Places on one line have
 * edges along it, and no triangles. */
typedef struct asc_delaunay {
  const asc_place *places; /* not owned */
  uint32_t *first;         /* [place] an edge out of it; ASC_NONE where it is the only place */
  uint32_t *origin;        /* [edge] the place it starts at */
  uint32_t *next;          /* [edge] the next one out of the same place, counterclockwise */
  uint32_t *before;        /* [edge] the one before */
  uint32_t edges;          /* slots in use, free ones among them */
  uint32_t free;           /* the first of a list of free slots, linked by `next` */
} asc_delaunay;

static inline uint32_t asc_edge_end(const asc_delaunay *mesh, uint32_t edge) { return mesh->origin[edge ^ 1u]; }

#define ASC_PLACES_MOST ((size_t)1 << 24)

/* `places` are sorted by x, then by y, and all different, 1 to ASC_PLACES_MOST. Takes time n log n, whatever the
 * places. ASC_OUT_OF_MEMORY. */
asc_status asc_delaunay_create(const asc_place *places, size_t count, asc_delaunay *mesh);
void asc_delaunay_destroy(asc_delaunay *mesh);

#endif

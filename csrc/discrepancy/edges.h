/* Random edges of the unit square, and what a point set's discrepancies at them come to. */
#ifndef ASC_EDGES_H
#define ASC_EDGES_H

#include "measure.h"

/* How an edge is drawn. The numbers are those of the words of ASC_EDGES_PARAMETER. */
typedef enum asc_edges {
  ASC_EDGES_ISOTROPIC, /* invariant under motions: density of the angle as the square's width, offset uniform in it */
  ASC_EDGES_ANGLE_OFFSET, /* angle uniform, offset uniform in the square's width there */
  ASC_EDGES_TWO_POINTS,   /* through two uniform points of the square */
  ASC_EDGES_CHORD         /* through two uniform points of the border that lie on different sides */
} asc_edges;

#define ASC_EDGES_PARAMETER                                                                                            \
  { "edges", ASC_CHOICE, "isotropic|angle-offset|two-points|chord", 0, 0, 0, "how a random edge is drawn" }
#define ASC_MOST_DRAWS 1e9
#define ASC_USUAL_DRAWS 524288 /* about 0.2 s at 1,600 points */

/* Of v = |n/N - area| over the edges drawn. */
typedef struct asc_edge_statistics {
  double mean, mean_error;     /* of v, with its standard error */
  double square, square_error; /* of v^2 */
  double most, most_at[3];     /* the largest v, and a, b, c of its edge: n and area of a x + b y + c >= 0 */
} asc_edge_statistics;

/* Draws `draws` edges, at least one, by the set's seed. With one draw the standard errors are infinite.
 * ASC_OUT_OF_MEMORY. */
asc_status asc_edges_measure(const asc_point_set *set, asc_edges edges, uint64_t draws, asc_edge_statistics *made,
                             asc_error *error);

#endif

/* The table of a filter's integral: the cubic of Hermite between nodes, whose slopes are the profile itself.
 *
 * With at least 64 nodes to a cycle of the profile its error is below h^4 max|p'''| / 384, 1e-9. */
#include "primitive.h"

#include <math.h>
#include <stdlib.h>

#define NODES_LEAST 1024
#define NODES_A_KNOT 64

/* The rule of Gauss and Legendre with 4 points on [0, 1]: on a 64th of a cycle, rounding is what remains. */
#define POINTS 4
static const double rule[POINTS][2] = {{0.0694318442029737124, 0.173927422568726929},
                                       {0.330009478207571868, 0.326072577431273071},
                                       {0.669990521792428132, 0.326072577431273071},
                                       {0.930568155797026288, 0.173927422568726929}};

asc_status asc_primitive_table_create(const asc_filter *filter, asc_primitive_table *made) {
  const double radius = asc_filter_radius(filter);
  const uint32_t spans = (uint32_t)lround(radius / asc_filter_knot_spacing(filter));
  const uint32_t in_span = spans * NODES_A_KNOT < NODES_LEAST ? (NODES_LEAST + spans - 1) / spans : NODES_A_KNOT;
  const uint32_t count = spans * in_span;
  const double spacing = radius / count;
  *made = (asc_primitive_table){NULL, count, radius, count / radius};
  made->nodes = malloc(2 * (size_t)(count + 1) * sizeof *made->nodes);
  if (!made->nodes) return ASC_OUT_OF_MEMORY;
  double integral = 0.0;
  for (uint32_t i = 0; i <= count; i++) {
    /* At the radius the profile is zero; what counts is its value just before. */
    double x[1 + POINTS] = {fmin(radius, i * spacing)}, profile[1 + POINTS];
    if (x[0] >= radius) x[0] = nextafter(radius, 0.0);
    for (int k = 0; k < POINTS; k++) x[1 + k] = spacing * (i + rule[k][0]);
    (void)asc_filter_evaluate(filter, x, 1 + POINTS, profile); /* fails for no null pointer */
    made->nodes[2 * (size_t)i] = integral;
    made->nodes[2 * (size_t)i + 1] = spacing * profile[0];
    for (int k = 0; k < POINTS; k++) integral += spacing * rule[k][1] * profile[1 + k];
  }
  return ASC_OK;
}

void asc_primitive_table_destroy(asc_primitive_table *made) {
  free(made->nodes);
  *made = (asc_primitive_table){0};
}

/* Patterns of surfaces, where these had a point at time 0, in the camera's frame; for loops over samples. */
#ifndef TRACER_SURFACE_PATTERN_H
#define TRACER_SURFACE_PATTERN_H

#include "aliascope/scene.h"
#include "vector.h"
#include "vectorise.h"

/* Of a zone plate: its havercosine is the share of the second colour. */
ASC_INLINE double pattern_phase(const asc_pattern *of, const double point[3]) {
  const double away[3] = {point[0] - of->origin[0], point[1] - of->origin[1], point[2] - of->origin[2]};
  return of->scale * dot(away, away);
}

/* Of a checker: 1 where the sum is odd, which has the second colour, else 0; for sums of any size and sign. */
ASC_INLINE double pattern_parity(const asc_view *view, const asc_pattern *of, const double point[3]) {
  double sum = 0.0;
  for (int i = 0; i < 3; i++) {
    const double along = view->right[i] * point[0] + view->up[i] * point[1] + view->forward[i] * point[2];
    sum += floor(of->scale * (along - of->origin[i]));
  }
  return sum - 2.0 * floor(0.5 * sum);
}

#endif

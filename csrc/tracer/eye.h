/* Rays from the eye, in double, for loops over samples: through (x, y) of the picture they go by (right, up) at
 * distance 1, or, orthographic, all along. */
#ifndef TRACER_EYE_H
#define TRACER_EYE_H

#include "aliascope/scene.h"
#include "vectorise.h"

ASC_INLINE double eye_right(const asc_view *view, double x) {
  return 2.0 * view->half_width / view->width * (x - view->shift[0]) - view->half_width;
}

ASC_INLINE double eye_up(const asc_view *view, double y) {
  return view->half_height - 2.0 * view->half_height / view->height * (y - view->shift[1]);
}

/* What is taken off a direction, along right or up, where the ray starts from the lens that far from its middle. */
ASC_INLINE double eye_turn(const asc_view *view, double off) { return off * (1.0 / view->focus_distance); }

#endif

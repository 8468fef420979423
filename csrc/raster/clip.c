#include "clip.h"

#include <string.h>

enum { PLANE_COUNT = 5 };

static double inside_by(const clip_vertex *v, int plane, const clip_volume *volume) {
  switch (plane) {
  case 0: return volume->guard_x * v->weight + v->x;
  case 1: return volume->guard_x * v->weight - v->x;
  case 2: return volume->guard_y * v->weight + v->y;
  case 3: return volume->guard_y * v->weight - v->y;
  default: return v->depth - volume->nearest;
  }
}

/* Always from the inner corner to the outer one, so that the neighbour, which runs along the edge the other way, gets
 * the same bits. */
static clip_vertex cut(const clip_vertex *inner, double inner_by, const clip_vertex *outer, double outer_by) {
  double t = inner_by / (inner_by - outer_by);
  clip_vertex v = {inner->x + t * (outer->x - inner->x), inner->y + t * (outer->y - inner->y),
                   inner->weight + t * (outer->weight - inner->weight),
                   inner->depth + t * (outer->depth - inner->depth)};
  return v;
}

size_t clip_polygon(clip_vertex polygon[CLIP_CAPACITY], size_t count, const clip_volume *volume) {
  for (int plane = 0; plane < PLANE_COUNT && count > 0; ++plane) {
    clip_vertex kept[CLIP_CAPACITY];
    size_t kept_count = 0;
    for (size_t i = 0; i < count; ++i) {
      const clip_vertex *here = &polygon[i];
      const clip_vertex *next = &polygon[(i + 1) % count];
      double here_by = inside_by(here, plane, volume);
      double next_by = inside_by(next, plane, volume);
      /* Rounding can make a polygon a little concave, and then it crosses the plane more often than twice: what does
       * not fit is a sliver of rounding, outside the picture. */
      if (here_by >= 0.0 && kept_count < CLIP_CAPACITY) {
        kept[kept_count++] = *here;
      }
      if ((here_by >= 0.0) != (next_by >= 0.0) && kept_count < CLIP_CAPACITY) {
        kept[kept_count++] = here_by >= 0.0 ? cut(here, here_by, next, next_by) : cut(next, next_by, here, here_by);
      }
    }
    memcpy(polygon, kept, kept_count * sizeof *kept);
    count = kept_count;
  }
  return count;
}

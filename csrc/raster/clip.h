/* Clipping of convex polygons in double (Sutherland and Hodgman 1974, "Reentrant polygon clipping").
 *
 * The rasteriser would clip in float, and a floor that reaches behind the eye would lose its edges there.
 */
#ifndef RASTER_CLIP_H
#define RASTER_CLIP_H

#include <stddef.h>

/* Homogeneous: the picture spans [-1, 1] in x / weight and y / weight, y up. Perspective: weight = depth, the distance
 * along the line of sight; orthographic: weight = 1. */
typedef struct clip_vertex {
  double x, y, weight, depth;
} clip_vertex;

/* What is kept: |x| <= guard_x weight, |y| <= guard_y weight, depth >= nearest. */
typedef struct clip_volume {
  double guard_x, guard_y, nearest;
} clip_volume;

/* Each of the five planes adds at most one corner to a convex polygon. */
enum { CLIP_CAPACITY = 4 + 5 };

/* Clips the polygon of `count` <= 4 corners in place, returns how many it has then: 0 where nothing is left. A shared
 * edge of two polygons is cut at the same point in both. */
size_t clip_polygon(clip_vertex polygon[CLIP_CAPACITY], size_t count, const clip_volume *volume);

#endif

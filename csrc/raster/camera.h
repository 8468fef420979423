/* The view in numbers, and what of the picture a surface can touch. */
#ifndef RASTER_CAMERA_H
#define RASTER_CAMERA_H

#include <stdbool.h>

#include "aliascope/scene.h"
#include "clip.h"

typedef struct camera {
  const asc_view *view;
  bool perspective;
  double lens[2]; /* the eye's place, along right and up from the middle of the lens; 0 where there is none */
  /* What the picture position of a ray has beyond its slope, or of an orthographic ray beyond the place where it
   * starts: for the point of the lens and for the shift of scene.h. */
  double skew[2];
  /* How far beyond [-1, 1] is kept: half a picture, and at least four pixels, so that no pass moves a cut edge in. */
  double guard_x, guard_y;
  double margin_x, margin_y; /* two pixels: by this a rectangle around a round surface is larger than the surface */
} camera;

/* In the picture's coordinates, [-1, 1], y up. */
typedef struct rectangle {
  double low_x, low_y, high_x, high_y;
} rectangle;

/* Distances along the line of sight. */
typedef struct range {
  double nearest, farthest;
} range;

/* lens: the eye's place on the view's lens, along right and up from its middle; NULL: in the middle. */
camera camera_create(const asc_view *view, const double lens[2]);

/* World to camera: x along right, y along up, z along forward from the eye. */
void camera_point(const camera *from, const double world[3], double local[3]);
void camera_direction(const camera *from, const double world[3], double local[3]);

/* Scales to length 1; `v` is not 0. */
void make_unit(double v[3]);

/* Clips a polygon in camera coordinates, `count` <= 4 corners, to the guarded picture and the half space before the
 * eye. What lies nearer to the eye's plane than 2^-40 of the largest coordinate is cut. */
size_t camera_clip(const camera *by, const double (*corners)[3], size_t count, clip_vertex clipped[CLIP_CAPACITY]);

/* A rectangle that holds the outline, with the margin, and the depths of what can be seen. False: nothing of it is in
 * the picture. Disc: normal of unit length. */
bool camera_disc(const camera *by, const double centre[3], const double normal[3], double radius, rectangle *box,
                 range *depth);
bool camera_sphere(const camera *by, const double centre[3], double radius, rectangle *box, range *depth);
/* The whole picture for the plane normal . p = offset, and the depths that it has there; false where it is seen from
 * the side, or lies behind the eye. */
bool camera_plane(const camera *by, const double normal[3], double offset, rectangle *box, range *depth);

/* Widens `all` by `one`. */
void range_join(range *all, const range *one);

#endif

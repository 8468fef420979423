/* The area of a half-plane within the unit square. */
#ifndef ASC_HALFPLANE_AREA_H
#define ASC_HALFPLANE_AREA_H

/* The area of those (x, y) in the unit square with a x + b y + c >= 0, for finite a, b, c of any size, to a relative
 * error below 1e-15: nothing cancels, whatever the slope and however little is cut off. With a = b = 0 it is 1 where
 * c >= 0, else 0. */
double asc_halfplane_area(double a, double b, double c);

#endif

/* The area of a half-plane within the unit square.
 *
 * The textbook formula, (c^2 - (c-a)^2 - (c-b)^2 + (c-a-b)^2) / (2ab), cancels near axis-parallel lines and divides by
 * zero on them. Here it is read off the values of a x + b y + c at the corners: a triangle, a trapezoid, or the square
 * less a triangle, each of products and sums of positive terms. */
#include <math.h>

#include "halfplane_area.h"

#define HUGE_TERM 0x1p1000
#define SCALE 0x1p-100

/* a + b + c, rounded about once: Knuth's two-sum keeps what each addition loses. */
static double sum_of_three(double a, double b, double c) {
  const double ab = a + b, from_b = ab - a, lost_ab = (a - (ab - from_b)) + (b - from_b);
  const double sum = ab + c, from_c = sum - ab, lost_sum = (ab - (sum - from_c)) + (c - from_c);
  return sum + (lost_ab + lost_sum);
}

double asc_halfplane_area(double a, double b, double c) {
  if (fmax(fmax(fabs(a), fabs(b)), fabs(c)) > HUGE_TERM) { /* so that no sum overflows */
    a *= SCALE;
    b *= SCALE;
    c *= SCALE;
  }
  const double at_00 = c, at_10 = a + c, at_01 = b + c, at_11 = sum_of_three(a, b, c);
  /* The square is mirrored and transposed until a >= b >= 0: the least corner first, the one across it last. */
  const double least = b < 0.0 ? (a < 0.0 ? at_11 : at_01) : (a < 0.0 ? at_10 : at_00);
  const double most = b < 0.0 ? (a < 0.0 ? at_00 : at_10) : (a < 0.0 ? at_01 : at_11);
  const double beside = b < 0.0 ? (a < 0.0 ? at_01 : at_11) : (a < 0.0 ? at_00 : at_10); /* most's in y */
  const double above = b < 0.0 ? (a < 0.0 ? at_10 : at_00) : (a < 0.0 ? at_11 : at_01);  /* most's in x */
  const double larger = fmax(fabs(a), fabs(b)), smaller = fmin(fabs(a), fabs(b));
  if (least >= 0.0) return 1.0;
  if (most <= 0.0) return 0.0;
  if (fmax(beside, above) <= 0.0) return 0.5 * (most / larger) * (most / smaller);
  if (fmin(beside, above) <= 0.0) return 0.5 * (fmax(beside, above) / larger + most / larger);
  return 1.0 - 0.5 * (least / larger) * (least / smaller);
}

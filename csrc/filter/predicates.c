/* Orientation and in-circle tests without a wrong answer.
 *
 * The determinants are those of Guibas and Stolfi 1985, "Primitives for the manipulation of general subdivisions and
 * the computation of Voronoi diagrams", sections 4 and 8. As in Shewchuk 1997, "Adaptive precision floating-point
 * arithmetic and fast robust geometric predicates", the second is tried in double first, and taken again with all its
 * digits where rounding could have turned its sign: places on a grid or a circle all come to that. With coordinates of
 * 52 bits, integers of 256 bits hold it, so no expansions are needed. */
#include "predicates.h"

#include <math.h>

#include "wide.h"

__extension__ typedef __int128 signed_wide; /* of GCC and Clang; not ISO C */

int asc_orientation(asc_place a, asc_place b, asc_place c) {
  const signed_wide left = (signed_wide)(b.x - a.x) * (c.y - a.y), right = (signed_wide)(b.y - a.y) * (c.x - a.x);
  return (left > right) - (left < right);
}

typedef struct wide_product {
  asc_wide high, low; /* one integer of 256 bits, two's complement */
} wide_product;

static wide_product negated(wide_product a) {
  const asc_wide low = ~a.low + 1;
  return (wide_product){~a.high + (low == 0), low};
}

static wide_product sum(wide_product a, wide_product b) {
  const asc_wide low = a.low + b.low;
  return (wide_product){a.high + b.high + (low < a.low), low};
}

/* Both factors below 2^127 in size, b not negative. */
static wide_product product(signed_wide a, asc_wide b) {
  const asc_wide size = a < 0 ? (asc_wide)-a : (asc_wide)a, mask = UINT64_MAX;
  const asc_wide a_high = size >> 64, a_low = size & mask, b_high = b >> 64, b_low = b & mask;
  const asc_wide bottom = a_low * b_low, first = a_low * b_high, second = a_high * b_low;
  const asc_wide middle = (bottom >> 64) + (first & mask) + (second & mask);
  const wide_product whole = {a_high * b_high + (first >> 64) + (second >> 64) + (middle >> 64),
                              (middle << 64) | (bottom & mask)};
  return a < 0 ? negated(whole) : whole;
}

/* Of two places about a third. */
static signed_wide cross(asc_place a, asc_place b) { return (signed_wide)a.x * b.y - (signed_wide)a.y * b.x; }
static asc_wide square(asc_place a) { return (asc_wide)((signed_wide)a.x * a.x + (signed_wide)a.y * a.y); }

static int exact_in_circle(asc_place a, asc_place b, asc_place c) {
  const wide_product whole =
      sum(sum(product(cross(b, c), square(a)), product(cross(c, a), square(b))), product(cross(a, b), square(c)));
  if (whole.high >> 127) return -1;
  return (whole.high | whole.low) != 0;
}

int asc_in_circle(asc_place a, asc_place b, asc_place c, asc_place d) {
  a = (asc_place){a.x - d.x, a.y - d.y};
  b = (asc_place){b.x - d.x, b.y - d.y};
  c = (asc_place){c.x - d.x, c.y - d.y};
  const double ax = (double)a.x, ay = (double)a.y, bx = (double)b.x, by = (double)b.y, cx = (double)c.x,
               cy = (double)c.y;
  const double a_square = ax * ax + ay * ay, b_square = bx * bx + by * by, c_square = cx * cx + cy * cy;
  const double whole = a_square * (bx * cy - by * cx) + b_square * (cx * ay - cy * ax) + c_square * (ax * by - ay * bx);
  const double size = a_square * (fabs(bx * cy) + fabs(by * cx)) + b_square * (fabs(cx * ay) + fabs(cy * ax)) +
                      c_square * (fabs(ax * by) + fabs(ay * bx));
  /* Shewchuk's bound is (10 + 96 e) e of the size for differences that were rounded; these are not. */
  if (fabs(whole) > 0x1.8p-50 * size) return whole > 0.0 ? 1 : -1;
  return exact_in_circle(a, b, c);
}

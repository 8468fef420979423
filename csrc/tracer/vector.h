/* Three-dimensional vectors in double; those of lanes that are traced together lie in rows, a coordinate of all lanes
 * after each other, for loops over lanes that compilers vectorise. */
#ifndef TRACER_VECTOR_H
#define TRACER_VECTOR_H

#include <math.h>
#include <stdalign.h>
#include <stdint.h>

#define PACKET 16 /* lanes */

static inline double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross(const double a[3], const double b[3], double product[3]) {
  product[0] = a[1] * b[2] - a[2] * b[1];
  product[1] = a[2] * b[0] - a[0] * b[2];
  product[2] = a[0] * b[1] - a[1] * b[0];
}

/* fmax without its care for what is no number, which is a call. */
static inline double larger(double a, double b) { return a > b ? a : b; }

static inline int finite3(const double v[3]) { return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]); }

typedef struct vectors {
  alignas(64) double row[3][PACKET];
} vectors;

typedef struct scalars {
  alignas(64) double of[PACKET];
} scalars;

typedef struct pairs {
  alignas(64) double row[2][PACKET];
} pairs;

static inline void get_lane(const vectors *of, uint32_t lane, double v[3]) {
  for (int i = 0; i < 3; i++) v[i] = of->row[i][lane];
}

static inline void set_lane(vectors *of, uint32_t lane, const double v[3]) {
  for (int i = 0; i < 3; i++) of->row[i][lane] = v[i];
}

/* Two directions of length 1 across a third (Duff et al. 2017, "Building an orthonormal basis, revisited"). */
static inline void across(const double w[3], double a[3], double b[3]) {
  const double sign = copysign(1.0, w[2]), c = -1.0 / (sign + w[2]), d = w[0] * w[1] * c;
  a[0] = 1.0 + sign * w[0] * w[0] * c;
  a[1] = sign * d;
  a[2] = -sign * w[0];
  b[0] = d;
  b[1] = sign + w[1] * w[1] * c;
  b[2] = -w[1];
}

#endif

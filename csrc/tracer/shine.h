/* What surfaces shine by themselves, where that is all that is seen of them: for samples in a row that see the same
 * surface, in loops over them. */
#ifndef TRACER_SHINE_H
#define TRACER_SHINE_H

#include "packet.h"

/* What the rays of a packet met. */
typedef struct sight {
  int one;                      /* whether all met one of Embree's primitives, or none, and shine_take does the rest */
  uint32_t geometry, primitive; /* as Embree's; the primitive is 0 where there is none */
} sight;

/* Of a packet whose rays were sent. Of one that is not full it is not one. */
sight shine_see(const tracer *made, const packet *rays);

static inline int shine_same(sight a, sight b) {
  return a.one && b.one && a.geometry == b.geometry && a.primitive == b.primitive;
}

/* Samples in a row: `count` whole packets, where they lie, their points of the lens where there is one, and what is
 * seen there, as a packet has them. */
typedef struct sample_rows {
  size_t count;
  const double *x, *y;
  const double (*lens)[2];
  double (*radiance)[4];
} sample_rows;

/* What samples in a row see of one surface alone: base + change x the share of its pattern's second colour. */
typedef struct paint {
  double base[4], change[4];
  int patterned; /* else the change is 0 */
} paint;

/* Gives 0 where more than one surface may be seen. */
int shine_paint(const tracer *made, sight seen, paint *found);

/* Sets the shares, of a patterned paint. */
void shine_mix(const tracer *made, sight seen, const sample_rows *of, double *mix);

/* Sets the radiance of samples. */
void shine_take(const tracer *made, sight seen, const sample_rows *of);

/* Sets the radiance of a packet that met several primitives. Gives 0 where it can't. */
int shine_take_each(const tracer *made, const packet *rays);

#endif

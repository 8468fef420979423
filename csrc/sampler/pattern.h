/* What the files of patterns share. Each pattern is one file that defines one asc_sampler_interface; registry.c lists
 * them. */
#ifndef ASC_PATTERN_H
#define ASC_PATTERN_H

#include "aliascope/plugin.h"
#include "hash.h"

#define ASC_SEQUENCE_END ((uint64_t)1 << 53) /* of sequences in double */
#define ASC_NET_END ((uint64_t)1 << 32)      /* of nets of 32 bits */

/* The k with k^power = n, or 0. */
uint64_t asc_exact_root(uint64_t n, uint32_t power);

/* A random place in one of `cells` equal cells of [0, 1). It has only as many digits as leave it exact and its rounding
 * errors short of the next cell. For at most ASC_JITTER_CELLS cells. */
#define ASC_JITTER_CELLS ((uint64_t)1 << 48)

typedef struct asc_jitter {
  uint32_t dropped; /* of 32 random bits */
  double scale, per_cell;
} asc_jitter;

static inline asc_jitter asc_jitter_of(uint64_t cells) {
  asc_jitter jitter = {1, 0x1p-31, cells ? 1.0 / (double)cells : 0.0};
  for (uint64_t limit = (uint64_t)1 << 18; limit < cells; limit *= 2) {
    jitter.dropped++;
    jitter.scale *= 2.0;
  }
  return jitter;
}

/* The half keeps off the cell's ends, by 2^-50 of the result or more, where its two roundings add up to 2^-52. */
static inline double asc_jitter_place(asc_jitter jitter, double cell, uint32_t bits) {
  return (cell + ((double)(int32_t)(bits >> jitter.dropped) + 0.5) * jitter.scale) * jitter.per_cell;
}

/* x + shift modulo 1, for both in [0, 1). */
static inline double asc_rotate(double x, double shift) {
  double sum = x + shift;
  return sum >= 1.0 ? sum - 1.0 : sum;
}

/* The random shift of one dimension of one pixel's pattern (Cranley and Patterson 1976). */
static inline double asc_rotation(asc_key key, uint32_t dimension) {
  return (double)(asc_draw(key, dimension, ASC_PURPOSE_ROTATION) >> 11) * 0x1p-53;
}

#endif

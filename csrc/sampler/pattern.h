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

/* x + shift modulo 1, for both in [0, 1). */
static inline double asc_rotate(double x, double shift) {
  double sum = x + shift;
  return sum >= 1.0 ? sum - 1.0 : sum;
}

/* The random shift of one dimension of one pixel's pattern (Cranley and Patterson 1976). */
double asc_rotation(asc_key key, uint32_t dimension);

#endif

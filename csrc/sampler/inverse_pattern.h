/* What halton and hammersley share: points whose coordinates are radical inverses in the primes, the first one i/N or
 * not, scrambled or not. */
#ifndef ASC_INVERSE_PATTERN_H
#define ASC_INVERSE_PATTERN_H

#include "pattern.h"

#define ASC_INVERSE_DIMENSIONS 1024

/* In the order of the parameter's words. */
enum { ASC_SCRAMBLE_NONE, ASC_SCRAMBLE_SHIFT, ASC_SCRAMBLE_DIGIT, ASC_SCRAMBLE_OWEN };
#define ASC_SCRAMBLES "none|shift|digit|owen"

typedef struct asc_inverse_pattern asc_inverse_pattern;

/* `leading`: the first coordinate is i/N. ASC_OUT_OF_MEMORY; `name` is for its message. */
asc_status asc_inverse_pattern_make(const asc_sampler_config *config, int scramble, int leading, const char *name,
                                    asc_inverse_pattern **made, asc_error *error);
/* Of an asc_inverse_pattern. */
void asc_inverse_pattern_destroy(void *opaque);
asc_status asc_inverse_pattern_fill(const void *opaque, const asc_range *range, double *points);

#endif

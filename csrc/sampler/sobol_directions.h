/* The primitive polynomials and initial direction numbers of Joe and Kuo 2008 (new-joe-kuo-6). */
#ifndef ASC_SOBOL_DIRECTIONS_H
#define ASC_SOBOL_DIRECTIONS_H

#include <stdint.h>

#define ASC_SOBOL_DIMENSIONS 1024

/* x^degree + a_1 x^(degree-1) + ... + a_(degree-1) x + 1, the a_i as the bits of `coefficients`, a_1 the highest;
 * m_1 ... m_degree begin at asc_sobol_initial[first]. */
typedef struct asc_sobol_polynomial {
  uint32_t degree, coefficients, first;
} asc_sobol_polynomial;

extern const asc_sobol_polynomial asc_sobol_polynomials[ASC_SOBOL_DIMENSIONS];
extern const uint32_t asc_sobol_initial[];

#endif

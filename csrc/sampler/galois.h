/* Arithmetic in the finite field of s elements, s a prime power p^m up to 2^16. An element is the number 0 .. s-1 whose
 * digits in base p are the coefficients of a polynomial over the integers modulo p. */
#ifndef ASC_GALOIS_H
#define ASC_GALOIS_H

#include <stdint.h>

#include "aliascope/base.h"

#define ASC_GALOIS_MOST (1u << 16)

typedef struct asc_galois {
  uint32_t size, prime, power;
  /* Where m > 1: power_of[i] = g^i for a generator g, i from 0 to 2 s - 4, and its inverse for what is not 0. */
  uint16_t *power_of, *logarithm;
} asc_galois;

/* 1 where s = p^m with p prime, m >= 1. */
int asc_is_prime_power(uint32_t s, uint32_t *prime, uint32_t *power);

/* s a prime power up to 2^16, or 1: a field of the one element 0, for what has a single cell. ASC_OUT_OF_MEMORY. */
asc_status asc_galois_make(asc_galois *made, uint32_t s);
void asc_galois_free(asc_galois *field);

uint32_t asc_galois_add(const asc_galois *field, uint32_t a, uint32_t b);
uint32_t asc_galois_multiply(const asc_galois *field, uint32_t a, uint32_t b);

#endif

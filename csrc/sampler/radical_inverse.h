/* The radical inverse phi_b(i): the digits of i in base b, reversed and put behind the point; plain and scrambled. */
#ifndef ASC_RADICAL_INVERSE_H
#define ASC_RADICAL_INVERSE_H

#include "pattern.h"
#include "vectorise.h"

/* Digits are reversed a chunk at a time: `chunk` is the largest power of the base that keeps the table in the innermost
 * cache, or the base itself where that is larger. `reversed` is the table of a chunk's reversals, followed by its first
 * ASC_LANES entries again (NULL: a chunk is one digit). */
typedef struct asc_radix {
  uint32_t base, chunk;
  uint32_t digits;   /* of a chunk */
  uint32_t per_base; /* digits of a chunk / base is the high word of their product */
  uint32_t shift;    /* index / chunk is the high word of index x magic, shifted */
  uint64_t magic;
  uint16_t *reversed;
} asc_radix;

/* base from 2 to 8,192. ASC_OUT_OF_MEMORY. The caller frees `reversed`. */
asc_status asc_radix_make(asc_radix *made, uint32_t base);

__extension__ typedef unsigned __int128 asc_uint128;

/* index / chunk, for index < 2^53; and digits / base, for digits of a chunk. */
ASC_INLINE uint64_t asc_radix_rest(const asc_radix *radix, uint64_t index) {
  return (uint64_t)(((asc_uint128)index * radix->magic) >> 64) >> radix->shift;
}
ASC_INLINE uint32_t asc_digit_rest(const asc_radix *radix, uint32_t digits) {
  return (uint32_t)(((uint64_t)digits * radix->per_base) >> 32);
}

/* Within 2 ulp: the chunks in Horner's order, least significant of the result first, so that each rounding is divided
 * away by those that follow. Index < 2^53. */
double asc_radical_inverse(const asc_radix *radix, uint64_t index);

/* What is random of one dimension and pixel. */
typedef struct asc_digit_key {
  uint64_t word[2];
} asc_digit_key;

static inline asc_digit_key asc_digit_key_of(asc_key key, uint32_t dimension) {
  return (asc_digit_key){
      {asc_draw(key, 2 * dimension, ASC_PURPOSE_SCRAMBLE), asc_draw(key, 2 * dimension + 1, ASC_PURPOSE_SCRAMBLE)}};
}

/* A random digital shift: to each digit, the zeros past the last one of the index included, a random digit of its own
 * is added modulo the base, the same for all indices. */
double asc_radical_inverse_shifted(const asc_radix *radix, uint64_t index, asc_digit_key key);

/* Nested uniform scrambling (Owen 1995, "Randomly permuted (t,m,s)-nets and (t,s)-sequences"): each digit, the zeros
 * past the last one included, goes through a random permutation of its own for each value of the digits before it. All
 * permutations are equally likely to within 2^-32 for bases up to 61; above, they are the keyed ones of permutation.h.
 */
double asc_radical_inverse_nested(const asc_radix *radix, uint64_t index, asc_digit_key key);

/* The same two for numbers of 53 binary digits, x in [0, 1). */
double asc_binary_shifted(double x, asc_digit_key key);
double asc_binary_nested(double x, asc_digit_key key);

#endif

/* Random permutations of 0 .. n-1, made from a hash, any element without the others. */
#ifndef ASC_PERMUTATION_H
#define ASC_PERMUTATION_H

#include "hash.h"

#define ASC_PERMUTATION_TABLE 64

typedef struct asc_permutation {
  uint64_t size;
  uint32_t bits; /* of the power of two that holds `size` */
  uint32_t round_key[8];
  uint8_t table[ASC_PERMUTATION_TABLE];
} asc_permutation;

/* For n up to 64 every permutation is equally likely (Fisher and Yates; Durstenfeld 1964). Above, a Feistel network of
 * 8 rounds on the power of four that holds n, walked until it lands below n (Black and Rogaway 2002, "Ciphers with
 * arbitrary finite domains"). n from 1 to 2^53. */
void asc_permutation_make(asc_permutation *made, uint64_t size, asc_key key, uint32_t index);

uint64_t asc_permutation_at(const asc_permutation *permutation, uint64_t element);

#endif

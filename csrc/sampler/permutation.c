#include "permutation.h"

/* A number below `bound` without bias: 64 bits times the bound, high word, rejecting the short tail (Lemire 2019). */
static uint32_t draw_below(asc_key key, uint32_t index, uint32_t element, uint32_t bound) {
  const uint32_t reject_below = (0u - bound) % bound;
  for (uint32_t attempt = 0;; attempt++) {
    asc_block block = asc_hash(key, ((uint64_t)attempt << 32) | element, index, ASC_PURPOSE_PERMUTATION);
    for (int i = 0; i < 4; i++) {
      uint64_t product = (uint64_t)block.word[i] * bound;
      if ((uint32_t)product >= reject_below) return (uint32_t)(product >> 32);
    }
  }
}

void asc_permutation_make(asc_permutation *made, uint64_t size, asc_key key, uint32_t index) {
  made->size = size;
  made->bits = 2;
  if (size <= ASC_PERMUTATION_TABLE) {
    for (uint32_t i = 0; i < size; i++) {
      uint32_t j = draw_below(key, index, i, i + 1);
      made->table[i] = made->table[j];
      made->table[j] = (uint8_t)i;
    }
    return;
  }
  while (((uint64_t)1 << made->bits) < size) made->bits += 2;
  for (uint32_t half = 0; half < 2; half++) {
    asc_block block = asc_hash(key, UINT64_MAX - half, index, ASC_PURPOSE_PERMUTATION);
    for (uint32_t i = 0; i < 4; i++) made->round_key[4 * half + i] = block.word[i];
  }
}

/* The finaliser of MurmurHash3 (Appleby), which mixes every bit of its input into every bit of its output. */
static uint32_t mix(uint32_t x) {
  x ^= x >> 16;
  x *= 0x85ebca6bu;
  x ^= x >> 13;
  x *= 0xc2b2ae35u;
  x ^= x >> 16;
  return x;
}

uint64_t asc_permutation_at(const asc_permutation *permutation, uint64_t element) {
  if (permutation->size <= ASC_PERMUTATION_TABLE) return permutation->table[element];
  const uint32_t half = permutation->bits / 2;
  const uint32_t mask = (uint32_t)(((uint64_t)1 << half) - 1);
  uint64_t x = element;
  do {
    uint32_t left = (uint32_t)(x >> half), right = (uint32_t)x & mask;
    for (int round = 0; round < 8; round++) {
      uint32_t next = (left ^ mix(right ^ permutation->round_key[round])) & mask;
      left = right;
      right = next;
    }
    x = ((uint64_t)left << half) | right;
  } while (x >= permutation->size);
  return x;
}

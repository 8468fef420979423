#include "permutation.h"

#include "vectorise.h"

/* --- up to 64: a table ----------------------------------------------------------------------------------------------
 */

/* A number below `bound` without bias: 32 bits times the bound, high word, rejecting the short tail (Lemire 2019). */
static uint32_t draw_below(asc_key key, uint32_t index, uint32_t element, uint32_t bits, uint32_t bound) {
  const uint32_t reject_below = (0u - bound) % bound;
  uint64_t product = (uint64_t)bits * bound;
  for (uint64_t attempt = 1; (uint32_t)product < reject_below; attempt++)
    product = (uint64_t)asc_hash(key, (attempt << 32) | element, index, ASC_PURPOSE_PERMUTATION).word[0] * bound;
  return (uint32_t)(product >> 32);
}

static void make_table(asc_permutation *made, uint64_t size, asc_key key, uint32_t index) {
  made->size = size;
  asc_lanes bits;
  asc_hash_lanes(key, 0, index, ASC_PURPOSE_PERMUTATION, &bits);
  for (uint32_t i = 0; i < size; i++) {
    const uint32_t j = draw_below(key, index, i, bits.word[i / ASC_LANES][i % ASC_LANES], i + 1);
    made->table[i] = made->table[j];
    made->table[j] = (uint8_t)i;
  }
}

/* --- above: a keyed bijection, walked -------------------------------------------------------------------------------
 */

void asc_permutation_key(asc_permutation *made, uint64_t size, uint64_t addends, uint64_t multipliers) {
  asc_permutation_set(made, size, addends, multipliers);
}

void asc_permutation_make(asc_permutation *made, uint64_t size, asc_key key, uint32_t index) {
  if (size <= ASC_PERMUTATION_TABLE)
    make_table(made, size, key, index);
  else
    asc_permutation_key(made, size, asc_draw(key, 2 * index, ASC_PURPOSE_PERMUTATION),
                        asc_draw(key, 2 * index + 1, ASC_PURPOSE_PERMUTATION));
}

ASC_VECTORISE
static uint64_t walk_one(const asc_permutation *permutation, uint64_t element) {
  return asc_permutation_walk(permutation, element);
}

uint64_t asc_permutation_at(const asc_permutation *permutation, uint64_t element) {
  return permutation->size <= ASC_PERMUTATION_TABLE ? permutation->table[element] : walk_one(permutation, element);
}

/* The bijection in 32 bits. A round is a chain of dependent steps, so all elements go through one before the next. */
ASC_INLINE void apply(const asc_permutation *permutation, uint32_t x[ASC_PERMUTATION_RUN]) {
  const uint32_t mask = (uint32_t)permutation->mask, shift = permutation->shift;
  for (uint32_t round = 0; round < ASC_PERMUTATION_ROUNDS; round++) {
    const uint32_t added = (uint32_t)asc_permutation_addend(permutation->addends, round);
    const uint32_t factor = (uint32_t)asc_permutation_multiplier(permutation->multipliers, round);
    for (int i = 0; i < ASC_PERMUTATION_RUN; i++) {
      const uint32_t product = (x[i] + added) * factor & mask;
      x[i] = product ^ (product >> shift);
    }
  }
}

ASC_VECTORISE
static void walk(const asc_permutation *permutation, uint32_t first, double images[ASC_PERMUTATION_RUN]) {
  const uint32_t last = (uint32_t)(permutation->size - 1);
  uint32_t x[ASC_PERMUTATION_RUN], landed[ASC_PERMUTATION_RUN];
  for (uint32_t i = 0; i < ASC_PERMUTATION_RUN; i++) x[i] = last - first < i ? last : first + i;
  apply(permutation, x);
  for (int i = 0; i < ASC_PERMUTATION_RUN; i++) landed[i] = x[i];
  for (;;) {
    uint32_t outside = 0;
    for (int i = 0; i < ASC_PERMUTATION_RUN; i++) outside |= landed[i] > last;
    if (!outside) break;
    apply(permutation, x);
    for (int i = 0; i < ASC_PERMUTATION_RUN; i++) landed[i] = landed[i] > last ? x[i] : landed[i];
  }
  /* Signed numbers are what all vector units convert. */
  for (int i = 0; i < ASC_PERMUTATION_RUN; i++) images[i] = (double)(int32_t)(landed[i] ^ 0x80000000u) + 0x1p31;
}

void asc_permutation_run(const asc_permutation *permutation, uint64_t first, double images[ASC_PERMUTATION_RUN]) {
  const uint64_t size = permutation->size;
  if (size > ASC_PERMUTATION_TABLE && size <= (uint64_t)1 << 32) {
    walk(permutation, (uint32_t)first, images);
    return;
  }
  for (uint64_t i = 0; i < ASC_PERMUTATION_RUN; i++)
    images[i] = (double)asc_permutation_at(permutation, size - 1 - first < i ? size - 1 : first + i);
}

#include "permutation_family.h"

void asc_permutation_family_begin(asc_permutation_family *family, uint64_t size, asc_key key, uint32_t index) {
  const asc_block block = asc_hash(key, 0, index, ASC_PURPOSE_STRATUM);
  family->size = size;
  family->key = (asc_key){{block.word[0], block.word[1]}};
  family->known = 0;
}

uint64_t asc_permutation_family_at(asc_permutation_family *family, uint32_t member, uint64_t element) {
  if (family->size == 1) return 0;
  if (member >= ASC_FAMILY_KEPT) {
    asc_permutation once;
    asc_permutation_make(&once, family->size, family->key, member);
    return asc_permutation_at(&once, element);
  }
  const uint64_t bit = (uint64_t)1 << member;
  if (!(family->known & bit)) asc_permutation_make(&family->kept[member], family->size, family->key, member);
  family->known |= bit;
  return asc_permutation_at(&family->kept[member], element);
}

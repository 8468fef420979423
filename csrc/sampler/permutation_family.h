/* Independent random permutations of one size, one for each member number: of the cells of each row, say. */
#ifndef ASC_PERMUTATION_FAMILY_H
#define ASC_PERMUTATION_FAMILY_H

#include "permutation.h"

#define ASC_FAMILY_KEPT 64

/* Members are made when they are first asked for; the first 64 are kept, since small ones (permutation.h) are slow to
 * make. A family is a value of one call of `fill`, never shared. */
typedef struct asc_permutation_family {
  uint64_t size;
  asc_key key;
  uint64_t known; /* bit i: member i is made */
  asc_permutation kept[ASC_FAMILY_KEPT];
} asc_permutation_family;

/* `index` tells the families of one key apart. */
void asc_permutation_family_begin(asc_permutation_family *family, uint64_t size, asc_key key, uint32_t index);

/* What permutation `member` makes of `element`. */
uint64_t asc_permutation_family_at(asc_permutation_family *family, uint32_t member, uint64_t element);

#endif

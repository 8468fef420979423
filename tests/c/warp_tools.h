/* What the tests of warps share. */
#ifndef WARP_TOOLS_H
#define WARP_TOOLS_H

#include "aliascope/warp.h"
#include "hash.h"

/* Uniform numbers, fixed. */
static inline double drawn(uint32_t index, uint32_t which) {
  const asc_block block = asc_hash((asc_key){{2024, 7}}, index, which, ASC_PURPOSE_UNIFORM);
  return asc_unit53(block.word[0], block.word[1]);
}

#endif

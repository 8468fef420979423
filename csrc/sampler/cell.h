/* A point in a cell of an axis. */
#ifndef ASC_CELL_H
#define ASC_CELL_H

#include "hash.h"

/* Random bits of up to ASC_LANES samples from `first` on. A few are hashed one by one, since lanes are hashed all. */
static inline void asc_cell_bits(asc_key key, uint64_t first, size_t count, uint32_t index, asc_lanes *lanes) {
  if (count >= 4) {
    asc_hash_lanes(key, first, index, ASC_PURPOSE_UNIFORM, lanes);
    return;
  }
  for (size_t i = 0; i < count; i++) {
    const asc_block block = asc_hash(key, first + i, index, ASC_PURPOSE_UNIFORM);
    for (int word = 0; word < 4; word++) lanes->word[word][i] = block.word[word];
  }
}

/* A uniform point of cell `cell` of `cells` equal ones of [0, 1), from 32 random bits. From 2^18 cells on, 16 of the
 * bits are left away: with them neither cell + u nor the quotient can round to the next cell. cells up to 2^32. */
static inline double asc_in_cell(uint64_t cell, uint64_t cells, uint32_t bits) {
  const double u = cells < (1u << 18) ? asc_unit32(bits) : ((double)(bits >> 16) + 0.5) * 0x1p-16;
  return ((double)cell + u) / (double)cells;
}

/* The same, or the centre of the cell. */
static inline double asc_in_cell_or_centre(uint64_t cell, uint64_t cells, uint32_t bits, int centred) {
  return centred ? ((double)cell + 0.5) / (double)cells : asc_in_cell(cell, cells, bits);
}

#endif

#include "hash.h"

#include <string.h>

#include "vectorise.h"
#if ASC_HAS_LEVELS
#include <immintrin.h>
#endif

/* Multipliers and Weyl increments of Philox4x32 (Salmon et al. 2011, section 3.3 and table 2). */
#define MULTIPLIER_0 0xD2511F53u
#define MULTIPLIER_1 0xCD9E8D57u
#define WEYL_0 0x9E3779B9u
#define WEYL_1 0xBB67AE85u
#define ROUNDS 10

asc_block asc_philox(const uint32_t counter[4], const uint32_t key[2]) {
  uint32_t c0 = counter[0], c1 = counter[1], c2 = counter[2], c3 = counter[3];
  uint32_t k0 = key[0], k1 = key[1];
  for (int round = 0; round < ROUNDS; round++) {
    uint64_t p0 = (uint64_t)MULTIPLIER_0 * c0;
    uint64_t p1 = (uint64_t)MULTIPLIER_1 * c2;
    c0 = (uint32_t)(p1 >> 32) ^ c1 ^ k0;
    c1 = (uint32_t)p1;
    c2 = (uint32_t)(p0 >> 32) ^ c3 ^ k1;
    c3 = (uint32_t)p0;
    k0 += WEYL_0;
    k1 += WEYL_1;
  }
  return (asc_block){{c0, c1, c2, c3}};
}

asc_block asc_hash(asc_key key, uint64_t sample, uint32_t index, uint32_t purpose) {
  const uint32_t counter[4] = {(uint32_t)sample, (uint32_t)(sample >> 32), index, purpose};
  return asc_philox(counter, key.word);
}

/* The compiler has no pattern for the multiplication of 32 by 32 bits to 64 that all vector units have (for it, a
 * product of 64-bit lanes is three of those), so hash_lanes.h names it, and is compiled once for each. */
#define LANES_FUNCTION hash_lanes_baseline
#include "hash_lanes.h"

#if ASC_HAS_LEVELS
#pragma GCC push_options
#pragma GCC target("arch=x86-64-v3")
#define LANES_FUNCTION hash_lanes_v3
#include "hash_lanes.h"
#pragma GCC pop_options

#pragma GCC push_options
#pragma GCC target("arch=x86-64-v4")
#define LANES_FUNCTION hash_lanes_v4
#include "hash_lanes.h"
#pragma GCC pop_options
#endif

int asc_hash_lanes_of_level(int level, asc_key key, uint64_t first, uint32_t index, uint32_t purpose,
                            asc_lanes *lanes) {
#if ASC_HAS_LEVELS
  if (level == 4 && __builtin_cpu_supports("x86-64-v4")) {
    hash_lanes_v4(key, first, index, purpose, lanes);
    return 1;
  }
  if (level == 3 && __builtin_cpu_supports("x86-64-v3")) {
    hash_lanes_v3(key, first, index, purpose, lanes);
    return 1;
  }
#endif
  if (level > 0) return 0;
  hash_lanes_baseline(key, first, index, purpose, lanes);
  return 1;
}

void asc_hash_lanes(asc_key key, uint64_t first, uint32_t index, uint32_t purpose, asc_lanes *lanes) {
  if (asc_hash_lanes_of_level(4, key, first, index, purpose, lanes)) return;
  if (asc_hash_lanes_of_level(3, key, first, index, purpose, lanes)) return;
  (void)asc_hash_lanes_of_level(0, key, first, index, purpose, lanes);
}

#include "hash.h"

#include "vectorise.h"

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

asc_key asc_stream_key(uint64_t seed, int32_t pixel_x, int32_t pixel_y) {
  const uint32_t counter[4] = {(uint32_t)pixel_x, (uint32_t)pixel_y, 0, ASC_PURPOSE_STREAM};
  const uint32_t key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
  asc_block block = asc_philox(counter, key);
  return (asc_key){{block.word[0], block.word[1]}};
}

asc_block asc_hash(asc_key key, uint64_t sample, uint32_t index, uint32_t purpose) {
  const uint32_t counter[4] = {(uint32_t)sample, (uint32_t)(sample >> 32), index, purpose};
  return asc_philox(counter, key.word);
}

ASC_VECTORISE
void asc_hash_lanes(asc_key key, uint64_t first, uint32_t index, uint32_t purpose, asc_lanes *lanes) {
  uint32_t c0[ASC_LANES], c1[ASC_LANES], c2[ASC_LANES], c3[ASC_LANES];
  uint32_t k0 = key.word[0], k1 = key.word[1];
  for (uint32_t i = 0; i < ASC_LANES; i++) {
    uint64_t sample = first + i;
    c0[i] = (uint32_t)sample;
    c1[i] = (uint32_t)(sample >> 32);
    c2[i] = index;
    c3[i] = purpose;
  }
  for (int round = 0; round < ROUNDS; round++) {
    for (int i = 0; i < ASC_LANES; i++) {
      uint64_t p0 = (uint64_t)MULTIPLIER_0 * c0[i];
      uint64_t p1 = (uint64_t)MULTIPLIER_1 * c2[i];
      c0[i] = (uint32_t)(p1 >> 32) ^ c1[i] ^ k0;
      c1[i] = (uint32_t)p1;
      c2[i] = (uint32_t)(p0 >> 32) ^ c3[i] ^ k1;
      c3[i] = (uint32_t)p0;
    }
    k0 += WEYL_0;
    k1 += WEYL_1;
  }
  for (int i = 0; i < ASC_LANES; i++) {
    lanes->word[0][i] = c0[i];
    lanes->word[1][i] = c1[i];
    lanes->word[2][i] = c2[i];
    lanes->word[3][i] = c3[i];
  }
}

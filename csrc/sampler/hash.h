/* The library's one source of randomness: counter-based hashes, so that a value can be had without those before it.
 *
 *   asc_hash   Philox4x32-10: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011. It
 *              passes the BigCrush battery of TestU01 (L'Ecuyer and Simard 2007) with 10 rounds, and with as few as 7.
 *              Counter: (sample, index, purpose). For random points, and wherever much is drawn.
 *   asc_draw   SplitMix64: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014. It passes
 *              BigCrush too, and takes a seventh of the time, which counts where samples are asked for one by one. For
 *              what is drawn once for a pixel and dimension (a shift, the seed of a scrambling or a permutation), and
 *              for places in cells.
 *
 * The 64-bit key of both is itself hashed from (seed, pixel x, pixel y). `index` counts dimensions or pairs of them and
 * `purpose` keeps different uses apart. */
#ifndef ASC_HASH_H
#define ASC_HASH_H

#include <stddef.h>
#include <stdint.h>

/* What bits are drawn for. Numbers are never used twice or changed: they are part of every pattern's bits. */
enum asc_purpose {
  ASC_PURPOSE_STREAM = 0,
  ASC_PURPOSE_UNIFORM = 1,
  ASC_PURPOSE_STRATUM = 2,
  ASC_PURPOSE_PERMUTATION = 3,
  ASC_PURPOSE_ROTATION = 4,
  ASC_PURPOSE_SCRAMBLE = 5,
  ASC_PURPOSE_STREAM_OF_BITS = 6,
  ASC_PURPOSE_EDGE = 7, /* of the measures of random edges */
  ASC_PURPOSE_RANK = 8  /* of arrangements of groups of dimensions */
};

typedef struct asc_key {
  uint32_t word[2];
} asc_key;

typedef struct asc_block {
  uint32_t word[4];
} asc_block;

/* Samples are hashed this many at a time, side by side. */
#define ASC_LANES 16

typedef struct asc_lanes {
  uint32_t word[4][ASC_LANES];
} asc_lanes;

/* Philox4x32-10 of a counter under a key; the known answers of Random123 are in the tests. */
asc_block asc_philox(const uint32_t counter[4], const uint32_t key[2]);

/* 128 random bits for (sample, index, purpose) in the stream of `key`. */
asc_block asc_hash(asc_key key, uint64_t sample, uint32_t index, uint32_t purpose);

/* The same for the samples first, first + 1, ... first + ASC_LANES - 1. */
void asc_hash_lanes(asc_key key, uint64_t first, uint32_t index, uint32_t purpose, asc_lanes *lanes);

/* The same by the instructions of x86-64-v4, of -v3, or (level 0) of the oldest machine that the library is compiled
 * for: what asc_hash_lanes chooses from, for the tests. 0 where the machine lacks them. */
int asc_hash_lanes_of_level(int level, asc_key key, uint64_t first, uint32_t index, uint32_t purpose, asc_lanes *lanes);

/* The finaliser of SplitMix64: a bijection of 64 bits in which every bit depends on every other. */
static inline uint64_t asc_mix64(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

#define ASC_GOLDEN 0x9e3779b97f4a7c15u /* 2^64 divided by the golden ratio: SplitMix64's increment */

/* The part of a key that all pixels share, to be made once. */
static inline uint64_t asc_seed_mix(uint64_t seed) { return asc_mix64(seed + ASC_GOLDEN); }

/* The key of one pixel's stream: under one seed, no two pixels have the same. (x and y are not first put together in a
 * word: read as one, they would wait for the two writes of who filled the range in.) */
static inline asc_key asc_pixel_key(uint64_t seed_mix, int32_t pixel_x, int32_t pixel_y) {
  const uint64_t key = asc_mix64((seed_mix ^ (uint32_t)pixel_x) + ((uint64_t)(uint32_t)pixel_y << 32));
  return (asc_key){{(uint32_t)key, (uint32_t)(key >> 32)}};
}

static inline asc_key asc_stream_key(uint64_t seed, int32_t pixel_x, int32_t pixel_y) {
  return asc_pixel_key(asc_seed_mix(seed), pixel_x, pixel_y);
}

/* Where in SplitMix64's sequence (index, purpose) of the stream of `key` is; the next index is ASC_GOLDEN further. */
static inline uint64_t asc_draw_start(asc_key key, uint32_t index, uint32_t purpose) {
  const uint64_t start = ((uint64_t)key.word[1] << 32) | key.word[0];
  return start + (((uint64_t)purpose << 32) + index + 1) * ASC_GOLDEN;
}

/* 64 random bits for (index, purpose) in the stream of `key`. */
static inline uint64_t asc_draw(asc_key key, uint32_t index, uint32_t purpose) {
  return asc_mix64(asc_draw_start(key, index, purpose));
}

/* 64 random bits of one sample in the sequence that starts with a drawn number. */
static inline uint64_t asc_draw_at(uint64_t start, uint64_t sample) { return asc_mix64(start + sample * ASC_GOLDEN); }

/* [0, 1) in steps of 2^-53. */
static inline double asc_unit53(uint32_t high, uint32_t low) {
  return (double)((((uint64_t)high << 32) | low) >> 11) * 0x1p-53;
}

/* (0, 1), the centres of 2^32 intervals. (i + u) / k keeps to its cell i of k for every k below 2^20: u has so few
 * digits that i + u is exact. */
static inline double asc_unit32(uint32_t bits) { return ((double)bits + 0.5) * 0x1p-32; }

#endif

/* The library's one source of randomness: a counter-based hash, so that a value can be had without those before it.
 *
 * Philox4x32-10: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011. It passes the
 * BigCrush battery of TestU01 (L'Ecuyer and Simard 2007) with 10 rounds, and with as few as 7.
 *
 * The 64-bit key is itself hashed from (seed, pixel x, pixel y); the 128-bit counter is (sample, index, purpose), where
 * `index` counts dimensions or pairs of them and `purpose` keeps different uses apart.
 */
#ifndef ASC_HASH_H
#define ASC_HASH_H

#include <stddef.h>
#include <stdint.h>

/* What a block is drawn for. Numbers are never used twice or changed: they are part of every pattern's bits. */
enum asc_purpose {
  ASC_PURPOSE_STREAM = 0,
  ASC_PURPOSE_UNIFORM = 1,
  ASC_PURPOSE_STRATUM = 2,
  ASC_PURPOSE_PERMUTATION = 3,
  ASC_PURPOSE_ROTATION = 4,
  ASC_PURPOSE_SCRAMBLE = 5,
  ASC_PURPOSE_STREAM_OF_BITS = 6,
  ASC_PURPOSE_EDGE = 7 /* of the measures of random edges */
};

typedef struct asc_key {
  uint32_t word[2];
} asc_key;

typedef struct asc_block {
  uint32_t word[4];
} asc_block;

/* Samples are hashed this many at a time, side by side, for the compiler to vectorise. */
#define ASC_LANES 16

typedef struct asc_lanes {
  uint32_t word[4][ASC_LANES];
} asc_lanes;

/* Philox4x32-10 of a counter under a key; the known answers of Random123 are in the tests. */
asc_block asc_philox(const uint32_t counter[4], const uint32_t key[2]);

/* The key of one pixel's stream. */
asc_key asc_stream_key(uint64_t seed, int32_t pixel_x, int32_t pixel_y);

/* 128 random bits for (sample, index, purpose) in the stream of `key`. */
asc_block asc_hash(asc_key key, uint64_t sample, uint32_t index, uint32_t purpose);

/* The same for the samples first, first + 1, ... first + ASC_LANES - 1. */
void asc_hash_lanes(asc_key key, uint64_t first, uint32_t index, uint32_t purpose, asc_lanes *lanes);

/* [0, 1) in steps of 2^-53. */
static inline double asc_unit53(uint32_t high, uint32_t low) {
  return (double)((((uint64_t)high << 32) | low) >> 11) * 0x1p-53;
}

/* (0, 1), the centres of 2^32 intervals. (i + u) / k keeps to its cell i of k for every k below 2^20: u has so few
 * digits that i + u is exact. */
static inline double asc_unit32(uint32_t bits) { return ((double)bits + 0.5) * 0x1p-32; }

#endif

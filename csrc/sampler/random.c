/* Independent uniform points: what every other pattern is measured against.
 *
 * Source: Metropolis and Ulam 1949, "The Monte Carlo method". The numbers are those of hash.h: one block of 128 bits
 * for each pair of dimensions of each sample. */
#include <stdlib.h>

#include "pattern.h"
#include "tile.h"

typedef struct random_state {
  uint64_t seed_mix;
} random_state;

static asc_status random_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  random_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "random: out of memory");
  state->seed_mix = asc_seed_mix(config->seed);
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED | ASC_TRAIT_SEQUENCE, ASC_SEQUENCE_END};
  return ASC_OK;
}

/* The 53 bits of a value, in two steps of which all vector units can convert the words: 2^-32 high + 2^-53 (low /
 * 2^11), both exact, as is their sum. */
ASC_INLINE double to_unit(uint32_t high, uint32_t low) {
  const double upper = ((double)(int32_t)(high ^ 0x80000000u) + 0x1p31) * 0x1p-32;
  return upper + (double)(int32_t)(low >> 11) * 0x1p-53;
}

#define QUAD ASC_TILE_COLUMNS

/* The columns [begin, end) of two pairs of dimensions. */
ASC_VECTORISE
static void make_columns(asc_key key, uint32_t quad, uint64_t first, size_t count, uint32_t begin, uint32_t end,
                         double *points, size_t stride) {
  for (size_t done = 0; done < count; done += ASC_LANES) {
    asc_tile tile;
    for (uint32_t d = begin / 2 * 2; d < end; d += 2) {
      asc_lanes bits;
      asc_hash_lanes(key, first + done, (quad * QUAD + d) / 2, ASC_PURPOSE_UNIFORM, &bits);
      ASC_LANES_LOOP
      for (int i = 0; i < ASC_LANES; i++) tile.column[d][i] = to_unit(bits.word[0][i], bits.word[1][i]);
      ASC_LANES_LOOP
      for (int i = 0; i < ASC_LANES; i++) tile.column[d + 1][i] = to_unit(bits.word[2][i], bits.word[3][i]);
    }
    const uint32_t rows = count - done < ASC_LANES ? (uint32_t)(count - done) : ASC_LANES;
    asc_tile_write(&tile, begin, end, 0, rows, points + done * stride, stride);
  }
}

static void make_point(asc_key key, uint32_t quad, uint64_t sample, uint32_t begin, uint32_t end, double *point) {
  for (uint32_t half = begin / 2; 2 * half < end; half++) {
    const asc_block bits = asc_hash(key, sample, quad * QUAD / 2 + half, ASC_PURPOSE_UNIFORM);
    if (2 * half >= begin) *point++ = to_unit(bits.word[0], bits.word[1]);
    if (2 * half + 1 < end) *point++ = to_unit(bits.word[2], bits.word[3]);
  }
}

#define FEW 4 /* samples that are quicker made one by one */

static asc_status random_fill(const void *opaque, const asc_range *range, double *points) {
  const random_state *state = opaque;
  const asc_key key = asc_pixel_key(state->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t low = range->first_dimension, past = low + range->dimension_count;
  const size_t count = range->sample_count, stride = range->dimension_count;
  for (uint32_t q = low / QUAD; q * QUAD < past; q++) {
    const uint32_t begin = q * QUAD < low ? low % QUAD : 0, end = past - q * QUAD < QUAD ? past - q * QUAD : QUAD;
    double *columns = points + (q * QUAD + begin - low);
    if (count > FEW) make_columns(key, q, range->first_sample, count, begin, end, columns, stride);
    for (size_t i = 0; i < count && count <= FEW; i++)
      make_point(key, q, range->first_sample + i, begin, end, columns + i * stride);
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_random = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "random",
    .title = "independent uniform points",
    .source = "Metropolis and Ulam 1949",
    .create = random_create,
    .destroy = free,
    .fill = random_fill,
};

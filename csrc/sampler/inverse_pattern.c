#include "inverse_pattern.h"

#include <stdlib.h>

#include "radical_inverse.h"
#include "tile.h"

struct asc_inverse_pattern {
  uint64_t seed_mix, samples;
  int scramble;
  uint32_t dimensions;
  asc_radix radices[]; /* base 0: i/N */
};

void asc_inverse_pattern_destroy(void *opaque) {
  asc_inverse_pattern *pattern = opaque;
  if (!pattern) return;
  for (uint32_t d = 0; d < pattern->dimensions; d++) free(pattern->radices[d].reversed);
  free(pattern);
}

static uint32_t prime_after(uint32_t n) {
  for (uint32_t candidate = n + 1;; candidate++) {
    uint32_t divisor = 2;
    while (divisor * divisor <= candidate && candidate % divisor) divisor++;
    if (divisor * divisor > candidate) return candidate;
  }
}

asc_status asc_inverse_pattern_make(const asc_sampler_config *config, int scramble, int leading, const char *name,
                                    asc_inverse_pattern **made, asc_error *error) {
  if (config->dimensions > ASC_INVERSE_DIMENSIONS)
    return asc_fail(error, ASC_UNSUPPORTED, "%s has at most %d dimensions", name, ASC_INVERSE_DIMENSIONS);
  asc_inverse_pattern *pattern = calloc(1, sizeof *pattern + config->dimensions * sizeof(asc_radix));
  if (!pattern) return asc_fail(error, ASC_OUT_OF_MEMORY, "%s: out of memory", name);
  pattern->seed_mix = asc_seed_mix(config->seed);
  pattern->samples = config->samples;
  pattern->scramble = scramble;
  pattern->dimensions = config->dimensions;
  for (uint32_t d = leading ? 1 : 0, base = 1; d < config->dimensions; d++) {
    base = prime_after(base);
    if (asc_radix_make(&pattern->radices[d], base)) {
      asc_inverse_pattern_destroy(pattern);
      return asc_fail(error, ASC_OUT_OF_MEMORY, "%s: out of memory", name);
    }
  }
  *made = pattern;
  return ASC_OK;
}

/* --- one value ------------------------------------------------------------------------------------------------------
 */

static double nested_or_shifted(const asc_inverse_pattern *pattern, uint32_t dimension, uint64_t index,
                                asc_digit_key key) {
  const asc_radix *radix = &pattern->radices[dimension];
  const int nested = pattern->scramble == ASC_SCRAMBLE_OWEN;
  if (radix->base)
    return nested ? asc_radical_inverse_nested(radix, index, key) : asc_radical_inverse_shifted(radix, index, key);
  const double x = (double)index / (double)pattern->samples;
  return nested ? asc_binary_nested(x, key) : asc_binary_shifted(x, key);
}

static double plain_value(const asc_inverse_pattern *pattern, uint32_t dimension, uint64_t index) {
  const asc_radix *radix = &pattern->radices[dimension];
  return radix->base ? asc_radical_inverse(radix, index) : (double)index / (double)pattern->samples;
}

static double value_at(const asc_inverse_pattern *pattern, uint32_t dimension, uint64_t index, asc_key key) {
  if (pattern->scramble == ASC_SCRAMBLE_DIGIT || pattern->scramble == ASC_SCRAMBLE_OWEN)
    return nested_or_shifted(pattern, dimension, index, asc_digit_key_of(key, dimension));
  const double x = plain_value(pattern, dimension, index);
  return pattern->scramble == ASC_SCRAMBLE_SHIFT ? asc_rotate(x, asc_rotation(key, dimension)) : x;
}

/* --- many at a time -------------------------------------------------------------------------------------------------
 */

/* Where one dimension is: the index is high x chunk + low; `head` is the radical inverse of `high`, and a value
 * (reversal of low + head) / chunk. */
typedef struct run {
  const asc_radix *radix;
  uint64_t high;
  uint32_t low;
  double head, shift;
} run;

static run begin_run(const asc_inverse_pattern *pattern, uint32_t dimension, uint64_t index, asc_key key) {
  const asc_radix *radix = &pattern->radices[dimension];
  run begun = {radix, 0, 0, 0.0, 0.0};
  if (radix->base) {
    begun.high = asc_radix_rest(radix, index);
    begun.low = (uint32_t)(index - begun.high * radix->chunk);
    begun.head = asc_radical_inverse(radix, begun.high);
  }
  if (pattern->scramble == ASC_SCRAMBLE_SHIFT) begun.shift = asc_rotation(key, dimension);
  return begun;
}

ASC_INLINE void rotate_column(double shift, double column[ASC_LANES]) {
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) column[i] = asc_rotate(column[i], shift);
}

/* The next ASC_LANES values. */
ASC_INLINE void inverse_column(run *at, double column[ASC_LANES]) {
  const asc_radix *radix = at->radix;
  const uint32_t chunk = radix->chunk, low = at->low;
  const int wraps = low + ASC_LANES >= chunk; /* chunks are longer than ASC_LANES: once at most */
  const double head = at->head, next = wraps ? asc_radical_inverse(radix, at->high + 1) : head, divisor = chunk;
  if (radix->reversed) {
    const uint16_t *reversed = radix->reversed + low;
    ASC_LANES_LOOP
    for (uint32_t i = 0; i < ASC_LANES; i++)
      column[i] = ((double)reversed[i] + (low + i < chunk ? head : next)) / divisor;
  } else {
    ASC_LANES_LOOP
    for (uint32_t i = 0; i < ASC_LANES; i++) {
      const double digit = (double)(int32_t)(low + i < chunk ? low + i : low + i - chunk);
      column[i] = (digit + (low + i < chunk ? head : next)) / divisor;
    }
  }
  at->low = wraps ? low + ASC_LANES - chunk : low + ASC_LANES;
  at->high += (uint64_t)wraps;
  at->head = next;
}

ASC_INLINE void leading_column(uint64_t index, uint64_t samples, double column[ASC_LANES]) {
  const double first = (double)index;
  ASC_LANES_LOOP
  for (int i = 0; i < ASC_LANES; i++) column[i] = (first + (double)i) / (double)samples;
}

/* Up to ASC_TILE_COLUMNS dimensions of `count` samples, neither digit nor owen. */
ASC_VECTORISE
static void fill_columns(const asc_inverse_pattern *pattern, run runs[ASC_TILE_COLUMNS], uint32_t columns,
                         uint64_t first, size_t count, double *points, size_t stride) {
  for (size_t done = 0; done < count; done += ASC_LANES) {
    asc_tile tile;
    for (uint32_t c = 0; c < columns; c++) {
      if (runs[c].radix->base)
        inverse_column(&runs[c], tile.column[c]);
      else
        leading_column(first + done, pattern->samples, tile.column[c]);
      if (pattern->scramble == ASC_SCRAMBLE_SHIFT) rotate_column(runs[c].shift, tile.column[c]);
    }
    const uint32_t rows = count - done < ASC_LANES ? (uint32_t)(count - done) : ASC_LANES;
    asc_tile_write(&tile, 0, columns, 0, rows, points + done * stride, stride);
  }
}

#define FEW 4 /* samples that are quicker made one by one */

ASC_APART asc_status fill_range(const asc_inverse_pattern *pattern, const asc_range *range, double *points) {
  const asc_key key = asc_pixel_key(pattern->seed_mix, range->pixel_x, range->pixel_y);
  const uint32_t begin = range->first_dimension, stride = range->dimension_count;
  const int digits = pattern->scramble == ASC_SCRAMBLE_DIGIT || pattern->scramble == ASC_SCRAMBLE_OWEN;
  if (range->sample_count <= FEW) {
    for (uint32_t i = 0; i < range->sample_count; i++)
      for (uint32_t d = 0; d < stride; d++) *points++ = value_at(pattern, begin + d, range->first_sample + i, key);
    return ASC_OK;
  }
  if (digits) {
    for (uint32_t d = 0; d < stride; d++) {
      const asc_digit_key random = asc_digit_key_of(key, begin + d);
      for (size_t i = 0; i < range->sample_count; i++)
        points[i * stride + d] = nested_or_shifted(pattern, begin + d, range->first_sample + i, random);
    }
    return ASC_OK;
  }
  for (uint32_t d = 0; d < stride; d += ASC_TILE_COLUMNS) {
    const uint32_t columns = stride - d < ASC_TILE_COLUMNS ? stride - d : ASC_TILE_COLUMNS;
    run runs[ASC_TILE_COLUMNS];
    for (uint32_t c = 0; c < columns; c++) runs[c] = begin_run(pattern, begin + d + c, range->first_sample, key);
    fill_columns(pattern, runs, columns, range->first_sample, range->sample_count, points + d, stride);
  }
  return ASC_OK;
}

asc_status asc_inverse_pattern_fill(const void *opaque, const asc_range *range, double *points) {
  const asc_inverse_pattern *pattern = opaque;
  if (range->sample_count != 1 || pattern->scramble != ASC_SCRAMBLE_NONE) return fill_range(pattern, range, points);
  const uint64_t index = range->first_sample;
  for (uint32_t d = 0; d < range->dimension_count; d++)
    points[d] = plain_value(pattern, range->first_dimension + d, index);
  return ASC_OK;
}

#include "radical_inverse.h"

#include <stdlib.h>

#include "owen.h"
#include "permutation.h"

#define LARGEST_CHUNK 1024
#define MOST_CHUNKS 54 /* of an index below 2^53 */

asc_status asc_radix_make(asc_radix *made, uint32_t base) {
  *made = (asc_radix){.base = base, .chunk = base, .digits = 1};
  while (made->chunk <= LARGEST_CHUNK / base) {
    made->chunk *= base;
    made->digits++;
  }
  /* Granlund and Montgomery 1994, "Division by invariant integers using multiplication": the magic numbers exceed
   * 2^(64 + shift) / chunk and 2^32 / base by less than 1, which changes no quotient as long as numerator times
   * denominator, at most 2^53 2^13 and 2^13 2^13, is below that power of two. */
  while ((uint64_t)2 << made->shift < made->chunk) made->shift++;
  made->magic = (uint64_t)((((asc_uint128)1 << (64 + made->shift)) - 1) / made->chunk) + 1;
  made->per_base = UINT32_MAX / base + 1;
  if (made->chunk > LARGEST_CHUNK) return ASC_OK;
  made->reversed = malloc((made->chunk + ASC_LANES) * sizeof *made->reversed);
  if (!made->reversed) return ASC_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < made->chunk + ASC_LANES; i++) {
    uint32_t reversed = 0, rest = i % made->chunk;
    for (uint32_t k = 0; k < made->digits; k++, rest /= base) reversed = reversed * base + rest % base;
    made->reversed[i] = (uint16_t)reversed;
  }
  return ASC_OK;
}

/* (...((rest + chunks[count - 1]) / chunk + chunks[count - 2]) / chunk + ... + chunks[0]) / chunk */
ASC_INLINE double horner(const asc_radix *radix, const uint32_t *chunks, int count, double rest) {
  while (count) rest = (rest + (double)chunks[--count]) / radix->chunk;
  return rest;
}

double asc_radical_inverse(const asc_radix *radix, uint64_t index) {
  uint32_t chunks[MOST_CHUNKS];
  int count = 0;
  while (index) {
    const uint64_t rest = asc_radix_rest(radix, index);
    const uint32_t digits = (uint32_t)(index - rest * radix->chunk);
    chunks[count++] = radix->reversed ? radix->reversed[digits] : digits;
    index = rest;
  }
  return horner(radix, chunks, count, 0.0);
}

/* --- scrambling -----------------------------------------------------------------------------------------------------
 */

/* The next digit of a fraction of 64 bits, which loses it. */
ASC_INLINE uint32_t next_digit(uint64_t *fraction, uint32_t base) {
  const asc_uint128 product = (asc_uint128)*fraction * base;
  *fraction = (uint64_t)product;
  return (uint32_t)(product >> 64);
}

static double to_unit(uint64_t fraction) { return (double)(fraction >> 11) * 0x1p-53; }

static double below_one(double x) { return x < 1.0 ? x : 1.0 - 0x1p-53; }

static uint64_t reverse64(uint64_t x) {
  return ((uint64_t)asc_reverse_bits((uint32_t)x) << 32) | asc_reverse_bits((uint32_t)(x >> 32));
}

double asc_radical_inverse_shifted(const asc_radix *radix, uint64_t index, asc_digit_key key) {
  if (radix->base == 2) return to_unit(reverse64(index) ^ key.word[0]);
  /* The random digits are those of a random number, so past the index's last digit its rest is the result's. */
  uint64_t random = key.word[0];
  uint32_t chunks[MOST_CHUNKS];
  int count = 0;
  while (index) {
    const uint64_t rest = asc_radix_rest(radix, index);
    uint32_t digits = (uint32_t)(index - rest * radix->chunk), chunk = 0;
    for (uint32_t k = 0; k < radix->digits; k++) {
      const uint32_t above = asc_digit_rest(radix, digits);
      const uint32_t sum = digits - above * radix->base + next_digit(&random, radix->base);
      digits = above;
      chunk = chunk * radix->base + (sum < radix->base ? sum : sum - radix->base);
    }
    chunks[count++] = chunk;
    index = rest;
  }
  return below_one(horner(radix, chunks, count, to_unit(random)));
}

double asc_binary_shifted(double x, asc_digit_key key) { return to_unit(((uint64_t)(x * 0x1p53) << 11) ^ key.word[0]); }

/* In base 2 by the hash of owen.h in two steps of 32 bits: the lower are scrambled by a key that is hashed from the
 * upper ones. Bits are given leading one lowest. */
static double nested_binary(uint32_t upper, uint32_t lower, asc_digit_key key) {
  const uint32_t high = asc_owen_hash(upper, key.word[0]);
  const uint32_t low = asc_owen_hash(lower, asc_mix64(key.word[1] + upper * ASC_GOLDEN));
  return to_unit(((uint64_t)high << 32) | low);
}

double asc_binary_nested(double x, asc_digit_key key) {
  const uint64_t bits = reverse64((uint64_t)(x * 0x1p53) << 11);
  return nested_binary((uint32_t)bits, (uint32_t)(bits >> 32), key);
}

/* Where a random permutation of 0 ... size-1 takes an element: Fisher and Yates's exchanges, of which only those that
 * meet the element count. The draws come from one random number as long as their bounds' product stays below 2^32.
 * `bits`: 64 random ones. */
static uint32_t permuted(uint32_t element, uint32_t size, uint64_t bits) {
  if (size > ASC_PERMUTATION_TABLE) {
    asc_permutation permutation;
    asc_permutation_key(&permutation, size, bits, asc_mix64(bits + ASC_GOLDEN));
    return (uint32_t)asc_permutation_at(&permutation, element);
  }
  uint64_t fraction = bits, bounds = 1;
  for (uint32_t last = size - 1; last > 0; last--) {
    bounds *= last + 1;
    if (bounds > UINT32_MAX) {
      fraction = bits = asc_mix64(bits + ASC_GOLDEN);
      bounds = last + 1;
    }
    const uint32_t other = next_digit(&fraction, last + 1);
    const uint32_t met = element == other ? last : element; /* no branches: they could not be predicted */
    element = element == last ? other : met;
  }
  return element;
}

/* The image of zero under the permutations that follow a prefix is a digit of one random number for that prefix, as
 * long as zeros follow: most of what is to be drawn is drawn at once. A digit that is not zero goes to one of the other
 * base - 1 images by a permutation of its own, and begins a new prefix. So the work is that of the digits that the
 * index has, yet all 53 bits are scrambled. */
double asc_radical_inverse_nested(const asc_radix *radix, uint64_t index, asc_digit_key key) {
  if (radix->base == 2) return nested_binary((uint32_t)index, (uint32_t)(index >> 32), key);
  const uint32_t base = radix->base;
  uint64_t prefix = 0, place = 1, zeros = asc_mix64(key.word[0]);
  uint32_t chunks[MOST_CHUNKS];
  int count = 0;
  for (uint64_t level = 0; index;) {
    const uint64_t rest = asc_radix_rest(radix, index);
    uint32_t digits = (uint32_t)(index - rest * radix->chunk), chunk = 0;
    for (uint32_t k = 0; k < radix->digits; k++, level++, place *= base) {
      const uint32_t above = asc_digit_rest(radix, digits), digit = digits - above * base;
      digits = above;
      uint32_t image = next_digit(&zeros, base);
      if (digit) {
        const uint64_t node = (prefix | (level << 53)) * ASC_GOLDEN; /* prefixes lie below 2^53, levels below 2^6 */
        image += 1 + permuted(digit - 1, base - 1, asc_mix64(key.word[1] + node));
        image = image < base ? image : image - base;
        prefix += digit * place;
        zeros = asc_mix64(key.word[0] + prefix * ASC_GOLDEN);
      }
      chunk = chunk * base + image;
    }
    chunks[count++] = chunk;
    index = rest;
  }
  return below_one(horner(radix, chunks, count, to_unit(zeros)));
}

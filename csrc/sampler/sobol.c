/* Sobol's sequence in base 2, natural order, index 0 kept.
 *
 * Source: Sobol 1967; directions of Joe and Kuo 2008, "Constructing Sobol sequences with better two-dimensional
 * projections" (new-joe-kuo-6). scramble:
 *   shift   each dimension of each pixel moved modulo 1 (Cranley and Patterson 1976)
 *   digit   a random digital shift: the same 32 random bits XOR-ed to all points of a dimension and pixel
 *   owen    nested uniform scrambling (Owen 1995), by a hash in which each bit flips by a function of the bits above it
 *           and of the seed: Laine and Karras 2011, "Stratified sampling for stochastic transparency", with Vegdahl's
 *           constants (2021, "Building a better LK hash"). Any such hash keeps nets nets; the tests hold that.
 * Values have 32 bits: they are multiples of 2^-32 (but for shift). */
#include <stdlib.h>
#include <string.h>

#include "pattern.h"
#include "sobol_directions.h"
#include "vectorise.h"

#define BITS 32

enum { SCRAMBLE_NONE, SCRAMBLE_SHIFT, SCRAMBLE_DIGIT, SCRAMBLE_OWEN };

/* Points are made ASC_LANES = 16 at a time: `low` are the XORs of the directions of the 16 values of an index's lowest
 * four bits, `direction` those of single bits. */
typedef struct axis {
  uint32_t direction[BITS];
  uint32_t low[ASC_LANES];
} axis;

typedef struct sobol_state {
  uint64_t seed;
  int scramble;
  uint32_t dimensions;
  axis axes[];
} sobol_state;

/* Bratley and Fox 1988, Algorithm 659: m_k = 2 a_1 m_(k-1) ^ ... ^ 2^(s-1) a_(s-1) m_(k-s+1) ^ 2^s m_(k-s) ^ m_(k-s) */
static void make_directions(uint32_t dimension, uint32_t direction[BITS]) {
  if (dimension == 0) {
    for (uint32_t k = 0; k < BITS; k++) direction[k] = 1u << (BITS - 1 - k);
    return;
  }
  const asc_sobol_polynomial *polynomial = &asc_sobol_polynomials[dimension];
  const uint32_t degree = polynomial->degree;
  const uint32_t *initial = asc_sobol_initial + polynomial->first;
  for (uint32_t k = 0; k < BITS; k++) {
    if (k < degree) {
      direction[k] = initial[k] << (BITS - 1 - k);
      continue;
    }
    uint32_t v = direction[k - degree] ^ (direction[k - degree] >> degree);
    for (uint32_t j = 1; j < degree; j++)
      if ((polynomial->coefficients >> (degree - 1 - j)) & 1u) v ^= direction[k - j];
    direction[k] = v;
  }
}

static asc_status sobol_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions > ASC_SOBOL_DIMENSIONS)
    return asc_fail(error, ASC_UNSUPPORTED, "sobol has at most %d dimensions", ASC_SOBOL_DIMENSIONS);
  if (config->samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "sobol has 32 bits, so at most 2^32 points");
  sobol_state *state = malloc(sizeof *state + config->dimensions * sizeof(axis));
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "sobol: out of memory");
  state->seed = config->seed;
  state->scramble = (int)config->values[0];
  state->dimensions = config->dimensions;
  for (uint32_t d = 0; d < config->dimensions; d++) {
    axis *along = &state->axes[d];
    make_directions(d, along->direction);
    memset(along->low, 0, sizeof along->low);
    for (uint32_t i = 0; i < ASC_LANES; i++)
      for (uint32_t bit = 0; bit < 4; bit++)
        if ((i >> bit) & 1u) along->low[i] ^= along->direction[bit];
  }
  const uint32_t randomised = state->scramble == SCRAMBLE_NONE ? 0 : ASC_TRAIT_RANDOMISED;
  *made = (asc_sampler_state){state, ASC_TRAIT_SEQUENCE | randomised, ASC_NET_END};
  return ASC_OK;
}

static inline uint32_t reverse_bits(uint32_t x) {
  x = (x >> 16) | (x << 16);
  x = ((x & 0xff00ff00u) >> 8) | ((x & 0x00ff00ffu) << 8);
  x = ((x & 0xf0f0f0f0u) >> 4) | ((x & 0x0f0f0f0fu) << 4);
  x = ((x & 0xccccccccu) >> 2) | ((x & 0x33333333u) << 2);
  return ((x & 0xaaaaaaaau) >> 1) | ((x & 0x55555555u) << 1);
}

/* In the reversed word, multiplications and additions carry upward only: from the leading digits to those below. */
static inline uint32_t owen_hash(uint32_t x, uint32_t seed) {
  x = reverse_bits(x);
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1u;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return reverse_bits(x);
}

/* The 16 values of indices 16 block ... 16 block + 15, scrambled by XOR or hash, as doubles. */
ASC_VECTORISE
static void make_block(const axis *along, uint32_t block, int scramble, uint32_t bits, double values[ASC_LANES]) {
  uint32_t base = 0;
  for (uint32_t rest = block, bit = 4; rest; rest >>= 1, bit++)
    if (rest & 1u) base ^= along->direction[bit];
  if (scramble == SCRAMBLE_DIGIT) base ^= bits;
  if (scramble == SCRAMBLE_OWEN)
    for (int i = 0; i < ASC_LANES; i++) values[i] = (double)owen_hash(base ^ along->low[i], bits) * 0x1p-32;
  else
    for (int i = 0; i < ASC_LANES; i++) values[i] = (double)(base ^ along->low[i]) * 0x1p-32;
}

static asc_status sobol_fill(const void *opaque, const asc_range *range, double *points) {
  const sobol_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  const uint64_t first = range->first_sample, end = first + range->sample_count;
  for (uint32_t d = 0; d < range->dimension_count; d++) {
    const uint32_t dimension = range->first_dimension + d;
    const int shifted = state->scramble == SCRAMBLE_SHIFT;
    const double shift = shifted ? asc_rotation(key, dimension) : 0.0;
    const int hashed = state->scramble == SCRAMBLE_DIGIT || state->scramble == SCRAMBLE_OWEN;
    const uint32_t bits = hashed ? asc_hash(key, 0, dimension, ASC_PURPOSE_SCRAMBLE).word[0] : 0;
    for (uint64_t block = first / ASC_LANES; block * ASC_LANES < end; block++) {
      double values[ASC_LANES];
      make_block(&state->axes[dimension], (uint32_t)block, state->scramble, bits, values);
      const uint64_t begins = block * ASC_LANES;
      const uint32_t from = begins < first ? (uint32_t)(first - begins) : 0;
      const uint32_t to = end - begins < ASC_LANES ? (uint32_t)(end - begins) : ASC_LANES;
      for (uint32_t i = from; i < to; i++)
        points[(begins + i - first) * range->dimension_count + d] = shifted ? asc_rotate(values[i], shift) : values[i];
    }
  }
  return ASC_OK;
}

static const asc_parameter sobol_parameters[] = {
    {"scramble", ASC_CHOICE, "none|shift|digit|owen", 0, 0, SCRAMBLE_NONE,
     "none, a random shift modulo 1, a random digital shift, or Owen's nested uniform scrambling"},
};

const asc_sampler_interface asc_sampler_sobol = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "sobol",
    .title = "Sobol's sequence, Joe and Kuo's directions",
    .source = "Sobol 1967; Joe and Kuo 2008; Owen 1995; Laine and Karras 2011",
    .parameters = sobol_parameters,
    .parameter_count = 1,
    .create = sobol_create,
    .destroy = free,
    .fill = sobol_fill,
};

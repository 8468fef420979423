/* Randomised orthogonal arrays: N = s^t points, s a prime power, of which any t dimensions together have one point in
 * each of s x ... x s cells. t is the strength, 2 or 3; up to s + 1 dimensions; N up to 2^32.
 *
 * Array: Bush 1952, "Orthogonal arrays of index unity", theorem 1; of strength 2 it is that of Bose 1938, "On the
 * application of the properties of Galois fields to the problem of construction of hyper-Graeco-Latin squares". Sample
 * i has the polynomial over the field of s elements whose t coefficients are the digits of i in base s; dimension j has
 * its value at element j, dimension s its leading coefficient: t of these tell the polynomial, so all cells are hit.
 * The symbols of each dimension are permuted at random (Owen 1992, "Orthogonal arrays for computer experiments,
 * integration and visualization"). The s samples from each multiple of s on have each symbol of the first s dimensions
 * once.
 *
 * jitter= says where in its cell a point lies (Jarosz et al. 2019, "Orthogonal array sampling for Monte Carlo
 * rendering", section 4):
 *   jittered         anywhere
 *   multi-jittered   the N / s points of a stratum of one dimension take its N / s sub-strata in random order, so that
 *                    each dimension has one point in each of N strata (Tang 1993, "Orthogonal array-based Latin
 *                    hypercubes")
 *   correlated       the same, with one order for all strata of a dimension, in terms of the symbols of other
 *                    dimensions: of strength 2, each pair (0,1), (2,3), ... is a correlated multi-jittered pattern */
#include <stdio.h>
#include <stdlib.h>

#include "cell.h"
#include "galois.h"
#include "pattern.h"
#include "permutation_family.h"

#define MOST_STRENGTH 3

enum { JITTERED, MULTI_JITTERED, CORRELATED };

typedef struct array_state {
  uint64_t samples, seed;
  uint32_t strength, side; /* s */
  uint64_t substrata;      /* N / s */
  int jitter;
  asc_galois field;
} array_state;

static void array_destroy(void *opaque) {
  array_state *state = opaque;
  if (!state) return;
  asc_galois_free(&state->field);
  free(state);
}

static uint64_t power_of(uint64_t side, uint32_t strength) { return strength == 2 ? side * side : side * side * side; }

/* Whether side^strength points make an array of so many dimensions; a single point makes any. */
static int has_array(uint64_t side, uint32_t strength, uint32_t dimensions) {
  uint32_t prime, power;
  if (side == 1) return 1;
  return power_of(side, strength) <= ASC_NET_END && dimensions <= side + 1 &&
         asc_is_prime_power((uint32_t)side, &prime, &power);
}

/* Says which counts next to the one asked for there are. */
static asc_status refuse(const asc_sampler_config *config, uint32_t strength, asc_error *error) {
  const unsigned long long asked = config->samples;
  uint64_t below = strength == 2 ? 1u << 16 : 1625; /* the roots of 2^32 */
  uint64_t above = 1;
  while (below > 1 && (power_of(below, strength) > asked || !has_array(below, strength, config->dimensions))) below--;
  while (above <= ASC_GALOIS_MOST &&
         (power_of(above, strength) < asked || !has_array(above, strength, config->dimensions)))
    above++;
  const unsigned long long low = power_of(below, strength), high = power_of(above, strength);
  char choice[64];
  if (above > ASC_GALOIS_MOST)
    (void)snprintf(choice, sizeof choice, "%llu", low);
  else if (below == 1)
    (void)snprintf(choice, sizeof choice, "%llu", high);
  else
    (void)snprintf(choice, sizeof choice, "%llu or %llu", low, high);
  return asc_fail(
      error, ASC_UNSUPPORTED,
      "orthogonal-array has s^%u points, s a prime power, at most 2^32 points and s + 1 dimensions; %llu in "
      "%u dimensions is not so: choose %s",
      strength, asked, config->dimensions, choice);
}

static asc_status array_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const uint32_t strength = (uint32_t)config->values[1];
  const uint64_t side = asc_exact_root(config->samples, strength);
  if (side == 0 || !has_array(side, strength, config->dimensions)) return refuse(config, strength, error);
  array_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "orthogonal-array: out of memory");
  *state = (array_state){.samples = config->samples,
                         .seed = config->seed,
                         .strength = strength,
                         .side = (uint32_t)side,
                         .substrata = config->samples / side,
                         .jitter = (int)config->values[0]};
  if (asc_galois_make(&state->field, (uint32_t)side)) {
    free(state);
    return asc_fail(error, ASC_OUT_OF_MEMORY, "orthogonal-array: out of memory");
  }
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

/* A polynomial by its coefficients, the constant first. */
typedef struct polynomial {
  uint32_t coefficient[MOST_STRENGTH];
} polynomial;

static polynomial polynomial_of(const array_state *state, uint64_t sample) {
  polynomial of = {{0}};
  for (uint32_t k = 0; k < state->strength; k++, sample /= state->side)
    of.coefficient[k] = (uint32_t)(sample % state->side);
  return of;
}

/* The array's symbol of one dimension. */
static uint32_t symbol_of(const array_state *state, const polynomial *of, uint32_t dimension) {
  uint32_t value = of->coefficient[state->strength - 1];
  if (dimension >= state->side) return value;
  for (uint32_t k = state->strength - 1; k > 0; k--)
    value = asc_galois_add(&state->field, asc_galois_multiply(&state->field, value, dimension), of->coefficient[k - 1]);
  return value;
}

/* The dimensions whose symbols number the points of a stratum: the partner in the pair, and of strength 3 the last or,
 * where that is taken, the first that is free. All lie within the array's s + 1 dimensions. */
static void numbering_dimensions(const array_state *state, uint32_t dimension, uint32_t by[2]) {
  const uint32_t last = state->side;
  by[0] = (dimension ^ 1u) <= last ? dimension ^ 1u : 0;
  by[1] = last;
  if (dimension != last && by[0] != last) return;
  by[1] = 0;
  while (by[1] == dimension || by[1] == by[0]) by[1]++;
}

static uint64_t number_in_stratum(const array_state *state, const polynomial *of, const uint32_t by[2]) {
  const uint64_t first = symbol_of(state, of, by[0]);
  return state->strength == 2 ? first : first * state->side + symbol_of(state, of, by[1]);
}

static void fill_dimension(const array_state *state, const asc_range *range, asc_key key, uint32_t dimension,
                           double *points) {
  asc_permutation symbols;
  asc_permutation_family substrata;
  uint32_t by[2];
  asc_permutation_make(&symbols, state->side, key, dimension);
  asc_permutation_family_begin(&substrata, state->substrata, key, dimension);
  numbering_dimensions(state, dimension, by);
  for (size_t done = 0; done < range->sample_count; done += ASC_LANES) {
    asc_lanes bits;
    const size_t left = range->sample_count - done, count = left < ASC_LANES ? left : ASC_LANES;
    asc_cell_bits(key, range->first_sample + done, count, dimension, &bits);
    for (size_t i = 0; i < count; i++) {
      const polynomial of = polynomial_of(state, range->first_sample + done + i);
      const uint32_t symbol = symbol_of(state, &of, dimension);
      const uint64_t stratum = asc_permutation_at(&symbols, symbol);
      double *value = points + (done + i) * range->dimension_count + (dimension - range->first_dimension);
      if (state->jitter == JITTERED) {
        *value = asc_in_cell(stratum, state->side, bits.word[0][i]);
        continue;
      }
      const uint64_t substratum = asc_permutation_family_at(&substrata, state->jitter == CORRELATED ? 0 : symbol,
                                                            number_in_stratum(state, &of, by));
      *value = asc_in_cell(stratum * state->substrata + substratum, state->samples, bits.word[0][i]);
    }
  }
}

static asc_status array_fill(const void *opaque, const asc_range *range, double *points) {
  const array_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  for (uint32_t d = 0; d < range->dimension_count; d++)
    fill_dimension(state, range, key, range->first_dimension + d, points);
  return ASC_OK;
}

static const asc_parameter array_parameters[] = {
    {"jitter", ASC_CHOICE, "jittered|multi-jittered|correlated", 0, 0, MULTI_JITTERED,
     "in the cell: anywhere, one point in each of N strata a dimension, or so with one order for all"},
    {"strength", ASC_INTEGER, NULL, 2, MOST_STRENGTH, 2, "how many dimensions together are stratified"},
};

const asc_sampler_interface asc_sampler_orthogonal_array = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "orthogonal-array",
    .title = "any two or three dimensions together stratified",
    .source = "Bose 1938; Bush 1952; Owen 1992; Tang 1993; Jarosz et al. 2019",
    .parameters = array_parameters,
    .parameter_count = 2,
    .create = array_create,
    .destroy = array_destroy,
    .fill = array_fill,
};

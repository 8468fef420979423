/* Zaremba's points: (i/N, sum over j of ((a_j + j) mod 2) 2^-(j+1)), a_j the j-th binary digit of i, least first: the
 * radical inverse with every second digit turned.
 *
 * Source: Halton and Zaremba 1969, "The extreme and L2 discrepancies of some plane sets", after Zaremba 1968, "Some
 * applications of multidimensional integration by parts". digits:
 *   all     the sum is infinite. From an even j = m on, with all a_j = 0, what is left is 2^-m (1/4 + 1/16 + ...) =
 *           2^-m / 3, so y = (3 h + 1) / (3 * 2^m), h the first m digits as an integer. In double it is rounded once
 *           for N up to 2^50, with m = 50; above m = 54, and it lies within 1 ulp.
 *   finite  the sum stops at j = ceil(log2 N) - 1. Exact. */
#include <stdlib.h>

#include "lanes.h"
#include "vectorise.h"

enum { DIGITS_ALL, DIGITS_FINITE };

/* y = (scale * h + tail) / divisor, h the leading 64 - shift of 64 digits. */
typedef struct zaremba_state {
  double samples, divisor;
  uint64_t scale, tail;
  uint32_t shift;
} zaremba_state;

static asc_status zaremba_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  if (config->dimensions != 2)
    return asc_fail(error, ASC_UNSUPPORTED, "zaremba has two dimensions, not %u", config->dimensions);
  zaremba_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "zaremba: out of memory");
  uint32_t digits = 1; /* of N = 1 the one digit is 0 */
  while (((uint64_t)1 << digits) < config->samples) digits++;
  const int all = (int)config->values[0] == DIGITS_ALL;
  if (all) digits = digits <= 50 ? 50 : 54;
  const double denominator = (double)((uint64_t)1 << digits);
  *state = (zaremba_state){(double)config->samples, all ? 3.0 * denominator : denominator, all ? 3 : 1, all ? 1 : 0,
                           64 - digits};
  *made = (asc_sampler_state){state, 0, config->samples};
  return ASC_OK;
}

/* The digits of 16 block, 16 block + 1, ...: they differ in the four leading ones. */
ASC_VECTORISE
static void make_run(const zaremba_state *state, uint64_t begin, double x[ASC_LANES], double y[ASC_LANES]) {
  static const uint64_t reversed[ASC_LANES] = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  const uint64_t base = ((uint64_t)asc_reverse_bits((uint32_t)begin) << 32) | asc_reverse_bits((uint32_t)(begin >> 32));
  const uint64_t turned = base ^ 0x5555555555555555u;
  for (uint64_t i = 0; i < ASC_LANES; i++) {
    const uint64_t leading = (turned ^ reversed[i] << 60) >> state->shift;
    x[i] = (double)(begin + i) / state->samples;
    y[i] = (double)(state->scale * leading + state->tail) / state->divisor;
  }
}

static asc_status zaremba_fill(const void *opaque, const asc_range *range, double *points) {
  const uint64_t end = range->first_sample + range->sample_count;
  for (uint64_t begin = asc_first_run(range); begin < end; begin += ASC_LANES) {
    const asc_run run = asc_run_at(range, begin);
    double values[2][ASC_LANES];
    make_run(opaque, begin, values[0], values[1]);
    for (uint32_t d = 0; d < range->dimension_count; d++)
      asc_write_run(range, run, range->first_dimension + d, values[range->first_dimension + d], points);
  }
  return ASC_OK;
}

static const asc_parameter zaremba_parameters[] = {
    {"digits", ASC_CHOICE, "all|finite", 0, 0, DIGITS_ALL, "the infinite sum, or the first ceil(log2 N) terms"},
};

const asc_sampler_interface asc_sampler_zaremba = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "zaremba",
    .title = "Zaremba's points, every second digit turned",
    .source = "Zaremba 1968; Halton and Zaremba 1969",
    .parameters = zaremba_parameters,
    .parameter_count = 1,
    .create = zaremba_create,
    .destroy = free,
    .fill = zaremba_fill,
};

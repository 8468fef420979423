/* Larcher and Pillichshammer's net: (i/N, y), where the digit k of i, least first, turns the leading k + 1 binary
 * digits of y. Of N = 2^m points it is a (0, m, 2)-net in base 2.
 *
 * Source: Larcher and Pillichshammer 2001, "Walsh series analysis of the L2-discrepancy of symmetrisized point sets";
 * as code in Kollig and Keller 2002, "Efficient multidimensional sampling". Digit k + 1 of y is the parity of the
 * binary digits of i from k on; so y is the inverse of Gray's code, reversed. Values of y have 32 bits. */
#include <stdlib.h>

#include "lanes.h"
#include "vectorise.h"

typedef struct larcher_pillichshammer_state {
  double samples;
} larcher_pillichshammer_state;

static asc_status larcher_pillichshammer_create(const asc_sampler_config *config, asc_sampler_state *made,
                                                asc_error *error) {
  if (config->dimensions != 2)
    return asc_fail(error, ASC_UNSUPPORTED, "larcher-pillichshammer has two dimensions, not %u", config->dimensions);
  if (config->samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "larcher-pillichshammer has 32 bits, so at most 2^32 points");
  larcher_pillichshammer_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "larcher-pillichshammer: out of memory");
  state->samples = (double)config->samples;
  *made = (asc_sampler_state){state, 0, config->samples};
  return ASC_OK;
}

static inline uint32_t y_digits(uint32_t index) {
  for (uint32_t step = 1; step < 32; step *= 2) index ^= index >> step;
  return asc_reverse_bits(index);
}

/* The indices begin ... begin + 15, `begin` a multiple of 16: y is linear, so they differ by the y of 0 ... 15. */
ASC_VECTORISE
static void make_run(const larcher_pillichshammer_state *state, uint32_t begin, double x[ASC_LANES],
                     double y[ASC_LANES]) {
  static const uint32_t lowest[ASC_LANES] = {0, 8, 12, 4, 14, 6, 2, 10, 15, 7, 3, 11, 1, 9, 13, 5};
  const uint32_t above = y_digits(begin);
  for (uint32_t i = 0; i < ASC_LANES; i++) {
    x[i] = (double)(begin + i) / state->samples;
    y[i] = (double)(above ^ lowest[i] << 28) * 0x1p-32;
  }
}

static asc_status larcher_pillichshammer_fill(const void *opaque, const asc_range *range, double *points) {
  const uint64_t end = range->first_sample + range->sample_count;
  for (uint64_t begin = asc_first_run(range); begin < end; begin += ASC_LANES) {
    const asc_run run = asc_run_at(range, begin);
    double values[2][ASC_LANES];
    make_run(opaque, (uint32_t)begin, values[0], values[1]);
    for (uint32_t d = 0; d < range->dimension_count; d++)
      asc_write_run(range, run, range->first_dimension + d, values[range->first_dimension + d], points);
  }
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_larcher_pillichshammer = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "larcher-pillichshammer",
    .title = "Larcher and Pillichshammer's net",
    .source = "Larcher and Pillichshammer 2001; Kollig and Keller 2002",
    .create = larcher_pillichshammer_create,
    .destroy = free,
    .fill = larcher_pillichshammer_fill,
};

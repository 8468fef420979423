/* Halton's sequence: (phi_2(i), phi_3(i), phi_5(i), ...), phi_b the radical inverse in base b, index 0 kept.
 *
 * Source: Halton 1960, "On the efficiency of certain quasi-random sequences of points in evaluating multi-dimensional
 * integrals". scramble, each dimension of each pixel by itself:
 *   shift   moved modulo 1 (Cranley and Patterson 1976)
 *   digit   a random digital shift: to each digit a random digit is added modulo the base
 *   owen    nested uniform scrambling in the dimension's base (Owen 1995) */
#include "inverse_pattern.h"

static asc_status halton_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const int scramble = (int)config->values[0];
  asc_inverse_pattern *pattern;
  const asc_status status = asc_inverse_pattern_make(config, scramble, 0, "halton", &pattern, error);
  if (status) return status;
  const uint32_t randomised = scramble == ASC_SCRAMBLE_NONE ? 0 : ASC_TRAIT_RANDOMISED;
  *made = (asc_sampler_state){pattern, ASC_TRAIT_SEQUENCE | randomised, ASC_SEQUENCE_END};
  return ASC_OK;
}

static const asc_parameter halton_parameters[] = {
    {"scramble", ASC_CHOICE, ASC_SCRAMBLES, 0, 0, ASC_SCRAMBLE_NONE,
     "none, a random shift modulo 1, a random digital shift, or Owen's nested uniform scrambling"},
};

const asc_sampler_interface asc_sampler_halton = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "halton",
    .title = "Halton's sequence, radical inverses in the primes",
    .source = "Halton 1960; Owen 1995",
    .parameters = halton_parameters,
    .parameter_count = 1,
    .create = halton_create,
    .destroy = asc_inverse_pattern_destroy,
    .fill = asc_inverse_pattern_fill,
};

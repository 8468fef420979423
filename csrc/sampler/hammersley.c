/* Hammersley's points: (i/N, phi_2(i), phi_3(i), phi_5(i), ...), phi_b the radical inverse in base b, i from 0.
 *
 * Source: Hammersley 1960, "Monte Carlo methods for solving multivariable problems". scramble, each dimension of each
 * pixel by itself:
 *   shift   moved modulo 1 (Cranley and Patterson 1976)
 *   digit   a random digital shift: to each digit a random digit is added modulo the base
 *   owen    nested uniform scrambling in the dimension's base (Owen 1995)
 * The base of i/N is 2 for digit and owen: then N = 2^m points stay a (0, m, 2)-net in the first two dimensions, as
 * they are without. (In base N, where i/N is a single digit, owen would draw its order at random and the net were
 * lost.) */
#include "inverse_pattern.h"

static asc_status hammersley_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const int scramble = (int)config->values[0];
  asc_inverse_pattern *pattern;
  const asc_status status = asc_inverse_pattern_make(config, scramble, 1, "hammersley", &pattern, error);
  if (status) return status;
  *made = (asc_sampler_state){pattern, scramble == ASC_SCRAMBLE_NONE ? 0 : ASC_TRAIT_RANDOMISED, config->samples};
  return ASC_OK;
}

static const asc_parameter hammersley_parameters[] = {
    {"scramble", ASC_CHOICE, ASC_SCRAMBLES, 0, 0, ASC_SCRAMBLE_NONE,
     "none, a random shift modulo 1, a random digital shift, or Owen's nested uniform scrambling"},
};

const asc_sampler_interface asc_sampler_hammersley = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "hammersley",
    .title = "Hammersley's points, i/N and radical inverses in the primes",
    .source = "Hammersley 1960; Owen 1995",
    .parameters = hammersley_parameters,
    .parameter_count = 1,
    .create = hammersley_create,
    .destroy = asc_inverse_pattern_destroy,
    .fill = asc_inverse_pattern_fill,
};

/* What the files of filters share. Each filter is one file that defines one asc_filter_interface; registry.c lists
 * them, normalises them and makes them even. */
#ifndef ASC_PROFILE_H
#define ASC_PROFILE_H

#include "aliascope/filter.h"

#define ASC_FILTER_INTERFACE_ID "asc.filter/1"

/* Like asc_sampler_interface: fields are only ever appended, strings and tables live in static storage, and every
 * function is pure and may be called from many threads at once. `values` has one entry a parameter, in the table's
 * order, within the ranges that it states. */
typedef struct asc_filter_interface {
  size_t struct_size;
  const char *name;   /* kebab-case */
  const char *title;  /* a few words */
  const char *source; /* the publication */
  const asc_parameter *parameters;
  size_t parameter_count;
  double (*radius)(const double *values);
  /* Into how many equal pieces [0, radius] has to be cut for the profile to be smooth on each, and to turn on none by
   * more than a cycle: then 16 points of Gauss and Legendre on a piece integrate it to double precision. */
  uint32_t (*pieces)(const double *values);
  /* The profile at n positions in [0, radius], times any constant. */
  void (*evaluate)(const double *values, const double *x, size_t n, double *profile);
  /* Its integral from 0 to x in [0, radius], with the same constant. NULL: it is found by quadrature. */
  double (*primitive)(const double *values, double x);
  /* Its integral from x to the radius, with the same constant, for profiles that come near 0 before: as a difference of
   * primitives it would lose its digits. NULL: that difference. */
  double (*tail)(const double *values, double x);
} asc_filter_interface;

#define ASC_RADIUS_PARAMETER(fallback)                                                                                 \
  { "radius", ASC_REAL, NULL, ASC_FILTER_RADIUS_LEAST, ASC_FILTER_RADIUS_MOST, fallback, "half the width, in pixels" }

/* One piece, for profiles that are smooth from 0 to their radius. */
uint32_t asc_one_piece(const double *values);

/* The first value: where a filter's first parameter is its radius. */
double asc_first_value(const double *values);

/* sin(pi x), within 2e-16 for |x| <= 2^50: the same bits on every machine, and in a loop that compilers vectorise, both
 * of which the C library's sin is not. */
static inline double asc_sin_pi(double x) {
  /* Adding and subtracting 1.5 * 2^52 rounds to a whole number. */
  const double whole = (x + 0x1.8p52) - 0x1.8p52, half = 0.5 * whole;
  const double rest = x - whole, odd = half - ((half + 0x1.8p52) - 0x1.8p52); /* +-1/2 where `whole` is odd, else 0 */
  const double sign = 1.0 - 8.0 * odd * odd;
  /* (-1)^k pi^(2k+1) / (2k+1)!; the next term is below 2e-20 on [-1/2, 1/2]. */
  static const double taylor[] = {3.14159265358979324,     -5.16771278004997003,      2.55016403987734544,
                                  -0.599264529320792077,   0.0821458866111282288,     -0.00737043094571435078,
                                  0.000466302805767612564, -0.0000219153534478302158, 7.95205400147551278e-7,
                                  -2.29484289972698731e-8, 5.39266466260812849e-10,   -1.05184717169320645e-11};
  const double square = rest * rest;
  double sum = taylor[11];
  for (int k = 10; k >= 0; k--) sum = sum * square + taylor[k];
  return sign * rest * sum;
}

#endif

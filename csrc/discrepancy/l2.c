/* The L2 discrepancies: root mean square of n(A)/N - vol(A) over a family of sets A, or the norm of a kernel like it.
 *
 * Each is sqrt(constant^d - (2/N) sum_i prod_k one(x_ik) + (1/N^2) sum_ij prod_k two(x_ik, x_jk)):
 *   l2-star      boxes [0, t): Warnock 1972
 *   l2-extreme   boxes [s, t), s <= t: Morokoff and Caflisch 1994, eq. 2.5
 *   l2-centered  Hickernell 1998, "A generalized discrepancy and quadrature error bound", eq. 5.1c
 *   l2-wrap      Hickernell 1998, "Lattice rules: how well do they measure up?", eq. 5.5
 *   l2-mixture   Zhou, Fang and Ning 2013, "Mixture discrepancy for quasi-random point sets", eq. 18
 *   l2-periodic  boxes that wrap round: Lev 1995; Hinrichs, Kritzinger and Pillichshammer 2020, prop. 2
 *
 * The terms cancel: at N points of a good set the square is about (log N)^(d-1) / N^2 of terms near 1. So a number near
 * constant^d, the mean of the products, is taken off each; what is left is summed in double over RUN products at a
 * time, whose order does not depend on the machine, and from there in long double. */
#include <math.h>
#include <stdlib.h>

#include "measure.h"
#include "vectorise.h"

#define RUN 256

typedef enum kernel { STAR, EXTREME, CENTERED, WRAP, MIXTURE, PERIODIC } kernel;

static inline double larger(double x, double y) { return x > y ? x : y; }
static inline double smaller(double x, double y) { return x < y ? x : y; }

/* The cube of `constant` is the first term in three dimensions. */
static long double constant(kernel of) {
  switch (of) {
  case STAR: return 1.0L / 3.0L;
  case EXTREME: return 1.0L / 12.0L;
  case CENTERED: return 13.0L / 12.0L;
  case WRAP: return 4.0L / 3.0L;
  case MIXTURE: return 19.0L / 12.0L;
  case PERIODIC: return 1.0L / 3.0L;
  }
  return 0.0L;
}

/* wrap and periodic do not depend on where the set lies, so their second term is as constant as the first. */
static long double one(kernel of, double x) {
  const long double value = x, offset = fabsl(value - 0.5L);
  switch (of) {
  case STAR: return (1.0L - value * value) / 2.0L;
  case EXTREME: return value * (1.0L - value) / 2.0L;
  case CENTERED: return 1.0L + offset / 2.0L - offset * offset / 2.0L;
  case MIXTURE: return 5.0L / 3.0L - offset / 4.0L - offset * offset / 4.0L;
  case WRAP:
  case PERIODIC: break;
  }
  return constant(of);
}

/* x_off and y_off are |x - 1/2| and |y - 1/2|. */
static inline double two(kernel of, double x, double y, double x_off, double y_off) {
  const double apart = fabs(x - y);
  switch (of) {
  case STAR: return 1.0 - larger(x, y);
  case EXTREME: return smaller(x, y) * (1.0 - larger(x, y));
  case CENTERED: return 1.0 + 0.5 * (x_off + y_off - apart);
  case WRAP: return 1.5 - apart * (1.0 - apart);
  case MIXTURE: return 1.875 - 0.25 * (x_off + y_off) - apart * (0.75 - 0.5 * apart);
  case PERIODIC: return 0.5 - apart * (1.0 - apart);
  }
  return 0.0;
}

/* The products are two(x, y[j]) of the first dimension, times those of the others, for one kernel that is known when
 * this is compiled. */
#define FACTORS(of)                                                                                                    \
  case of:                                                                                                             \
    if (d == 0)                                                                                                        \
      for (size_t j = 0; j < padded; j++) products[j] = two(of, x, y[j], x_off, y_off[j]);                             \
    else                                                                                                               \
      for (size_t j = 0; j < padded; j++) products[j] *= two(of, x, y[j], x_off, y_off[j]);                            \
    break;

/* The sum over j in [0, count) of prod_k two(x_k, y_kj) - middle; both have a row of `stride` values a dimension, RUN
 * of which can be read. PARTS partial sums, so that it can be vectorised with the same bits everywhere. */
ASC_VECTORISE
static double sum_run(kernel of, uint32_t dimensions, const double *point, const double *rows, size_t stride,
                      size_t offset, size_t count, double middle) {
  enum { PARTS = 8 };
  double products[RUN], parts[PARTS] = {0.0};
  const size_t padded = (count + PARTS - 1) / PARTS * PARTS;
  for (uint32_t d = 0; d < dimensions; d++) {
    const double *y = rows + d * stride, *y_off = y + offset;
    const double x = point[d * stride], x_off = point[d * stride + offset];
    switch (of) {
      FACTORS(STAR)
      FACTORS(EXTREME)
      FACTORS(CENTERED)
      FACTORS(WRAP)
      FACTORS(MIXTURE)
      FACTORS(PERIODIC)
    }
  }
  for (size_t j = count; j < padded; j++) products[j] = middle;
  for (size_t j = 0; j < padded; j += PARTS)
    for (size_t p = 0; p < PARTS; p++) parts[p] += products[j + p] - middle;
  double sum = 0.0;
  for (size_t p = 0; p < PARTS; p++) sum += parts[p];
  return sum;
}

static asc_status l2(kernel of, const asc_point_set *set, asc_measurement *made, asc_error *error) {
  const size_t n = set->count;
  const uint32_t dimensions = set->dimensions;
  /* Dimension by dimension, with room to read a whole run from any place. */
  const size_t stride = n + RUN, offset = stride * dimensions;
  if (n > SIZE_MAX / 4 / sizeof(double) / dimensions - RUN) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double *rows = calloc(2 * offset, sizeof *rows);
  if (!rows) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < n; i++)
    for (uint32_t d = 0; d < dimensions; d++) {
      rows[d * stride + i] = set->points[i * dimensions + d];
      rows[d * stride + i + offset] = fabs(rows[d * stride + i] - 0.5);
    }
  const long double whole = powl(constant(of), dimensions);
  const double middle =
      (double)(rintl(whole * 256.0L) / 256.0L); /* of few digits, so that it adds none to dyadic ones */
  long double singles = 0.0L, pairs = 0.0L;
  for (size_t i = 0; i < n; i++) {
    long double single = 1.0L;
    double itself = 1.0;
    for (uint32_t d = 0; d < dimensions; d++) {
      const double x = rows[d * stride + i], x_off = rows[d * stride + i + offset];
      single *= one(of, x);
      itself *= two(of, x, x, x_off, x_off);
    }
    singles += single - whole;
    long double later = 0.0L;
    for (size_t j = i + 1; j < n; j += RUN)
      later += sum_run(of, dimensions, rows + i, rows + j, stride, offset, n - j < RUN ? n - j : RUN, middle);
    pairs += 2.0L * later + (itself - middle);
  }
  free(rows);
  const long double points = (long double)n;
  const long double square = (middle - whole) - 2.0L * singles / points + pairs / points / points;
  asc_measured(made, (double)sqrtl(square > 0.0L ? square : 0.0L));
  return ASC_OK;
}

#define MEASURE(identifier, kernel_, name_, title_, source_)                                                           \
  static asc_status identifier##_evaluate(const asc_point_set *set, const double *values, asc_measurement *made,       \
                                          asc_error *error) {                                                          \
    (void)values;                                                                                                      \
    return l2(kernel_, set, made, error);                                                                              \
  }                                                                                                                    \
  const asc_measure_interface asc_measure_##identifier = {.name = name_,                                               \
                                                          .title = title_,                                             \
                                                          .source = source_,                                           \
                                                          .least_dimensions = 1,                                       \
                                                          .most_dimensions = ASC_ANY_DIMENSION,                        \
                                                          .quick_points = 40000,                                       \
                                                          .evaluate = identifier##_evaluate};

MEASURE(l2_star, STAR, "l2-star", "root mean square of n/N - volume over boxes [0, t)", "Warnock 1972")
MEASURE(l2_extreme, EXTREME, "l2-extreme", "root mean square of n/N - volume over boxes [s, t)",
        "Morokoff and Caflisch 1994")
MEASURE(l2_centered, CENTERED, "l2-centered", "the same of boxes from the nearest corner, with all projections",
        "Hickernell 1998")
MEASURE(l2_wrap, WRAP, "l2-wrap", "the same of boxes that wrap round, with all projections", "Hickernell 1998")
MEASURE(l2_mixture, MIXTURE, "l2-mixture", "a mean of the centred and the wrapped one", "Zhou, Fang and Ning 2013")
MEASURE(l2_periodic, PERIODIC, "l2-periodic", "root mean square of n/N - volume over boxes that wrap round",
        "Lev 1995; Hinrichs, Kritzinger and Pillichshammer 2020")

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
 * The terms cancel: at N points of a good set the square is about (log N)^(d-1) / N^2 of terms near 1, and on a lattice
 * the same roundings come again and again. So products keep what they lose (kept.h), a number near constant^d, the mean
 * of the products, is taken off, and from there all is in long double: 12 digits at 2^16 points. In many dimensions the
 * products are as small as 12^-d: factors are taken `scale` times as large, and the root of its power is divided out.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "kept.h"
#include "measure.h"
#include "vectorise.h"

#define RUN 256

typedef enum kernel { STAR, EXTREME, CENTERED, WRAP, MIXTURE, PERIODIC } kernel;

static inline double larger(double x, double y) { return x > y ? x : y; }
static inline double smaller(double x, double y) { return x < y ? x : y; }

/* A fraction; and the power of two that its factors are multiplied by. */
typedef struct kernel_constant {
  long double numerator, denominator;
  int exponent;
} kernel_constant;

/* The cube of 1/3, 1/12, 13/12, 4/3, 19/12, 1/3 is the first term in three dimensions; here they are scaled. */
static const kernel_constant constants[] = {
    [STAR] = {2.0L, 3.0L, 1}, [EXTREME] = {2.0L, 3.0L, 3},   [CENTERED] = {13.0L, 12.0L, 0},
    [WRAP] = {4.0L, 3.0L, 0}, [MIXTURE] = {19.0L, 12.0L, 0}, [PERIODIC] = {2.0L, 3.0L, 1},
};

/* constant^d, and what that lacks: its rounding alone would be seen beside a square of 1e-8. */
static void power_of_constant(kernel of, uint32_t dimensions, long double *power, long double *lacking) {
  const kernel_constant from = constants[of];
  const long double base = from.numerator / from.denominator;
  const long double rest = fmal(-base, from.denominator, from.numerator) / from.denominator;
  *power = 1.0L;
  *lacking = 0.0L;
  for (uint32_t d = 0; d < dimensions; d++) {
    const long double next = *power * base;
    *lacking = fmal(*power, base, -next) + (*power * rest + *lacking * base);
    *power = next;
  }
}

/* Scaled. wrap and periodic do not depend on where the set lies: theirs is the constant. */
static long double one(kernel of, double x) {
  const long double value = x, offset = fabsl(value - 0.5L);
  switch (of) {
  case STAR: return 1.0L - value * value;
  case EXTREME: return 4.0L * value * (1.0L - value);
  case CENTERED: return 1.0L + offset / 2.0L - offset * offset / 2.0L;
  case MIXTURE: {
    /* With what 5/3 lacks: the same for all points, it would add up. */
    const long double first = 5.0L / 3.0L, rest = fmal(-first, 3.0L, 5.0L) / 3.0L;
    return first - (offset / 4.0L + offset * offset / 4.0L - rest);
  }
  case WRAP:
  case PERIODIC: break;
  }
  return 0.0L;
}

static int is_constant(kernel of) { return of == WRAP || of == PERIODIC; }

ASC_INLINE asc_kept times_two_to(int exponent, asc_kept number) {
  const double scale = (double)(1 << exponent);
  return (asc_kept){scale * number.value, scale * number.lost};
}

/* number - (1 - apart) apart, on the circle. */
ASC_INLINE asc_kept less_around(double number, asc_kept apart) {
  asc_kept rest = asc_kept_difference(1.0, apart.value);
  rest.lost -= apart.lost;
  const asc_kept product = asc_kept_product(apart, rest);
  asc_kept made = asc_kept_difference(number, product.value);
  made.lost -= product.lost;
  return made;
}

/* 1 + (|x - 1/2| + |y - 1/2| - |x - y|)/2: 1 for two on different sides of 1/2, else 1 and the nearer one's distance
 * from it, which is exact above. */
ASC_INLINE asc_kept centred(double least, double most) {
  const asc_kept below = asc_kept_difference(0.5, most < 0.5 ? most : 0.5);
  const double offset = least > 0.5 ? least - 0.5 : below.value;
  asc_kept made = asc_kept_sum(1.0, offset);
  made.lost += least > 0.5 ? 0.0 : below.lost;
  return made;
}

/* 15/8 - (|x - 1/2| + |y - 1/2|)/4 - 3/4 apart + apart^2/2; the sum is |x + y - 1| on one side of 1/2, else apart. */
ASC_INLINE asc_kept mixed(double least, double most, asc_kept apart) {
  const asc_kept both = asc_kept_sum(most, least);
  asc_kept offsets = asc_kept_sum(both.value, -1.0);
  const double sign = most <= 0.5 ? -1.0 : 1.0;
  const int same_side = (most <= 0.5) | (least >= 0.5);
  offsets = (asc_kept){sign * offsets.value, sign * (offsets.lost + both.lost)};
  offsets = (asc_kept){same_side ? offsets.value : apart.value, same_side ? offsets.lost : apart.lost};
  asc_kept rest = asc_kept_difference(0.75, 0.5 * apart.value);
  rest.lost -= 0.5 * apart.lost;
  const asc_kept product = asc_kept_product(apart, rest), first = asc_kept_difference(1.875, 0.25 * offsets.value);
  asc_kept made = asc_kept_difference(first.value, product.value);
  made.lost += (first.lost - 0.25 * offsets.lost) - product.lost;
  return made;
}

/* Scaled. */
ASC_INLINE asc_kept two(kernel of, double x, double y) {
  const double least = smaller(x, y), most = larger(x, y);
  switch (of) {
  case STAR: return times_two_to(1, asc_kept_difference(1.0, most));
  case EXTREME: return times_two_to(3, asc_kept_product((asc_kept){least, 0.0}, asc_kept_difference(1.0, most)));
  case CENTERED: return centred(least, most);
  case WRAP: return less_around(1.5, asc_kept_difference(most, least));
  case MIXTURE: return mixed(least, most, asc_kept_difference(most, least));
  case PERIODIC: return times_two_to(1, less_around(0.5, asc_kept_difference(most, least)));
  }
  return (asc_kept){0.0, 0.0};
}

/* The products are two(x, y[j]) of the first dimension, times those of the others, for one kernel that is known when
 * this is compiled. */
#define FACTORS(of)                                                                                                    \
  case of:                                                                                                             \
    for (size_t j = 0; j < padded; j++) {                                                                              \
      const asc_kept factor = two(of, x, y[j]);                                                                        \
      const asc_kept product = d == 0 ? factor : asc_kept_product((asc_kept){products[j], lost[j]}, factor);           \
      products[j] = product.value;                                                                                     \
      lost[j] = product.lost;                                                                                          \
    }                                                                                                                  \
    break;

/* The sum over j in [0, count) of prod_k two(x_k, y_kj); both have a row of `stride` values a dimension, RUN of which
 * can be read. */
ASC_VECTORISE
static asc_kept sum_run(kernel of, uint32_t dimensions, const double *point, const double *rows, size_t stride,
                        size_t count) {
  double products[RUN] = {0.0}, lost[RUN] = {0.0};
  const size_t padded = (count + ASC_KEPT_PARTS - 1) / ASC_KEPT_PARTS * ASC_KEPT_PARTS;
  for (uint32_t d = 0; d < dimensions; d++) {
    const double *y = rows + d * stride, x = point[d * stride];
    switch (of) {
      FACTORS(STAR)
      FACTORS(EXTREME)
      FACTORS(CENTERED)
      FACTORS(WRAP)
      FACTORS(MIXTURE)
      FACTORS(PERIODIC)
    }
  }
  for (size_t j = count; j < padded; j++) products[j] = lost[j] = 0.0;
  return asc_kept_total(products, lost, padded);
}

/* Of as many products, less as many times `middle`. */
static long double less_middle(asc_kept sum, size_t count, double middle) {
  return (sum.value - (long double)count * middle) + sum.lost;
}

static asc_status l2(kernel of, const asc_point_set *set, asc_measurement *made, asc_error *error) {
  const size_t n = set->count;
  const uint32_t dimensions = set->dimensions;
  const size_t stride = n + RUN; /* dimension by dimension, with room to read a whole run from any place */
  if (n > SIZE_MAX / 4 / sizeof(double) / dimensions - RUN) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double *rows = calloc(stride * dimensions, sizeof *rows);
  if (!rows) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (size_t i = 0; i < n; i++)
    for (uint32_t d = 0; d < dimensions; d++) rows[d * stride + i] = set->points[i * dimensions + d];
  long double whole, lacking;
  power_of_constant(of, dimensions, &whole, &lacking);
  const double middle = (double)(rintl(whole * 256.0L) / 256.0L); /* of few digits, for exact multiples */
  asc_kept_long singles = {0.0L, 0.0L}, pairs = {0.0L, 0.0L};
  for (size_t i = 0; i < n; i++) {
    long double single = 1.0L;
    for (uint32_t d = 0; d < dimensions; d++) single *= one(of, rows[d * stride + i]);
    if (!is_constant(of)) asc_kept_add(&singles, (single - whole) - lacking);
    for (size_t j = i + 1; j < n; j += RUN) {
      const size_t count = n - j < RUN ? n - j : RUN;
      const asc_kept later = sum_run(of, dimensions, rows + i, rows + j, stride, count);
      asc_kept_add(&pairs, 2.0L * less_middle(later, count, middle));
    }
    asc_kept_add(&pairs, less_middle(sum_run(of, dimensions, rows + i, rows + i, stride, 1), 1, middle));
  }
  free(rows);
  const long double points = (long double)n;
  const long double square = ((middle - whole) - lacking) - 2.0L * asc_kept_value(&singles) / points +
                             asc_kept_value(&pairs) / points / points;
  const long double scale = exp2l(-0.5L * constants[of].exponent * dimensions);
  const double value = (double)(sqrtl(square > 0.0L ? square : 0.0L) * scale);
  if (!isfinite(square) || !isfinite(value) || (square > 0.0L && value < DBL_MIN))
    return asc_fail(error, ASC_NUMERIC, "in %u dimensions the discrepancy, or its terms, are no doubles: take fewer",
                    dimensions);
  asc_measured(made, value);
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
                                                          .quick_points = 20000,                                       \
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

/* Integrals of w^k exp(-a w^2/2) by parts, each from the one two before; then Newton's method.
 *
 * Temme 1979, "The asymptotic expansion of the incomplete gamma functions", does this for chi-squared. */
#include "near_normal.h"

#include <math.h>

#define PI 3.141592653589793238462643383279502884L
#define TERMS ASC_NEAR_NORMAL_TERMS
#define MOST_STEPS 100
#define CLOSE 1e-15L /* Newton's next step would be its square */

typedef struct integrals {
  long double tail, body, density; /* from w on; from 0 to w; at w */
} integrals;

static integrals at(const asc_near_normal *law, long double w) {
  const long double a = law->a, bell = expl(-0.5L * a * w * w), scale = sqrtl(0.5L * PI / a);
  long double tails[TERMS], bodies[TERMS], power = 1.0L; /* w^k */
  integrals sum = {0.0L, 0.0L, 0.0L};
  for (int k = 0; k < TERMS; k++) {
    if (k == 0) {
      tails[k] = scale * erfcl(w * sqrtl(0.5L * a));
      bodies[k] = scale * erfl(w * sqrtl(0.5L * a));
    } else if (k == 1) {
      tails[k] = bell / a;
      bodies[k] = -expm1l(-0.5L * a * w * w) / a;
    } else {
      const long double edge = w != 0.0L ? power / w * bell : 0.0L; /* w^(k - 1) exp(-a w^2/2) */
      tails[k] = (edge + (k - 1) * tails[k - 2]) / a;
      bodies[k] = ((k - 1) * bodies[k - 2] - edge) / a;
    }
    sum.tail += law->series[k] * tails[k];
    sum.body += law->series[k] * bodies[k];
    sum.density += law->series[k] * power * bell;
    power *= w;
  }
  return sum;
}

/* From minus to plus infinity: the odd terms cancel. */
static long double whole(const asc_near_normal *law) {
  long double moment = sqrtl(2.0L * PI / law->a), sum = 0.0L;
  for (int k = 0; k < TERMS; k += 2) {
    sum += law->series[k] * moment;
    moment *= (k + 1) / law->a;
  }
  return sum;
}

long double asc_near_normal_tail(const asc_near_normal *law, long double q, long double start) {
  const long double wanted = q * whole(law), unit = 1.0L / sqrtl(law->a);
  long double w = start;
  for (int i = 0; i < MOST_STEPS; i++) {
    const integrals here = at(law, w);
    /* Of the logarithm, which is nearly a parabola. */
    const long double step = logl(here.tail / wanted) * here.tail / here.density;
    w += step;
    if (fabsl(step) <= CLOSE * (fabsl(w) + unit)) break;
  }
  return w;
}

long double asc_near_normal_body(const asc_near_normal *law, long double share, long double start) {
  const long double wanted = share * whole(law);
  long double w = start;
  for (int i = 0; i < MOST_STEPS; i++) {
    const integrals here = at(law, w);
    const long double step = (wanted - here.body) / here.density;
    w += step;
    if (fabsl(step) <= CLOSE * fabsl(w)) break;
  }
  return w;
}

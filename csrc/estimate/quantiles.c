/* Quantiles of the normal, Student's and the chi-squared law, by Newton's method on the smaller tail, or, near the
 * middle of a symmetric law, on the integral from the middle: both keep their digits. In long double, as the integrals
 * lose some.
 *
 *   up to 10^4 degrees   incomplete beta function by its continued fraction (DLMF 8.17.22), incomplete gamma function
 * by its series (8.7.1) or continued fraction (8.9.2), Lentz' algorithm as Thompson and Barnett 1986 have it; the
 * logarithm of gamma by Stirling's series (5.11.1) beyond               near_normal.h: Student's in w^2 = log(1 +
 * t^2/degrees) (Wallace 1959), where the density is exp(-degrees w^2/2) sqrt(y/(1 - exp(-y))), y = w^2; chi-squared in
 * w^2/2 = mu - log(1 + mu), mu = x/degrees - 1 (Temme 1979), where it is exp(-degrees w^2/4) w/mu
 *
 * Newton's steps are on the logarithm of the tail against that of x. It is concave: from one side of the solution the
 * steps stay there and converge, and a step from the other side lands there. */
#include <float.h>
#include <math.h>

#include "aliascope/estimate.h"
#include "near_normal.h"

#define PI 3.141592653589793238462643383279502884L
#define MANY 1e4L /* degrees, from which on the power series are as good */
#define MOST_DEGREES 1e12
#define MOST_STEPS 100
#define MOST_TERMS 100000 /* several hundred are needed */
#define CLOSE 1e-15L      /* Newton's next step would be its square */
#define MIDDLE 0.1L       /* tails beyond which the integral from the middle is looked at */

static asc_status given(long double found, double *x) {
  if (!(fabsl(found) <= (long double)DBL_MAX)) return ASC_NUMERIC;
  *x = (double)found;
  return ASC_OK;
}

/* ---- Normal ---- */

/* x with P(X > x) = q for q up to 1/2. */
static long double normal_upper(long double q) {
  const long double root = sqrtl(0.5L), scale = sqrtl(2.0L * PI);
  const int middle = q > MIDDLE;
  long double x = middle ? (0.5L - q) * scale : sqrtl(-2.0L * logl(q)); /* beyond the solution, or not far before */
  for (int i = 0; i < MOST_STEPS; i++) {
    const long double density = expl(-0.5L * x * x) / scale, tail = 0.5L * erfcl(x * root);
    const long double step = middle ? (0.5L - q - 0.5L * erfl(x * root)) / density : logl(tail / q) * tail / density;
    x += step;
    if (fabsl(step) <= CLOSE * fabsl(x)) break;
  }
  return x;
}

asc_status asc_normal_quantile(double p, double *x) {
  if (!x || !(p > 0.0 && p < 1.0)) return ASC_INVALID_ARGUMENT;
  const long double upper = p < 0.5 ? -normal_upper(p) : normal_upper(1.0L - p);
  return given(p == 0.5 ? 0.0L : upper, x);
}

/* ---- Gamma and beta functions ---- */

static long double log_gamma(long double z) {
  long double product = 1.0L;
  while (z < 24.0L) {
    product *= z;
    z += 1.0L;
  }
  /* B_2k/(2k (2k - 1)); the next term is below 1e-20. */
  static const long double series[] = {1.0L / 12,   -1.0L / 360,      1.0L / 1260, -1.0L / 1680,
                                       1.0L / 1188, -691.0L / 360360, 1.0L / 156,  -3617.0L / 122400};
  long double sum = 0.0L, power = 1.0L / z;
  for (int k = 0; k < 8; k++) {
    sum += series[k] * power;
    power /= z * z;
  }
  return (z - 0.5L) * logl(z) - z + 0.5L * logl(2.0L * PI) + sum - logl(product);
}

/* A continued fraction by Lentz' algorithm, a level a_i/(b_i + ...) a call. */
typedef struct fraction {
  long double value, c, d;
} fraction;

static long double not_zero(long double x) { return x != 0.0L ? x : LDBL_MIN; }

/* Returns the factor by which the value changed. */
static long double descend(fraction *of, long double a, long double b) {
  of->d = 1.0L / not_zero(b + a * of->d);
  of->c = not_zero(b + a / of->c);
  const long double factor = of->c * of->d;
  of->value *= factor;
  return factor;
}

/* I_x(a, b) over x^a (1 - x)^b/(a B(a, b)), for x < (a + 1)/(a + b + 2). */
static long double beta_fraction(long double a, long double b, long double x) {
  const long double first = 1.0L / not_zero(1.0L - (a + b) * x / (a + 1.0L));
  fraction of = {first, 1.0L, first};
  for (int i = 1; i < MOST_TERMS; i++) {
    const long double m = i, even = m * (b - m) * x / ((a + 2.0L * m - 1.0L) * (a + 2.0L * m));
    const long double odd = -(a + m) * (a + b + m) * x / ((a + 2.0L * m) * (a + 2.0L * m + 1.0L));
    (void)descend(&of, even, 1.0L);
    if (fabsl(descend(&of, odd, 1.0L) - 1.0L) <= LDBL_EPSILON) break;
  }
  return of.value;
}

/* ---- Student's t ---- */

typedef struct student {
  long double tail, body, density; /* from t on; from 0 to t; at t */
} student;

/* log_scale = log(1/B(degrees/2, 1/2)). */
static student student_at(long double t, long double degrees, long double log_scale) {
  const long double a = 0.5L * degrees, square = t * t, folded = log1pl(square / degrees);
  const long double front = expl(log_scale - a * folded);
  student made = {.density = front / sqrtl(degrees + square)};
  const long double x = degrees / (degrees + square), rest = square / (degrees + square);
  if (x < (a + 1.0L) / (a + 2.5L)) {
    made.tail = 0.5L * front * sqrtl(rest) / a * beta_fraction(a, 0.5L, x);
    made.body = 0.5L - made.tail;
  } else {
    made.body = front * sqrtl(rest) * beta_fraction(0.5L, a, rest);
    made.tail = 0.5L - made.body;
  }
  return made;
}

static long double student_few(long double q, long double degrees, long double t) {
  const long double log_scale = log_gamma(0.5L * degrees + 0.5L) - log_gamma(0.5L * degrees) - 0.5L * logl(PI);
  for (int i = 0; i < MOST_STEPS; i++) {
    const student here = student_at(t, degrees, log_scale);
    const long double step = (q > MIDDLE ? 0.5L - q - here.body : logl(here.tail / q) * here.tail) / (here.density * t);
    t *= q > MIDDLE ? 1.0L + step : expl(step);
    if (fabsl(step) <= CLOSE) break;
  }
  return t;
}

/* w with w^2 = log(1 + t^2/degrees). */
static long double student_many(long double q, long double degrees, long double start) {
  /* h^2 = y/(1 - exp(-y)), the inverse of the sum of (-y)^j/(j + 1)!; its power -1/2 by Miller's recurrence (Knuth, The
   * art of computer programming 2, 4.7, eq. 9). */
  enum { HALF = ASC_NEAR_NORMAL_TERMS / 2 };
  long double inverse[HALF] = {1.0L}, h[HALF] = {1.0L};
  asc_near_normal law = {.a = degrees, .series = {1.0L}};
  for (int n = 1; n < HALF; n++) {
    inverse[n] = -inverse[n - 1] / (n + 1);
    for (int j = 1; j <= n; j++) h[n] += (-0.5L * j - (n - j)) * inverse[j] * h[n - j] / n;
    law.series[n + n] = h[n];
  }
  return q > MIDDLE ? asc_near_normal_body(&law, 0.5L - q, start) : asc_near_normal_tail(&law, q, start);
}

/* t with P(T > t) = q for q below 1/2. */
static long double student_upper(long double q, long double degrees) {
  const long double w = normal_upper(q) / sqrtl(degrees);
  if (degrees < MANY) return student_few(q, degrees, sqrtl(degrees * expm1l(w * w)));
  const long double found = student_many(q, degrees, w);
  return sqrtl(degrees * expm1l(found * found));
}

asc_status asc_student_t_quantile(double p, double degrees, double *x) {
  if (!x || !(p > 0.0 && p < 1.0) || !(degrees >= 1.0 && degrees <= MOST_DEGREES)) return ASC_INVALID_ARGUMENT;
  if (p == 0.5) return given(0.0L, x);
  return given(p < 0.5 ? -student_upper(p, degrees) : student_upper(1.0L - p, degrees), x);
}

/* ---- Chi-squared: twice a gamma variable of shape degrees/2 ---- */

/* The tail below x, where x < shape + 1, else above x; over the density times x. */
static long double gamma_tail(long double x, long double shape) {
  long double sum = 1.0L / shape, term = sum;
  if (x < shape + 1.0L) {
    for (int n = 1; n < MOST_TERMS && term > LDBL_EPSILON * sum; n++) sum += term *= x / (shape + n);
    return sum;
  }
  fraction of = {1.0L / (x + 1.0L - shape), LDBL_MAX, 1.0L / (x + 1.0L - shape)};
  for (int n = 1; n < MOST_TERMS; n++)
    if (fabsl(descend(&of, -n * (n - shape), x + 2.0L * n + 1.0L - shape) - 1.0L) <= LDBL_EPSILON) break;
  return of.value;
}

static long double gamma_few(long double tail, long double shape, int sign, long double normal) {
  const long double log_scale = log_gamma(shape), third = 1.0L / (9.0L * shape);
  /* Wilson and Hilferty 1931, and what the lower tail is at least. */
  const long double cube = 1.0L - third + sign * normal * sqrtl(third);
  long double x = cube > 0.0L ? shape * cube * cube * cube : 0.0L;
  if (sign < 0) x = fmaxl(x, expl((logl(tail) + log_gamma(shape + 1.0L)) / shape));
  for (int i = 0; i < MOST_STEPS; i++) {
    const long double front = expl(shape * logl(x) - x - log_scale); /* density times x */
    const int below = x < shape + 1.0L;
    const long double ratio = gamma_tail(x, shape);
    const long double here = (below == (sign < 0)) ? ratio * front : 1.0L - ratio * front;
    const long double step = sign * logl(here / tail) * here / front;
    x *= expl(step);
    if (fabsl(step) <= CLOSE) break;
  }
  return x;
}

static long double gamma_many(long double tail, long double shape, int sign, long double normal) {
  /* mu as a series in w from mu mu' = w (1 + mu), and h = w/mu from h mu = w. */
  enum { TERMS = ASC_NEAR_NORMAL_TERMS };
  long double mu[TERMS + 1] = {0.0L, 1.0L}, h[TERMS] = {1.0L};
  for (int n = 2; n <= TERMS; n++) {
    long double sum = 0.0L;
    for (int i = 2; i < n; i++) sum += mu[i] * mu[n + 1 - i];
    mu[n] = (2.0L * mu[n - 1] / (n + 1) - sum) / 2.0L;
  }
  for (int n = 1; n < TERMS; n++)
    for (int i = 1; i <= n; i++) h[n] -= mu[i + 1] * h[n - i];
  asc_near_normal law = {.a = shape};
  for (int n = 0; n < TERMS; n++) law.series[n] = sign < 0 && n % 2 ? -h[n] : h[n];
  const long double w = sign * asc_near_normal_tail(&law, tail, normal / sqrtl(shape));
  long double sum = 0.0L;
  for (int n = TERMS; n > 0; n--) sum = (sum + mu[n]) * w;
  return shape * (1.0L + sum);
}

/* x with P(X < x) = tail (sign -1) or P(X > x) = tail (sign 1). */
static asc_status chi_squared(double tail, double degrees, int sign, double *x) {
  if (!x || !(tail > 0.0 && tail < 1.0) || !(degrees >= 1.0 && degrees <= MOST_DEGREES)) return ASC_INVALID_ARGUMENT;
  if (tail > 0.5) {
    tail = 1.0 - tail; /* exact */
    sign = -sign;
  }
  const long double normal = normal_upper(tail), shape = 0.5L * degrees;
  return given(
      2.0L * (degrees < (double)MANY ? gamma_few(tail, shape, sign, normal) : gamma_many(tail, shape, sign, normal)),
      x);
}

asc_status asc_chi_squared_quantile(double p, double degrees, double *x) { return chi_squared(p, degrees, -1, x); }

asc_status asc_chi_squared_upper_quantile(double q, double degrees, double *x) { return chi_squared(q, degrees, 1, x); }

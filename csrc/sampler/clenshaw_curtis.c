/* Clenshaw and Curtis's rule in each dimension: k points, the extrema of a Chebyshev polynomial and both ends of the
 * interval, exact for polynomials up to degree k - 1 (k if k is odd).
 *
 * Source: Clenshaw and Curtis 1960, "A method for numerical integration on an automatic computer". With n = k - 1 and
 * theta = j pi/n, node j on [0, 1] is sin^2(theta/2) and its weight (Davis and Rabinowitz 1984, 2.5.5)
 *   c_j/(2n) [1 - sum_(m=1)^(n/2) b_m cos(2 m theta)/(4m^2 - 1)],
 * c_j = 1 at the ends and else 2, b_m = 1 for m = n/2 and else 2. That subtracts nearly equal numbers, so here the
 * bracket is made of positive terms by sum_(m=1)^M 2/(4m^2 - 1) = 1 - 1/(2M + 1). It has n/2 terms; in rules of more
 * than 400 points it is instead, but for the 15 outermost nodes, the sum to infinity, which is 1 - pi/2 sin theta, less
 * the rest, summed by parts. The time so grows as k, and nodes and weights are within 2 ulp of the exact ones, small
 * ones too (the tests hold it).
 *
 * One point is the midpoint rule. The last node, 1, is 1 - 2^-24 here, since samples lie in [0, 1); the nodes next to
 * it are moved as the library's are. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "tensor.h"

#define PI 3.141592653589793238462643383279502884L
#define DIRECT_END 400 /* points of the largest rule by plain sums alone */
#define OUTERMOST 15   /* nodes from either end where summation by parts falls short: its least term is exp(-pi j) */
#define MOST_TERMS 48
#define STEPS_BETWEEN 64

/* cos(2 m theta) for m = n/2, n even, is cos(pi j). */
static long double sign_of(uint32_t j) { return j % 2 ? -1.0L : 1.0L; }

/* The bracket by its n/2 terms, the small ones first. The angles m theta are turned by -theta from term to term, and
 * set anew now and then, so that roundings do not gather. */
static long double bracket_by_sum(uint32_t n, uint32_t j) {
  const uint32_t most = n / 2;
  const long double turn_cosine = cosl(PI * j / n), turn_sine = sinl(PI * j / n);
  long double cosine = 1.0L, sine = 0.0L, sum = 0.0L;
  for (uint32_t m = most; m >= 1; m--) {
    if ((most - m) % STEPS_BETWEEN == 0) {
      const long double angle = PI * (long double)((uint64_t)m * j % (2ull * n)) / n;
      cosine = cosl(angle);
      sine = sinl(angle);
    }
    sum += 4.0L * sine * sine / (4.0L * m * m - 1.0L);
    const long double next = cosine * turn_cosine + sine * turn_sine;
    sine = sine * turn_cosine - cosine * turn_sine;
    cosine = next;
  }
  sum += 1.0L / (2.0L * most + 1.0L);
  return n % 2 ? sum : sum + sign_of(j) / ((long double)n * n - 1.0L);
}

/* The bracket by the sum to infinity. What is too much, sum_(m>=M) 2 cos(2 m theta)/(4m^2 - 1) with M = n/2 + 1, is the
 * real part of -sum z^m (g(m+1) - g(m)), z = exp(2 i theta), g(m) = 1/(2m - 1); by parts
 * -z^M/(1 - z) sum_p (z/(1 - z))^p D_(p+1), D_p the p-th difference of g at M, D_(p+1) = -2 (p+1)/(2M + 2p + 1) D_p.
 * z/(1 - z) = exp(i (theta + pi/2))/(2 sin theta). */
static long double bracket_by_parts(uint32_t n, uint32_t j) {
  const uint32_t begin = n / 2 + 1;
  const long double theta = PI * j / n, sine = sinl(theta), cosine = cosl(theta);
  /* z^M/(1 - z) = exp(i ((2M - 1) theta + pi/2))/(2 sin theta) */
  const long double turn = PI * (long double)((2ull * begin - 1) * j % (2ull * n)) / n + PI / 2;
  long double real = cosl(turn), imaginary = sinl(turn), sum = 0.0L;
  long double factor = 2.0L / ((2.0L * begin - 1.0L) * (2.0L * begin + 1.0L)) / (2.0L * sine); /* -D_1/(2 sin theta) */
  for (uint32_t p = 1; p <= MOST_TERMS; p++) {
    sum += factor * real;
    const long double next = -real * sine - imaginary * cosine; /* times i exp(i theta) = -sin + i cos */
    imaginary = real * cosine - imaginary * sine;
    real = next;
    const long double shrink = (p + 1.0L) / ((2.0L * begin + 2.0L * p + 1.0L) * sine);
    factor *= -shrink;
    if (fabsl(factor) < 0.01L * LDBL_EPSILON * sine) break;
  }
  sum += PI / 2.0L * sine;
  return n % 2 ? sum : sum + sign_of(j) / ((long double)n * n - 1.0L);
}

static void clenshaw_curtis_rule(uint32_t count, double *nodes, double *weights) {
  if (count == 1) {
    nodes[0] = 0.5;
    weights[0] = 1.0;
    return;
  }
  const uint32_t n = count - 1;
  for (uint32_t j = 0; j < (count + 1) / 2; j++) {
    const long double root = sinl(PI * j / n / 2.0L);
    const long double bracket = count > DIRECT_END && j > OUTERMOST ? bracket_by_parts(n, j) : bracket_by_sum(n, j);
    nodes[j] = 2 * j == n ? 0.5 : (double)(root * root);
    nodes[n - j] = 1.0 - nodes[j];
    weights[j] = weights[n - j] = (double)((j ? 1.0L : 0.5L) / n * bracket);
  }
}

static asc_status clenshaw_curtis_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  return asc_tensor_create("clenshaw-curtis", clenshaw_curtis_rule, config, made, error);
}

const asc_sampler_interface asc_sampler_clenshaw_curtis = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "clenshaw-curtis",
    .title = "Clenshaw and Curtis's quadrature rule in each dimension, with weights",
    .source = "Clenshaw and Curtis 1960; Davis and Rabinowitz 1984",
    .create = clenshaw_curtis_create,
    .destroy = free,
    .fill = asc_tensor_fill,
    .weights = asc_tensor_weights,
};

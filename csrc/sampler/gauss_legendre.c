/* Gauss and Legendre's rule in each dimension: k points, exact for polynomials up to degree 2k - 1.
 *
 * Nodes on [0, 1] are y/2 for the zeros x = 1 - y of the Legendre polynomial P_k; weights 1/((1 - x^2) P_k'(x)^2).
 * Zeros by Newton's method from Tricomi's approximation (1950), in long double, so that node and weight are within 2
 * ulp of the exact ones, small ones too (the tests hold it):
 *   - the recurrence of P_(j+1) - P_j in y, whose relative precision does not get lost where y is small, for all zeros
 *     of rules up to 400 points and for the 10 outermost ones of larger rules;
 *   - for the others Stieltjes' asymptotic series in the angle theta, x = cos theta (Szego 1939, "Orthogonal
 *     polynomials", 8.21.13; Hale and Townsend 2013, "Fast and accurate computation of Gauss-Legendre and Gauss-Jacobi
 *     quadrature nodes and weights", eq. 3.1), so that the time grows as k and not as k^2.
 *
 * Nodes next to 1 are moved as the library's are: those in [1 - 2^-25, 1) are 1 - 2^-24. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "tensor.h"

#define PI 3.141592653589793238462643383279502884L
#define RECURRENCE_END 400 /* points of the largest rule by recurrence alone */
#define OUTERMOST 10       /* zeros from either end where the series falls short: its least term is exp(-2 pi i) */
#define MOST_TERMS 48
#define MOST_STEPS 8

/* Newton's step from y toward a zero of P_n, and the weight there. (j+1) P_(j+1) = (2j+1) x P_j - j P_(j-1) in terms of
 * the difference D_j = P_j - P_(j-1). */
static long double step_by_recurrence(uint32_t n, long double y, long double *weight) {
  long double value = 1.0L, difference = 0.0L;
  for (uint32_t j = 0; j < n; j++) {
    const long double here = j;
    difference = (here * difference - (2.0L * here + 1.0L) * y * value) / (here + 1.0L);
    value += difference;
  }
  const long double slope = n * (y * value - difference); /* (1 - x^2) P_n' */
  *weight = y * (2.0L - y) / (slope * slope);
  return value * y * (2.0L - y) / slope;
}

/* gamma(n + 1)/gamma(n + 3/2), in powers of v = n + 1/2 (Tricomi and Erdelyi 1951); next term below 1e-20 of it. */
static long double gamma_ratio(uint32_t n) {
  const long double u = 1.0L / (n + 0.5L);
  const long double series =
      1.0L +
      u * (-1.0L / 8 + u * (1.0L / 128 + u * (5.0L / 1024 +
                                              u * (-21.0L / 32768 + u * (-399.0L / 262144 + u * (869.0L / 4194304))))));
  return sqrtl(u) * series;
}

/* The same in the angle: P_n(cos theta) = C sum_m h_m cos(a_m) / (2 sin theta)^(m + 1/2), the angles
 * a_m = (n + m + 1/2) theta - (m + 1/2) pi/2 turning by theta - pi/2 from term to term. */
static long double step_by_series(uint32_t n, long double scale, long double theta, long double *weight) {
  const long double sine = sinl(theta), cosine = cosl(theta), turn = (n + 0.5L) * theta - PI / 4;
  long double real = cosl(turn), imaginary = sinl(turn), factor = 1.0L, value = 0.0L, slope = 0.0L;
  for (uint32_t m = 0; m < MOST_TERMS && factor > 0.01L * LDBL_EPSILON; m++) {
    const long double half = m + 0.5L;
    value += factor * real;
    slope -= factor * ((n + half) * imaginary + half * cosine / sine * real);
    const long double next = real * sine + imaginary * cosine; /* times exp(i (theta - pi/2)) = sin - i cos */
    imaginary = imaginary * sine - real * cosine;
    real = next;
    factor *= half * half / ((m + 1.0L) * (n + half + 1.0L) * 2.0L * sine);
  }
  *weight = 2.0L * sine / (scale * scale * slope * slope);
  return value / slope;
}

/* Zero number i of P_n from x = 1, i from 1: (1 - x)/2, and the weight. */
static void find_zero(uint32_t n, uint32_t i, long double scale, double *node, double *weight) {
  const long double first = PI * (i - 0.25L) / (n + 0.5L);
  long double theta = first + cosl(first) / sinl(first) / (8.0L * n * n), found, step;
  if (n > RECURRENCE_END && i > OUTERMOST) {
    int steps = 0;
    do theta -= step = step_by_series(n, scale, theta, &found);
    while (fabsl(step) > 16.0L * LDBL_EPSILON * theta && ++steps < MOST_STEPS);
    const long double root = sinl(theta / 2.0L);
    *node = (double)(root * root);
  } else {
    const long double root = sinl(theta / 2.0L);
    long double y = 2.0L * root * root;
    int steps = 0;
    do y += step = step_by_recurrence(n, y, &found);
    while (fabsl(step) > 16.0L * LDBL_EPSILON * y && ++steps < MOST_STEPS);
    *node = (double)(y / 2.0L);
  }
  *weight = (double)found;
}

static void gauss_legendre_rule(uint32_t count, double *nodes, double *weights) {
  const long double scale = 2.0L / sqrtl(PI) * gamma_ratio(count);
  for (uint32_t i = 0; i < (count + 1) / 2; i++) {
    find_zero(count, i + 1, scale, &nodes[i], &weights[i]);
    if (2 * i + 1 == count) nodes[i] = 0.5;
    nodes[count - 1 - i] = 1.0 - nodes[i];
    weights[count - 1 - i] = weights[i];
  }
}

static asc_status gauss_legendre_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  return asc_tensor_create("gauss-legendre", gauss_legendre_rule, config, made, error);
}

const asc_sampler_interface asc_sampler_gauss_legendre = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "gauss-legendre",
    .title = "Gauss and Legendre's quadrature rule in each dimension, with weights",
    .source = "Gauss 1814; Szego 1939; Hale and Townsend 2013",
    .create = gauss_legendre_create,
    .destroy = free,
    .fill = asc_tensor_fill,
    .weights = asc_tensor_weights,
};

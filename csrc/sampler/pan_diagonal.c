/* Times by a pan-diagonal magic square: n x n points, their slots of time 0 to n^2 - 1 such that the slots of every
 * row, every column and every diagonal, broken ones too, add up to n (n^2 - 1)/2.
 *
 * Order 4 is the square of Hanrahan 2000, CS348B, "Space-time patterns". There are such squares of every order but 2, 3
 * and 4m + 2 (none of 4m + 2: Planck 1919, "Pandiagonal magics of orders 6 and 10 with minimal numbers", The Monist 29;
 * Rosser and Walker 1939, "The algebraic theory of diabolic magic squares"). Here the slot of row i and column j is
 * n P(i, j) + Q(i, j), where P and Q have numbers 0 to n - 1 that add up to n (n - 1)/2 along every line, and no pair
 * (P, Q) twice; all indices modulo n:
 *
 *   n odd (Margossian's method: Ball, "Mathematical recreations and essays", chapter on magic squares):
 *     P = s(2i + j), Q = s(2i - j), s a permutation. The determinant, -4, and so the map to pairs is invertible. Along
 *     a line the argument grows by 1, 2 or 3; where n has no factor 3 it takes every value once. Where it has, a step
 *     of 3 takes the n/3 values of one residue modulo 3, three times each, so s gives each residue the same sum.
 *   n = 4m: P = r(j + i n/2), Q = r(i + j n/2), r a permutation with r(j) + r(j + n/2) = n - 1. A column has r(j) in
 *     half its rows and n - 1 - r(j) in the others; a row has all numbers; along a diagonal j has the values of one
 *     parity in even rows, and those of the other in odd rows, each a set of such pairs. The parities of i and j can be
 *     read from P and Q, since n/2 is even, and then i and j.
 *
 * s and r are free otherwise; s steps by about 0.38 n, r by about n/6, which was found to spread the times of
 * neighbours best of several. How pixels differ, what is jittered and centred=1: space_time.h; sums are kept in every
 * pixel. */
#include <stdlib.h>

#include "space_time.h"

#define LARGEST_ORDER ((uint64_t)1 << 24)

static const uint8_t order_4[4][4] = {{15, 8, 5, 2}, {4, 3, 14, 9}, {10, 13, 0, 7}, {1, 6, 11, 12}};

static int has_square(uint64_t order) { return order == 1 || (order > 3 && order % 4 != 2); }

static uint64_t common_divisor(uint64_t a, uint64_t b) {
  while (b) {
    const uint64_t rest = a % b;
    a = b;
    b = rest;
  }
  return a;
}

/* The number nearest to `wanted` that has no common divisor with `range`. */
static uint64_t step_near(uint64_t wanted, uint64_t range) {
  uint64_t away = 0;
  while (common_divisor(wanted + away, range) != 1 && (away > wanted || common_divisor(wanted - away, range) != 1))
    away++;
  return common_divisor(wanted + away, range) == 1 ? wanted + away : wanted - away;
}

/* A permutation of 0 to n - 1, n an odd multiple of 3, whose values at x = c modulo 3 add up to the same for each c:
 * the first nine by a square in which rows add up to 12, then six at a time, of which the outer, middle and inner two
 * go together. */
static uint64_t balance_residues(uint64_t x) {
  static const uint8_t rows[3][3] = {{0, 4, 8}, {1, 5, 6}, {2, 3, 7}};
  const uint64_t residue = x % 3, place = x / 3;
  if (place < 3) return rows[residue][place];
  const uint64_t six = 9 + (place - 3) / 2 * 6;
  return (place - 3) % 2 ? six + 5 - residue : six + residue;
}

/* s of an odd order: a step of `step`, which maps residues modulo 3 to residues. */
static uint64_t odd_term(const asc_space_time *pattern, uint64_t x) {
  const uint64_t spread = x % pattern->side * pattern->step % pattern->side;
  return pattern->side % 3 ? spread : balance_residues(spread);
}

/* r of an order 4m: in the first half two by turns are the smaller and the larger of their pairs. */
static uint64_t even_term(const asc_space_time *pattern, uint64_t x) {
  const uint64_t order = pattern->side, half = order / 2, at = x % half;
  const uint64_t small = at * pattern->step % half;
  return (x / half + at / 2) % 2 ? order - 1 - small : small;
}

static uint64_t pan_diagonal_slot(const asc_space_time *pattern, uint64_t column, uint64_t row) {
  const uint64_t order = pattern->side, half = order / 2;
  if (order == 4) return order_4[row][column];
  if (order % 2) return order * odd_term(pattern, 2 * row + column) + odd_term(pattern, 2 * row + order - column);
  return order * even_term(pattern, (column + row % 2 * half) % order) +
         even_term(pattern, (row + column % 2 * half) % order);
}

static asc_status refuse(uint64_t samples, asc_error *error) {
  uint64_t below = 1, above = 1;
  for (uint64_t order = 1; above <= samples && order <= LARGEST_ORDER; order++)
    if (has_square(order)) {
      below = above;
      above = order * order;
    }
  return asc_fail(error, ASC_UNSUPPORTED,
                  "pan-diagonal has n x n points, n = 1, 4, 5, 7, 8, 9, 11, ... (there is no such square of 2, 3 or "
                  "4m + 2, and none here above 2^24), not %llu: the nearest are %llu and %llu",
                  (unsigned long long)samples, (unsigned long long)below, (unsigned long long)above);
}

static asc_status pan_diagonal_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const asc_status status = asc_space_time_check("pan-diagonal", config, error);
  if (status) return status;
  const uint64_t order = asc_exact_root(config->samples, 2);
  if (!has_square(order) || order > LARGEST_ORDER) return refuse(config->samples, error);
  asc_space_time *pattern = asc_space_time_new(config, order, pan_diagonal_slot, 0);
  if (!pattern) return asc_fail(error, ASC_OUT_OF_MEMORY, "pan-diagonal: out of memory");
  pattern->step = order % 2 ? step_near(order * 382 / 1000, order) : step_near((order + 3) / 6, order / 2);
  *made = asc_space_time_state(pattern);
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_pan_diagonal = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "pan-diagonal",
    .title = "times by a pan-diagonal magic square, in x, y and t",
    .source = "Hanrahan 2000, CS348B; Margossian 1908; Planck 1919; Rosser and Walker 1939",
    .parameters = &asc_space_time_centred,
    .parameter_count = 1,
    .create = pan_diagonal_create,
    .destroy = free,
    .fill = asc_space_time_fill,
};

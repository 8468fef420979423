/* Points of pmj02, four values at a time, as the static functions FOUR(point) and FOUR(rows). Included by pmj02.c
 * alone, once for each instruction set. */
#include "owen_four.h"

/* The places of indices, from the digits of the indices with the highest one lowest. A hash like that of owen.h, but
 * with the product of each digit's two predecessors, twice. */
ASC_INLINE void FOUR(shuffle)(asc_four *x, int vectors, const asc_four *keys) {
  const asc_four key = *keys;
  asc_four factor, even;
  FOUR(load)(asc_owen.factor[0], &factor);
  FOUR(load)(asc_owen.even, &even);
  EACH x[v] += key;
  EACH x[v] ^= PRODUCT(x[v], factor) ^ (key >> 32);
  EACH x[v] ^= (x[v] << 1) & (x[v] << 2) & (key >> 24);
  EACH x[v] += key >> 8;
  EACH x[v] ^= PRODUCT(x[v], (key >> 16) & even);
  EACH x[v] += key >> 20;
  EACH x[v] ^= (x[v] << 1) & (x[v] << 2) & (key >> 12);
  FOUR(reverse)(x, vectors);
  EACH x[v] >>= 32;
}

/* Pascal's matrix mod 2 times places: digit k is the sum of those digits m of which k is a subset, as bits (Lucas). Its
 * reverse is Sobol's second dimension. */
ASC_INLINE void FOUR(times_pascal)(asc_four *x, int vectors) {
  EACH x[v] ^= (x[v] >> 1) & 0x55555555u;
  EACH x[v] ^= (x[v] >> 2) & 0x33333333u;
  EACH x[v] ^= (x[v] >> 4) & 0x0f0f0f0fu;
  EACH x[v] ^= (x[v] >> 8) & 0x00ff00ffu;
  EACH x[v] ^= x[v] >> 16; /* high halves are 0 */
}

/* The key of the order of a pair: the sum of those of its coordinates, which is independent of each. */
ASC_INLINE void FOUR(order_keys)(const asc_four *drawn, asc_four *order) {
  *order = *drawn + __builtin_shufflevector(*drawn, *drawn, 1, 0, 3, 2);
}

static void FOUR(point)(asc_key key, uint32_t quad, uint32_t index, double values[QUAD]) {
  const uint32_t reversed = asc_reverse_bits(index);
  asc_four drawn, order, places = {reversed, reversed, reversed, reversed};
  asc_four_key keys;
  FOUR(draw)(key, quad * QUAD, ASC_PURPOSE_SCRAMBLE, &drawn);
  FOUR(order_keys)(&drawn, &order);
  FOUR(expand)(&drawn, &keys);
  FOUR(shuffle)(&places, 1, &order);
  asc_four products = places;
  FOUR(times_pascal)(&products, 1);
  asc_four digits = __builtin_shufflevector(places, products, 0, 5, 2, 7);
  FOUR(hash)(&digits, 1, &keys);
  FOUR(reverse)(&digits, 1);
  FOUR(to_unit)(&digits, 1, values);
}

/* All of a run of ASC_LANES indices from `begin` on, a multiple of it. The next row is `stride` further. */
ASC_INLINE void FOUR(block)(uint32_t begin, const asc_four *order, const asc_four_key *keys, double *rows,
                            size_t stride) {
  const uint32_t above = asc_reverse_bits(begin);
  const asc_four lowest = {0, 0x80000000u, 0x40000000u, 0xc0000000u};
  asc_four places[4], products[4];
  for (uint32_t v = 0; v < 4; v++) places[v] = lowest + (above | asc_reverse_bits(4 * v));
  FOUR(shuffle)(places, 4, order);
  for (uint32_t v = 0; v < 4; v++) products[v] = places[v];
  FOUR(times_pascal)(products, 4);
  for (size_t half = 0; half < 2; half++) {
    asc_four digits[4];
    for (size_t v = 0; v < 2; v++) {
      const asc_four x = places[2 * half + v], y = products[2 * half + v];
      digits[2 * v] = __builtin_shufflevector(x, y, 0, 4, 2, 6);
      digits[2 * v + 1] = __builtin_shufflevector(x, y, 1, 5, 3, 7);
    }
    double values[4][2][2]; /* of samples 0 and 2, 1 and 3, 4 and 6, 5 and 7 */
    FOUR(hash)(digits, 4, keys);
    FOUR(reverse)(digits, 4);
    FOUR(to_unit)(digits, 4, &values[0][0][0]);
    for (uint32_t k = 0; k < 8; k++, rows += stride)
      memcpy(rows, values[k / 4 * 2 + k % 2][k / 2 % 2], 2 * sizeof *rows);
  }
}

static void FOUR(rows)(asc_key key, const pair_run *run) {
  asc_four drawn, order;
  asc_four_key keys;
  FOUR(draw)(key, run->pair / 2 * QUAD, ASC_PURPOSE_SCRAMBLE, &drawn);
  const asc_four low = __builtin_shufflevector(drawn, drawn, 0, 1, 0, 1);
  const asc_four high = __builtin_shufflevector(drawn, drawn, 2, 3, 2, 3);
  drawn = run->pair % 2 ? high : low;
  FOUR(order_keys)(&drawn, &order);
  FOUR(expand)(&drawn, &keys);
  double *points = run->points;
  const uint32_t width = run->end - run->begin;
  for (uint32_t block = run->first / ASC_LANES; block <= run->last / ASC_LANES; block++) {
    const uint32_t from = block == run->first / ASC_LANES ? run->first % ASC_LANES : 0;
    const uint32_t to = block == run->last / ASC_LANES ? run->last % ASC_LANES + 1 : ASC_LANES;
    if (to - from == ASC_LANES && width == 2) {
      FOUR(block)(block * ASC_LANES, &order, &keys, points, run->stride);
      points += ASC_LANES * run->stride;
      continue;
    }
    double rows[ASC_LANES][2];
    FOUR(block)(block * ASC_LANES, &order, &keys, rows[0], 2);
    for (uint32_t i = from; i < to; i++, points += run->stride) asc_copy_few(rows[i] + run->begin, width, points);
  }
}
#undef FOUR

/* sobol:scramble=owen, four values at a time, as the static functions FOUR(owen_point) and FOUR(owen_rows). Included by
 * sobol.c alone, once for each instruction set. */
#include "owen_four.h"

/* All four dimensions of one point. */
static void FOUR(owen_point)(const quad *of, uint32_t quad_index, uint32_t index, asc_key key, double values[QUAD]) {
  asc_four_words bits = {0};
  for (uint32_t k = 0; k < BYTES; k++) {
    asc_four_words added;
    memcpy(&added, of->byte[k][(index >> (8 * k)) & 255u], sizeof added);
    bits ^= added;
  }
  asc_four drawn, words = __builtin_convertvector(bits, asc_four);
  asc_four_key keys;
  FOUR(draw)(key, quad_index * QUAD, ASC_PURPOSE_SCRAMBLE, &drawn);
  FOUR(expand)(&drawn, &keys);
  FOUR(hash)(&words, 1, &keys);
  FOUR(reverse)(&words, 1);
  FOUR(to_unit)(&words, 1, values);
}

/* Values are made in the order in which they are written: a column is in every `width`-th of the four lanes. */
ASC_INLINE void FOUR(make_rows)(const owen_run *run, asc_key key, uint32_t width) {
  const quad *of = run->of;
  asc_four drawn, low[ASC_LANES];
  FOUR(draw)(key, run->quad_index * QUAD, ASC_PURPOSE_SCRAMBLE, &drawn);
  for (uint32_t i = 0; i < ASC_LANES * width; i++) low[i / 4][i % 4] = of->low[run->begin + i % width][i / width];
  const asc_four all = drawn;
  for (uint32_t i = 0; i < 4; i++) drawn[i] = all[run->begin + i % width];
  asc_four_key keys;
  FOUR(expand)(&drawn, &keys);
  double *points = run->points;
  for (uint32_t block = run->first / ASC_LANES; block <= run->last / ASC_LANES; block++) {
    const uint32_t from = block == run->first / ASC_LANES ? run->first % ASC_LANES : 0;
    const uint32_t to = block == run->last / ASC_LANES ? run->last % ASC_LANES + 1 : ASC_LANES;
    const int straight = to - from == ASC_LANES && run->stride == width;
    double values[ASC_LANES * QUAD], *rows = straight ? points : values;
    uint32_t above[QUAD] = {0};
    add_directions(of, block * ASC_LANES, above);
    const uint32_t *at = above + run->begin;
    const asc_four high = {at[0], at[1 % width], at[2 % width], at[3 % width]};
    for (size_t i = 0; i < ASC_LANES * width / 4; i += 4) {
      asc_four words[4];
      for (size_t v = 0; v < 4; v++) words[v] = low[i + v] ^ high;
      FOUR(hash)(words, 4, &keys);
      FOUR(reverse)(words, 4);
      FOUR(to_unit)(words, 4, rows + 4 * i);
    }
    for (uint32_t i = from; i < to && !straight; i++)
      memcpy(points + (i - from) * run->stride, values + (size_t)i * width, width * sizeof *values);
    points += (to - from) * run->stride;
  }
}

static void FOUR(owen_rows)(const owen_run *run, asc_key key) {
  if (run->width == 4)
    FOUR(make_rows)(run, key, 4);
  else if (run->width == 2)
    FOUR(make_rows)(run, key, 2);
  else
    FOUR(make_rows)(run, key, 1);
}
#undef FOUR

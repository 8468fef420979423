/* Rows of sobol:scramble=owen, sixteen values at a time, by the instructions of x86-64-v4. Included by sobol.c alone.
 */
#define FOUR(name) name##_v4
#include "owen_four.h"

typedef uint32_t sixteen __attribute__((vector_size(64)));

ASC_INLINE sixteen picked(sixteen from, sixteen lanes) {
  return (sixteen)_mm512_permutexvar_epi32((__m512i)lanes, (__m512i)from);
}

/* What the hash takes from the 64 random bits of each dimension, for the lanes' dimensions. */
typedef struct sixteen_key {
  sixteen added, turned, factor, added_later;
} sixteen_key;

ASC_INLINE sixteen words_of(asc_four bits, sixteen lanes) {
  return picked((sixteen)_mm512_castsi256_si512((__m256i)bits), lanes);
}

/* asc_owen_key_of. */
ASC_INLINE sixteen_key keys_of(asc_four bits, sixteen dimension) {
  return (sixteen_key){words_of(bits, 2 * dimension), words_of(bits, 2 * dimension + 1),
                       words_of(bits >> 16, 2 * dimension) & ~1u, words_of(bits >> 24, 2 * dimension)};
}

/* asc_owen_reversed; the test of single points against runs holds that it is the same. */
ASC_INLINE sixteen hashed(sixteen x, const sixteen_key *key) {
  x += key->added;
  x ^= x * 0x3d20adeau ^ key->turned;
  x ^= x * key->factor;
  x += key->added_later;
  x ^= x * 0x05526c56u;
  return x ^ x * 0x53a22864u;
}

/* asc_reverse_bits: of a word's bytes by a shuffle, of a byte's halves from a table each. */
ASC_INLINE sixteen turned_round(sixteen x) {
  const __m512i bytes = _mm512_broadcast_i32x4(_mm_setr_epi8(3, 2, 1, 0, 7, 6, 5, 4, 11, 10, 9, 8, 15, 14, 13, 12));
  const __m512i upper = _mm512_broadcast_i32x4(_mm_setr_epi8(0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15));
  const __m512i lower = _mm512_slli_epi32(upper, 4), nibble = _mm512_set1_epi8(15);
  const __m512i swapped = _mm512_shuffle_epi8((__m512i)x, bytes);
  return (sixteen)(_mm512_shuffle_epi8(upper, _mm512_srli_epi32(swapped, 4) & nibble) |
                   _mm512_shuffle_epi8(lower, swapped & nibble));
}

/* asc_unit_of_bits. */
ASC_INLINE void put_units(sixteen bits, double values[ASC_LANES]) {
  const __m512i words = (__m512i)bits;
  _mm512_storeu_pd(values, _mm512_cvtepu32_pd(_mm512_castsi512_si256(words)) * 0x1p-32);
  _mm512_storeu_pd(values + 8, _mm512_cvtepu32_pd(_mm512_extracti64x4_epi64(words, 1)) * 0x1p-32);
}

/* The lowest bits' part of ASC_LANES samples, row by row, as are the values that are made of it. */
ASC_INLINE void lay_out_low(const owen_run *run, uint32_t width, sixteen dimension, sixteen low[QUAD]) {
  const sixteen iota = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const uint32_t(*rows)[QUAD] = run->of->byte[0];
  if (width == 1) memcpy(&low[0], run->of->low[run->begin], sizeof *low);
  if (width == 4) memcpy(low, rows, width * sizeof *low);
  for (uint32_t v = 0; width == 2 && v < width; v++) {
    sixteen eight[2];
    memcpy(eight, rows + (size_t)8 * v, sizeof eight);
    low[v] = (sixteen)_mm512_permutex2var_epi32((__m512i)eight[0], (__m512i)(iota / 2 * QUAD + dimension),
                                                (__m512i)eight[1]);
  }
}

/* The samples of one pixel: from the parts of the lowest bits and the columns of each lane. */
ASC_INLINE void make_pixel(const owen_run *run, asc_key key, uint32_t width, sixteen column, const sixteen low[QUAD],
                           double *points) {
  asc_four drawn;
  draw_v4(key, run->quad_index * QUAD, ASC_PURPOSE_SCRAMBLE, &drawn);
  const sixteen dimension = run->begin + column;
  const sixteen_key keys = keys_of(drawn, dimension);
  for (uint32_t block = run->first / ASC_LANES; block <= run->last / ASC_LANES; block++) {
    const uint32_t from = block == run->first / ASC_LANES ? run->first % ASC_LANES : 0;
    const uint32_t to = block == run->last / ASC_LANES ? run->last % ASC_LANES + 1 : ASC_LANES;
    const int straight = to - from == ASC_LANES && run->stride == width;
    double values[ASC_LANES * QUAD], *rows = straight ? points : values;
    asc_four_words above = {0};
    for (uint32_t k = 0; k < BYTES; k++) {
      asc_four_words added;
      memcpy(&added, run->of->byte[k][(block * ASC_LANES >> (8 * k)) & 255u], sizeof added);
      above ^= added;
    }
    const sixteen high = picked((sixteen)_mm512_castsi128_si512((__m128i)above), dimension);
    for (uint32_t v = 0; v < width; v++)
      put_units(turned_round(hashed(low[v] ^ high, &keys)), rows + (size_t)ASC_LANES * v);
    for (uint32_t i = from; i < to && !straight; i++)
      memcpy(points + (i - from) * run->stride, values + (size_t)i * width, width * sizeof *values);
    points += (to - from) * run->stride;
  }
}

ASC_INLINE void make_sixteens(const owen_run *run, uint32_t width) {
  const sixteen iota = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const sixteen column = iota & (width - 1);
  sixteen low[QUAD];
  lay_out_low(run, width, run->begin + column, low);
  const size_t values = run->stride * (run->last - run->first + 1);
  for (size_t i = 0; i < run->pixels; i++) make_pixel(run, run->keys[i], width, column, low, run->points + i * values);
}

static void owen_rows_v4(const owen_run *run) {
  if (run->width == 4)
    make_sixteens(run, 4);
  else if (run->width == 2)
    make_sixteens(run, 2);
  else
    make_sixteens(run, 1);
}
#undef FOUR

/* The hash of owen.h for four values at a time, as the always inlined functions FOUR(...). For single points, whose
 * steps wait for each other: a product of two words in 64-bit lanes waits 5 cycles, in 32-bit lanes 10. Included once
 * for each instruction set, with FOUR(name) the name of its version; the compiler has no pattern for that product
 * (hash_lanes.h), so it is named.
 *
 * Each word lies in the low half of its lane. The high halves hold what the steps leave there: nothing reads them. */
#undef PRODUCT
#undef EACH
#if ASC_HAS_LEVELS && defined(__AVX2__)
#define PRODUCT(a, b) ((asc_four)_mm256_mul_epu32((__m256i)(a), (__m256i)(b)))
#elif ASC_HAS_LEVELS
#define PRODUCT_HALF(a, b, i, j)                                                                                       \
  _mm_mul_epu32((__m128i)__builtin_shufflevector(a, a, i, j), (__m128i)__builtin_shufflevector(b, b, i, j))
#define PRODUCT(a, b)                                                                                                  \
  ((asc_four)__builtin_shufflevector(PRODUCT_HALF(a, b, 0, 1), PRODUCT_HALF(a, b, 2, 3), 0, 1, 2, 3))
#else
#define PRODUCT(a, b) (((a)&UINT32_MAX) * ((b)&UINT32_MAX))
#endif

#ifndef ASC_OWEN_FOUR_H
#define ASC_OWEN_FOUR_H
typedef uint64_t asc_four __attribute__((vector_size(32)));
typedef uint32_t asc_four_words __attribute__((vector_size(16)));
typedef double asc_four_doubles __attribute__((vector_size(32)));
typedef unsigned char asc_four_bytes __attribute__((vector_size(32)));
typedef struct asc_four_key {
  asc_four added, turned, factor, added_later;
} asc_four_key;
#endif

/* (Vectors go by pointer: without AVX there is no calling convention for them.) */

ASC_INLINE void FOUR(load)(const uint64_t constant[4], asc_four *loaded) { memcpy(loaded, constant, sizeof *loaded); }

/* The product of 64-bit numbers and constants modulo 2^64. */
ASC_INLINE void FOUR(multiply)(asc_four *x, const uint64_t low[4], const uint64_t high[4]) {
  asc_four l, h;
  FOUR(load)(low, &l);
  FOUR(load)(high, &h);
  *x = PRODUCT(*x, l) + ((PRODUCT(*x >> 32, l) + PRODUCT(*x, h)) << 32);
}

/* asc_draw of four indices, index ... index + 3. */
ASC_INLINE void FOUR(draw)(asc_key key, uint32_t index, uint32_t purpose, asc_four *drawn) {
  const asc_four steps = {0, ASC_GOLDEN, 2 * ASC_GOLDEN, 3 * ASC_GOLDEN};
  asc_four x = asc_draw_start(key, index, purpose) + steps;
  x ^= x >> 30;
  FOUR(multiply)(&x, asc_owen.draw[0], asc_owen.draw_high[0]);
  x ^= x >> 27;
  FOUR(multiply)(&x, asc_owen.draw[1], asc_owen.draw_high[1]);
  *drawn = x ^ (x >> 31);
}

/* asc_owen_key_of. */
ASC_INLINE void FOUR(expand)(const asc_four *drawn, asc_four_key *key) {
  asc_four even;
  FOUR(load)(asc_owen.even, &even);
  *key = (asc_four_key){*drawn, *drawn >> 32, (*drawn >> 16) & even, *drawn >> 24};
}

/* The steps of a value wait for each other, so of several vectors all go through one step before the next. */
#define EACH _Pragma("GCC unroll 4") for (int v = 0; v < vectors; v++)

/* asc_owen_reversed; the test of single points against runs holds that it is the same. */
ASC_INLINE void FOUR(hash)(asc_four *x, int vectors, const asc_four_key *key) {
  asc_four factors[3];
  for (int i = 0; i < 3; i++) FOUR(load)(asc_owen.factor[i], &factors[i]);
  EACH x[v] += key->added;
  EACH x[v] ^= PRODUCT(x[v], factors[0]) ^ key->turned;
  EACH x[v] ^= PRODUCT(x[v], key->factor);
  EACH x[v] += key->added_later;
  EACH x[v] ^= PRODUCT(x[v], factors[1]);
  EACH x[v] ^= PRODUCT(x[v], factors[2]);
}

/* asc_reverse_bits of each word, into the high halves; the low ones become 0. */
ASC_INLINE void FOUR(reverse)(asc_four *x, int vectors) {
  asc_four nibbles; /* of the high half */
  FOUR(load)(asc_owen.nibbles, &nibbles);
  EACH {
    const asc_four_bytes bytes = (asc_four_bytes)x[v];
    x[v] = (asc_four)__builtin_shufflevector(bytes, bytes, 7, 6, 5, 4, 3, 2, 1, 0, 15, 14, 13, 12, 11, 10, 9, 8, 23, 22,
                                             21, 20, 19, 18, 17, 16, 31, 30, 29, 28, 27, 26, 25, 24);
  }
#if ASC_HAS_LEVELS && defined(__AVX2__)
  /* The four bits of a nibble from a table, those of the upper one and of the lower one. */
  asc_four low, high;
  FOUR(load)(asc_owen.nibble_low, &low);
  FOUR(load)(asc_owen.nibble_high, &high);
  EACH x[v] = (asc_four)_mm256_shuffle_epi8((__m256i)low, (__m256i)((x[v] >> 4) & nibbles)) |
              (asc_four)_mm256_shuffle_epi8((__m256i)high, (__m256i)(x[v] & nibbles));
#else
  const asc_four zero = {0}, twos = zero + 0x3333333333333333u, ones = zero + 0x5555555555555555u;
  EACH x[v] = ((x[v] >> 4) & nibbles) | ((x[v] & nibbles) << 4);
  EACH x[v] = ((x[v] >> 2) & twos) | ((x[v] & twos) << 2);
  EACH x[v] = ((x[v] >> 1) & ones) | ((x[v] & ones) << 1);
#endif
}

/* What `reverse` gave to [0, 1), as asc_unit_of_bits. */
ASC_INLINE void FOUR(to_unit)(const asc_four *x, int vectors, double *values) {
  asc_four one;
  FOUR(load)(asc_owen.one, &one);
  EACH {
    const asc_four_doubles units = (asc_four_doubles)((x[v] >> 12) | one) - (asc_four_doubles)one;
    memcpy(values + (size_t)4 * (size_t)v, &units, sizeof units);
  }
}

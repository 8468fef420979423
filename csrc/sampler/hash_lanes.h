/* Philox of ASC_LANES samples side by side, as the static function LANES_FUNCTION. Included by hash.c alone, once for
 * each instruction set, whose macros say how wide its multiplication of 32 by 32 bits to 64 is.
 *
 * Each word of a counter lies in the low half of a 64-bit lane. The high halves hold what the products left there: no
 * multiplication reads them. */
#undef WIDTH
#undef PRODUCT
#undef IOTA
#undef LOW_HALVES
#undef HIGH_HALVES
#if defined(__AVX512F__)
#define WIDTH 8
#define PRODUCT(a, b) ((wide)_mm512_mul_epu32((__m512i)(a), (__m512i)(b)))
#define IOTA                                                                                                           \
  { 0, 1, 2, 3, 4, 5, 6, 7 }
#define LOW_HALVES 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30
#define HIGH_HALVES 1, 1, 3, 3, 5, 5, 7, 7, 9, 9, 11, 11, 13, 13, 15, 15
#elif defined(__AVX2__)
#define WIDTH 4
#define PRODUCT(a, b) ((wide)_mm256_mul_epu32((__m256i)(a), (__m256i)(b)))
#define IOTA                                                                                                           \
  { 0, 1, 2, 3 }
#define LOW_HALVES 0, 2, 4, 6, 8, 10, 12, 14
#define HIGH_HALVES 1, 1, 3, 3, 5, 5, 7, 7
#else
#define WIDTH 2
#define IOTA                                                                                                           \
  { 0, 1 }
#define LOW_HALVES 0, 2, 4, 6
#define HIGH_HALVES 1, 1, 3, 3
#if ASC_HAS_LEVELS
#define PRODUCT(a, b) ((wide)_mm_mul_epu32((__m128i)(a), (__m128i)(b)))
#else
#define PRODUCT(a, b) (((a)&UINT32_MAX) * ((b)&UINT32_MAX))
#endif
#endif

static void LANES_FUNCTION(asc_key key, uint64_t first, uint32_t index, uint32_t purpose, asc_lanes *lanes) {
  typedef uint64_t wide __attribute__((vector_size(8 * WIDTH)));
  typedef uint32_t packed __attribute__((vector_size(8 * WIDTH)));
  const wide zero = {0}, iota = IOTA, m0 = zero + MULTIPLIER_0, m1 = zero + MULTIPLIER_1;
  /* Two vectors at a time: their chains of products overlap, and they fit the registers. */
  for (uint32_t done = 0; done < ASC_LANES; done += 2 * WIDTH) {
    wide c[4][2];
    for (uint32_t j = 0; j < 2; j++) {
      c[0][j] = iota + (first + done + (uint64_t)j * WIDTH);
      c[1][j] = c[0][j] >> 32;
      c[2][j] = zero + index;
      c[3][j] = zero + purpose;
    }
    uint32_t k0 = key.word[0], k1 = key.word[1];
    /* A round waits for a product, the move of its high half (any unit can shuffle, few can shift), one exclusive or.
     */
    for (int round = 0; round < ROUNDS; round++) {
      for (int j = 0; j < 2; j++) {
        const wide p0 = PRODUCT(c[0][j], m0), p1 = PRODUCT(c[2][j], m1);
        c[0][j] = (wide)__builtin_shufflevector((packed)p1, (packed)p1, HIGH_HALVES) ^ (c[1][j] ^ k0);
        c[1][j] = p1;
        c[2][j] = (wide)__builtin_shufflevector((packed)p0, (packed)p0, HIGH_HALVES) ^ (c[3][j] ^ k1);
        c[3][j] = p0;
      }
      k0 += WEYL_0;
      k1 += WEYL_1;
    }
    for (int word = 0; word < 4; word++) {
      const packed low = __builtin_shufflevector((packed)c[word][0], (packed)c[word][1], LOW_HALVES);
      memcpy(&lanes->word[word][done], &low, sizeof low);
    }
  }
}
#undef LANES_FUNCTION

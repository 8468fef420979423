/* The bits of the patterns, as a digest each: the same from every instruction set (the sanitized variant is compiled
 * for the oldest alone, others take the newest that the machine has), every compiler and every later version. A pattern
 * that is changed on purpose gets its new digest here; a new one its first. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "hash.h"

#include "sampler_tools.h"

typedef struct sampler_bits {
  const char *spec;
  uint64_t samples;
  uint32_t dimensions;
  uint64_t digest;
} sampler_bits;

static const sampler_bits known[] = {
    {"random", 200, 7, 0x1ac5604fde4e5fb5u},
    {"regular", 196, 2, 0x77a69daff9ec31b8u},
    {"jittered", 196, 7, 0x21230f724b19e0fau},
    {"jittered", 36, 5, 0xbcd3fe542012ac0fu},
    {"halton", 5000, 7, 0x6c1ac23435efc15bu},
    {"halton:scramble=shift", 5000, 7, 0x9ad0513abf0bc11eu},
    {"halton:scramble=digit", 5000, 7, 0x1cfd27e2449a13acu},
    {"halton:scramble=owen", 5000, 40, 0x7775dd4184b35684u},
    {"sobol", 200, 7, 0xea37937ceb1f8b8du},
    {"sobol:scramble=shift", 200, 7, 0x80ef6a8a8923ff47u},
    {"sobol:scramble=digit", 200, 7, 0xc99b8bcdaef491eau},
    {"sobol:scramble=owen", 200, 7, 0xbcee90c61a1f32cbu},
    {"sobol:scramble=owen", 1000, 11, 0x460fbbd6f21ab60bu},
    {"sobol:scramble=owen-full", 200, 7, 0x3019d0da8876fa72u},
    {"sobol:scramble=owen-full", 1000, 11, 0x985299bf5fe05dbeu},
    {"hammersley", 200, 7, 0xd3f5b673a7939ffbu},
    {"hammersley:scramble=shift", 200, 7, 0xcf2b6d18453cba22u},
    {"hammersley:scramble=digit", 200, 7, 0x7d5adce1b493e92bu},
    {"hammersley:scramble=owen", 200, 7, 0xf3b0d26620cd8cefu},
    {"n-rooks", 200, 7, 0x1525f6da52b2d2e7u},
    {"n-rooks", 50, 7, 0x00fa84318628e4f3u},
    {"n-rooks:centred=1", 200, 7, 0x088f7e7ac0802503u},
    {"n-rooks:corner=1", 200, 7, 0xc79cdfb7a443cb27u},
    {"sgi-8x8", 8, 2, 0x9cfa7b0f439cec74u},
    {"standard-msaa", 16, 2, 0x7e024ce984490e45u},
    {"gauss-legendre", 64, 3, 0x43ee0657f160a8d6u},
    {"clenshaw-curtis", 64, 3, 0x716762bcfc1fc85cu},
    {"cook", 16, 3, 0xf4f5db375308a0acu},
    {"cook:centred=1", 16, 3, 0xeee9faabaaaaebeeu},
    {"pan-diagonal", 64, 3, 0xfa0ef6837a1aec84u},
    {"pan-diagonal:centred=1", 81, 3, 0x688d39d5d7e8f6a3u},
    {"mitchell-spacetime", 16, 3, 0x0d215953fcac9141u},
    {"mitchell-spacetime:centred=1", 64, 3, 0x47b7f6ed4b14899bu},
    {"zaremba", 64, 2, 0xbdc19e94068e5cbcu},
    {"zaremba:digits=finite", 64, 2, 0x1e44e0a45eb57275u},
    {"larcher-pillichshammer", 64, 2, 0x2ad279eca8a5ba61u},
    {"pmj02", 64, 3, 0x9a0a31d34a376dc4u},
    {"pmj02", 1000, 7, 0x0b79cfee15035ff7u},
    {"r2", 64, 3, 0xab905be73ba7ef0au},
    {"lattice", 55, 2, 0x773f69086e7337e7u},
    {"lattice", 64, 3, 0x5ab3d4a1a38c7d2du},
    {"latin-square", 64, 3, 0xe53a191f2e4e1e56u},
    {"latin-square", 64, 2, 0x131c5ee06a92ba8au},
    {"latin-square", 64, 5, 0xb872f5851ad93c41u},
    {"latin-square:centred=1", 64, 2, 0x99226422a4f7cf76u},
    {"n-queens", 64, 3, 0x3106ef78afac5fd2u},
    {"n-queens:centred=1", 64, 3, 0x975332e5f37f64edu},
    {"n-queens:solution=construction", 64, 3, 0x98112e2558a91098u},
    {"multi-jittered", 64, 3, 0x2f56847f54e38818u},
    {"multi-jittered", 60, 4, 0xb38afdfe09a8f5b6u},
    {"correlated-multi-jittered", 64, 3, 0xbc7c2a5d6f4230a7u},
    {"correlated-multi-jittered", 60, 4, 0xe7c005e943caa235u},
    {"orthogonal-array", 64, 3, 0x1b3d4a3a8783bc8bu},
    {"orthogonal-array:jitter=jittered", 49, 5, 0x36f48d61699d2fe6u},
    {"orthogonal-array:jitter=correlated", 81, 5, 0x0345615901ce8393u},
    {"orthogonal-array:strength=3", 64, 5, 0x7ef6591124d480b6u},
    {"orthogonal-array:strength=3,jitter=jittered", 27, 4, 0xe85dac9b534b1e1du},
    {"orthogonal-array:strength=3,jitter=correlated", 27, 4, 0x4be3630fadf8aed5u},
    {"poisson-disk", 64, 3, 0x4024e9e3e5b4693au},
    {"poisson-disk:toroidal=0", 64, 3, 0x0d8e3a7df3d864aeu},
    {"best-candidate", 16, 3, 0x23b26ec966d20d61u},
    {"blue-noise", 16, 3, 0x7ed512dd4f3589a2u},
    {"poisson-disk:radius=1,toroidal=0", 200, 3, 0x535a4a0840fe2f23u},
    /* end of the list */
};

#define MOST_VALUES (5000 * 40)
static double points[MOST_VALUES];

/* FNV-1a of 64 bits (Fowler, Noll, Vo), over the words of values from the low byte up. */
static uint64_t add_words(uint64_t digest, size_t count) {
  for (size_t i = 0; i < count; i++) {
    uint64_t bits;
    memcpy(&bits, &points[i], sizeof bits);
    for (int byte = 0; byte < 8; byte++) digest = (digest ^ ((bits >> (8 * byte)) & 255u)) * 0x100000001b3u;
  }
  return digest;
}

/* Of two pixels in one call each, the second without its first sample and dimension, and of single samples. */
static uint64_t digest_of(const sampler_bits *one) {
  const uint64_t n = one->samples;
  const uint32_t d = one->dimensions;
  asc_sampler *sampler = make(one->spec, n, d, UINT64_MAX - 2);
  fill(sampler, 3, -7, 0, (size_t)n, 0, d, points);
  uint64_t digest = add_words(0xcbf29ce484222325u, (size_t)n * d);
  fill(sampler, INT32_MAX, INT32_MIN, 1, (size_t)n - 1, 1, d - 1, points);
  digest = add_words(digest, (size_t)(n - 1) * (d - 1));
  for (uint64_t i = 0; i < n; i += 13) {
    fill(sampler, 0, 0, i, 1, 0, d, points);
    digest = add_words(digest, d);
  }
  asc_sampler_destroy(sampler);
  return digest;
}

static void every_pattern_keeps_its_bits(void **state) {
  (void)state;
  int different = 0;
  for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
    const uint64_t digest = digest_of(&known[k]);
    if (digest == known[k].digest) continue;
    different++;
    print_error("%s, N = %llu, %u dimensions: 0x%016llx\n", known[k].spec, (unsigned long long)known[k].samples,
                known[k].dimensions, (unsigned long long)digest);
  }
  assert_int_equal(different, 0);
}

/* Across a carry into the high word. */
static void the_hash_is_the_same_on_every_level(void **state) {
  (void)state;
  const int levels[] = {0, 3, 4};
  const asc_key key = asc_stream_key(9, -2, 4);
  for (size_t k = 0; k < 3; k++) {
    asc_lanes lanes;
    if (!asc_hash_lanes_of_level(levels[k], key, UINT32_MAX - 7, 5, ASC_PURPOSE_UNIFORM, &lanes)) continue;
    for (uint32_t i = 0; i < ASC_LANES; i++) {
      const asc_block block = asc_hash(key, (uint64_t)UINT32_MAX - 7 + i, 5, ASC_PURPOSE_UNIFORM);
      for (int word = 0; word < 4; word++) assert_int_equal(lanes.word[word][i], block.word[word]);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(the_hash_is_the_same_on_every_level),
                                     cmocka_unit_test(every_pattern_keeps_its_bits)};
  return cmocka_run_group_tests_name("sampler bits", tests, NULL, NULL);
}

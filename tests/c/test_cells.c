/* What block designs are made of: points of cells, and families of permutations. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "cell.h"
#include "permutation_family.h"

/* At both ends of cells, of 1 to 2^32 of them. */
static void points_of_a_cell_lie_in_it(void **state) {
  (void)state;
  const uint32_t bits[] = {0, UINT32_MAX};
  for (uint64_t power = 1; power < (uint64_t)1 << 32; power *= 2)
    for (uint64_t cells = 2 * power - 1; cells <= 2 * power + 1 && cells <= (uint64_t)1 << 32; cells++)
      for (size_t end = 0; end < 2; end++) {
        const uint64_t some[] = {0, cells / 3, cells - cells / 7 - 1, cells - 1};
        for (size_t k = 0; k < 4; k++)
          assert_true((uint64_t)(asc_in_cell(some[k], cells, bits[end]) * (double)cells) == some[k]);
      }
}

/* A few samples are hashed one by one, more of them side by side. */
static void bits_of_few_samples_are_those_of_many(void **state) {
  (void)state;
  const asc_key key = asc_stream_key(4, 5, 6);
  asc_lanes few, many;
  asc_cell_bits(key, 100, ASC_LANES, 7, &many);
  for (size_t i = 0; i + 3 <= ASC_LANES; i++) {
    asc_cell_bits(key, 100 + i, 3, 7, &few);
    for (size_t k = 0; k < 3; k++)
      for (size_t word = 0; word < 4; word++) assert_int_equal(few.word[word][k], many.word[word][i + k]);
  }
}

/* Members that are kept and those that are not: permutations all, the same when asked again, no two alike. Two of 100
 * elements agree in more than 12 places with probability 1e-10. */
static void members_of_a_family_are_different_permutations(void **state) {
  (void)state;
  enum { SIZE = 100, MEMBERS = 130 };
  static uint64_t at[MEMBERS][SIZE];
  asc_permutation_family family;
  asc_permutation_family_begin(&family, SIZE, asc_stream_key(1, 1, 1), 2);
  for (uint32_t member = 0; member < MEMBERS; member++) {
    unsigned char seen[SIZE] = {0};
    for (uint64_t i = 0; i < SIZE; i++) {
      at[member][i] = asc_permutation_family_at(&family, member, i);
      assert_true(at[member][i] < SIZE);
      assert_int_equal(seen[at[member][i]]++, 0);
    }
    for (uint32_t other = 0; other < member; other++) {
      int agree = 0;
      for (size_t i = 0; i < SIZE; i++) agree += at[member][i] == at[other][i];
      assert_true(agree <= 12);
    }
  }
  for (uint32_t member = 0; member < MEMBERS; member++)
    assert_int_equal(asc_permutation_family_at(&family, member, 7), at[member][7]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(points_of_a_cell_lie_in_it),
      cmocka_unit_test(bits_of_few_samples_are_those_of_many),
      cmocka_unit_test(members_of_a_family_are_different_permutations),
  };
  return cmocka_run_group_tests_name("cells", tests, NULL, NULL);
}

/* Samplers that are made of another's by groups of dimensions. */
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "sampler_cases.h"
#include "sampler_tools.h"
#include "threads_alone.h"

static const uint32_t groups[] = {2, 1, 2, 2};
#define GROUPS (sizeof groups / sizeof *groups)
#define DIMENSIONS 7
#define MOST 100

static asc_status try_arrange(const char *spec, uint64_t samples, uint64_t seed, const uint32_t *sizes, size_t count,
                              asc_arrangement how, uint32_t sequential, asc_sampler **made, asc_error *error) {
  const asc_arrangement_desc desc = {sizeof desc, spec, samples, seed, sizes, count, how, sequential};
  return asc_sampler_arrange(&desc, made, error);
}

static asc_sampler *arrange(const char *spec, uint64_t samples, uint64_t seed, asc_arrangement how) {
  asc_sampler *made = NULL;
  asc_error error = {{0}};
  if (try_arrange(spec, samples, seed, groups, GROUPS, how, 0, &made, &error)) fail_msg("%s: %s", spec, error.text);
  return made;
}

static const asc_arrangement arranged[] = {ASC_ARRANGEMENT_PADDED, ASC_ARRANGEMENT_DECORRELATED};

/* The cases that have such groups: all but quadrature rules and counts that are no squares. */
static int has_groups(const sampler_case *one) {
  asc_sampler *made = NULL;
  const asc_status status =
      try_arrange(one->spec, one->samples, 0, groups, GROUPS, ASC_ARRANGEMENT_PADDED, 0, &made, NULL);
  asc_sampler_destroy(made);
  return status == ASC_OK;
}

static void nearly_every_sampler_can_be_arranged(void **state) {
  (void)state;
  size_t refused = 0;
  for (size_t k = 0; k < CASES; k++) refused += !has_groups(&cases[k]);
  assert_true(refused <= 2); /* the quadrature rules */
}

static void pieces_in_any_order_equal_all_at_once(void **state) {
  (void)state;
  for (size_t k = 0; k < CASES; k++)
    for (size_t a = 0; a < 2; a++) {
      if (!has_groups(&cases[k])) continue;
      const size_t samples = cases[k].samples;
      asc_sampler *made = arrange(cases[k].spec, samples, 9, arranged[a]);
      double all[MOST * DIMENSIONS], piece[7 * DIMENSIONS];
      fill(made, 11, -7, 0, samples, 0, DIMENSIONS, all);
      for (size_t i = 0; i < samples * DIMENSIONS; i++) assert_true(all[i] >= 0.0 && (float)all[i] < 1.0f);
      for (size_t first = samples; first-- > 0;) {
        const size_t count = samples - first < 7 ? samples - first : 7;
        const uint32_t from = (uint32_t)first % DIMENSIONS, columns = 1 + (uint32_t)first % (DIMENSIONS - from);
        fill(made, 11, -7, first, count, from, columns, piece);
        for (size_t i = 0; i < count; i++)
          assert_memory_equal(piece + i * columns, all + (first + i) * DIMENSIONS + from, columns * sizeof *all);
      }
      asc_sampler_destroy(made);
    }
}

/* A few of many samples are made one by one, most of them together. */
static void few_of_many_samples_are_the_same(void **state) {
  (void)state;
  enum { SAMPLES = 4096 };
  asc_sampler *made = arrange("sobol:scramble=owen", SAMPLES, 2, ASC_ARRANGEMENT_PADDED);
  double *all = malloc(SAMPLES * DIMENSIONS * sizeof *all), one[DIMENSIONS];
  assert_non_null(all);
  fill(made, 0, 0, 0, SAMPLES, 0, DIMENSIONS, all);
  for (size_t i = 0; i < SAMPLES; i++) {
    fill(made, 0, 0, i, 1, 0, DIMENSIONS, one);
    assert_memory_equal(one, all + i * DIMENSIONS, sizeof one);
  }
  free(all);
  asc_sampler_destroy(made);
}

typedef struct thread_work {
  const asc_sampler *sampler;
  double points[16][64 * DIMENSIONS];
} thread_work;

static void *fill_pixels(void *argument) {
  thread_work *work = argument;
  for (int32_t pixel = 0; pixel < 16; pixel++) {
    const asc_range range = {pixel, 3, 0, 64, 0, DIMENSIONS};
    (void)asc_sampler_fill(work->sampler, &range, work->points[pixel]);
  }
  return NULL;
}

static void threads_give_the_same_bits(void **state) {
  (void)state;
  for (size_t a = 0; a < 2; a++) {
    asc_sampler *made = arrange("jittered", 64, 1, arranged[a]);
    static thread_work work[3];
    memset(work, 0, sizeof work);
    pthread_t threads[3];
    for (int t = 0; t < 3; t++) {
      work[t].sampler = made;
      assert_int_equal(pthread_create(&threads[t], NULL, fill_pixels, &work[t]), 0);
    }
    for (int t = 0; t < 3; t++) assert_int_equal(pthread_join(threads[t], NULL), 0);
    for (int t = 1; t < 3; t++) assert_memory_equal(work[0].points, work[t].points, sizeof work[0].points);
    assert_memory_not_equal(work[0].points[0], work[0].points[1], sizeof work[0].points[0]);
    asc_sampler_destroy(made);
  }
}

static void joint_is_the_sampler_itself(void **state) {
  (void)state;
  asc_sampler *made = arrange("sobol:scramble=owen", 64, 5, ASC_ARRANGEMENT_JOINT);
  double points[64 * DIMENSIONS], plain[64 * DIMENSIONS];
  fill(made, 0, 0, 0, 64, 0, DIMENSIONS, points);
  points_of("sobol:scramble=owen", 64, DIMENSIONS, 5, plain);
  assert_memory_equal(points, plain, sizeof plain);
  asc_sampler_destroy(made);
}

static void the_first_group_is_the_sampler_itself(void **state) {
  (void)state;
  double points[64 * 2], plain[64 * 2];
  points_of("halton:scramble=digit", 64, 2, 5, plain);
  for (size_t a = 0; a < 2; a++) {
    asc_sampler *made = arrange("halton:scramble=digit", 64, 5, arranged[a]);
    fill(made, 0, 0, 0, 64, 0, 2, points);
    assert_memory_equal(points, plain, sizeof plain);
    asc_sampler_destroy(made);
  }
}

static int ascending(const void *one, const void *other) { return memcmp(one, other, 2 * sizeof(double)); }

/* Where nothing is randomised but the order, each group has the very points of the sampler. */
static void groups_have_the_points_of_the_sampler(void **state) {
  (void)state;
  const char *const specs[] = {"hammersley", "regular", "halton", "sobol", "r2"};
  for (size_t s = 0; s < 5; s++)
    for (size_t a = 0; a < 2; a++) {
      double plain[64][2], line[64], points[64][2];
      points_of(specs[s], 64, 2, 0, &plain[0][0]);
      points_of(specs[s], 64, 1, 0, line);
      qsort(plain, 64, sizeof *plain, ascending);
      asc_sampler *made = arrange(specs[s], 64, 12, arranged[a]);
      assert_true(asc_sampler_traits(made) & ASC_TRAIT_RANDOMISED);
      for (uint32_t dimension = 3; dimension < DIMENSIONS; dimension += 2) {
        fill(made, 4, 4, 0, 64, dimension, 2, &points[0][0]);
        qsort(points, 64, sizeof *points, ascending);
        assert_memory_equal(points, plain, sizeof plain);
      }
      double times[64];
      fill(made, 4, 4, 0, 64, 2, 1, times);
      for (size_t i = 0; i < 64; i++) {
        size_t found = 0;
        for (size_t k = 0; k < 64; k++) found += times[k] == line[i];
        assert_int_equal(found, 1);
      }
      asc_sampler_destroy(made);
    }
}

/* Of 2^m samples from `first` on, whether each elementary interval of the group at `dimension` has one point. */
static void assert_net(const asc_sampler *made, uint64_t first, uint32_t digits, uint32_t dimension) {
  const size_t count = (size_t)1 << digits;
  double points[256][2];
  fill(made, 1, 2, first, count, dimension, 2, &points[0][0]);
  for (uint32_t k = 0; k <= digits; k++) {
    unsigned char met[256] = {0};
    for (size_t i = 0; i < count; i++) {
      const size_t column = (size_t)(points[i][0] * (double)(1u << k));
      const size_t row = (size_t)(points[i][1] * (double)(1u << (digits - k)));
      assert_int_equal(met[row << k | column]++, 0);
    }
  }
}

static void groups_keep_their_stratification(void **state) {
  (void)state;
  for (size_t a = 0; a < 2; a++) {
    asc_sampler *made = arrange("sobol:scramble=owen", 256, 3, arranged[a]);
    for (uint32_t dimension = 3; dimension < DIMENSIONS; dimension += 2) assert_net(made, 0, 8, dimension);
    double times[256];
    fill(made, 1, 2, 0, 256, 2, 1, times);
    unsigned char met[256] = {0};
    for (size_t i = 0; i < 256; i++) assert_int_equal(met[(size_t)(times[i] * 256.0)]++, 0);
    asc_sampler_destroy(made);
  }
}

static asc_sampler *padded_sequence(const char *spec, uint64_t samples) {
  asc_sampler *made = NULL;
  assert_int_equal(try_arrange(spec, samples, 8, groups, GROUPS, ASC_ARRANGEMENT_PADDED, 1, &made, NULL), ASC_OK);
  return made;
}

static void a_padded_sequence_stays_one(void **state) {
  (void)state;
  asc_sampler *few = padded_sequence("sobol:scramble=owen", 16), *many = padded_sequence("sobol:scramble=owen", 1000);
  assert_true(asc_sampler_traits(few) & ASC_TRAIT_SEQUENCE);
  double short_one[40 * DIMENSIONS], long_one[40 * DIMENSIONS];
  fill(few, 0, 0, 0, 40, 0, DIMENSIONS, short_one);
  fill(many, 0, 0, 0, 40, 0, DIMENSIONS, long_one);
  assert_memory_equal(short_one, long_one, sizeof long_one);
  /* The first 2^m points of each group are a net, and so are aligned blocks of fewer. */
  for (uint32_t digits = 0; digits <= 6; digits++)
    for (uint32_t dimension = 3; dimension < DIMENSIONS; dimension += 2) {
      assert_net(few, 0, digits, dimension);
      assert_net(few, (uint64_t)3 << digits, digits, dimension);
    }
  double last[DIMENSIONS];
  fill(few, 0, 0, UINT32_MAX, 1, 0, DIMENSIONS, last);
  const asc_range past = {0, 0, (uint64_t)1 << 32, 1, 0, DIMENSIONS};
  assert_int_equal(asc_sampler_fill(few, &past, last), ASC_UNSUPPORTED);
  asc_sampler_destroy(few);
  asc_sampler_destroy(many);
  few = padded_sequence("jittered", 16); /* which is no sequence */
  assert_false(asc_sampler_traits(few) & ASC_TRAIT_SEQUENCE);
  asc_sampler_destroy(few);
}

#define SEEDS 20000
#define CELLS 4

static uint32_t met[16][CELLS][CELLS];

/* Chi-squared of the independence of the two dimensions of a table, and of the evenness of the second. */
static void chi_squared(const uint32_t table[CELLS][CELLS], double *independence, double *evenness) {
  double rows[CELLS] = {0}, columns[CELLS] = {0};
  for (size_t i = 0; i < CELLS; i++)
    for (size_t k = 0; k < CELLS; k++) {
      rows[i] += table[i][k];
      columns[k] += table[i][k];
    }
  *independence = *evenness = 0.0;
  for (size_t k = 0; k < CELLS; k++) {
    const double even = (double)SEEDS / CELLS;
    *evenness += (columns[k] - even) * (columns[k] - even) / even;
    for (size_t i = 0; i < CELLS; i++) {
      const double expected = rows[i] * columns[k] / SEEDS;
      if (expected > 0.0)
        *independence += ((double)table[i][k] - expected) * ((double)table[i][k] - expected) / expected;
    }
  }
}

/* Sample by sample, over all seeds and pixels, a further group's place is even, and independent of the first's and of
 * the other groups'. Chi-squared with 3 degrees of freedom exceeds 45 and with 9 exceeds 62 with probability 1e-9 each;
 * there are 2 x 3 x 2 x 16 of each. */
static void every_sample_meets_all_of_a_group(void **state) {
  (void)state;
  const uint32_t pairs[][2] = {{0, 2}, {0, 3}, {1, 4}, {1, 2}, {0, 5}, {1, 6}, {2, 3}, {2, 4},
                               {2, 5}, {2, 6}, {3, 5}, {3, 6}, {4, 5}, {4, 6}, {0, 4}, {1, 3}};
  const char *const specs[] = {"random", "jittered", "sobol:scramble=owen"};
  for (size_t s = 0; s < 3; s++)
    for (size_t a = 0; a < 2; a++)
      for (size_t sample = 0; sample < 16; sample += 11) {
        memset(met, 0, sizeof met);
        for (uint64_t seed = 0; seed < SEEDS / 20; seed++) {
          asc_sampler *made = arrange(specs[s], 16, seed, arranged[a]);
          for (int32_t pixel = 0; pixel < 20; pixel++) {
            double point[DIMENSIONS];
            fill(made, pixel, 1, sample, 1, 0, DIMENSIONS, point);
            for (size_t p = 0; p < 16; p++)
              met[p][(size_t)(point[pairs[p][0]] * CELLS)][(size_t)(point[pairs[p][1]] * CELLS)]++;
          }
          asc_sampler_destroy(made);
        }
        for (size_t p = 0; p < 16; p++) {
          double independence, evenness;
          chi_squared((const uint32_t(*)[CELLS])met[p], &independence, &evenness);
          if (independence > 62.0 || evenness > 45.0)
            fail_msg("%s, arrangement %d, sample %zu, dimensions %u and %u: chi-squared %g, %g", specs[s],
                     (int)arranged[a], sample, pairs[p][0], pairs[p][1], independence, evenness);
        }
      }
}

/* The samples of one pixel: the same points in two groups, as of a pattern that is not randomised, do not go together.
 * The correlation over 1024 samples has a standard deviation of 1/32 where the order is random; 6 of it. */
static void shuffling_parts_patterns_that_are_the_same(void **state) {
  (void)state;
  const char *const specs[] = {"hammersley", "regular", "sobol"};
  enum { SAMPLES = 1024 };
  static double points[SAMPLES][DIMENSIONS];
  for (size_t s = 0; s < 3; s++) {
    asc_sampler *made = arrange(specs[s], SAMPLES, 4, ASC_ARRANGEMENT_PADDED);
    fill(made, 0, 0, 0, SAMPLES, 0, DIMENSIONS, &points[0][0]);
    for (uint32_t one = 0; one < DIMENSIONS; one++)
      for (uint32_t other = one + 1; other < DIMENSIONS; other++) {
        double sum = 0.0;
        for (size_t i = 0; i < SAMPLES; i++) sum += 12.0 * (points[i][one] - 0.5) * (points[i][other] - 0.5);
        const int together = one % 2 == 0 ? one == 0 && other == 1 : one > 2 && other == one + 1;
        if (!together) assert_true(fabs(sum / SAMPLES) < 6.0 / 32.0);
      }
    asc_sampler_destroy(made);
  }
}

/* Along the Hilbert curve of a 4 x 4 grid, ranks in time are radical inverses of places, rotated, digits flipped. */
static void nearby_in_space_is_far_in_time(void **state) {
  (void)state;
  static const uint8_t curve[16][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 2}, {0, 3}, {1, 3}, {1, 2},
                                       {2, 2}, {2, 3}, {3, 3}, {3, 2}, {3, 1}, {2, 1}, {2, 0}, {3, 0}};
  for (uint64_t seed = 0; seed < 20; seed++) {
    asc_sampler *made = arrange("regular", 16, seed, ASC_ARRANGEMENT_DECORRELATED);
    double points[16][3];
    fill(made, 5, 6, 0, 16, 0, 3, &points[0][0]);
    uint32_t rank[16] = {0};
    for (uint32_t k = 0; k < 16; k++)
      for (uint32_t i = 0; i < 16; i++)
        if ((uint8_t)(4.0 * points[i][0]) == curve[k][0] && (uint8_t)(4.0 * points[i][1]) == curve[k][1])
          rank[k] = (uint32_t)(16.0 * points[i][2]);
    int found = 0;
    for (uint32_t parameters = 0; parameters < 16 * 16 * 16; parameters++) {
      const uint32_t first = parameters % 16, turned = parameters / 16 % 16, further = parameters / 256;
      uint32_t same = 0;
      for (uint32_t k = 0; k < 16; k++) {
        const uint32_t place = (k + first) % 16;
        const uint32_t inverse = (place & 1) << 3 | (place & 2) << 1 | (place & 4) >> 1 | place >> 3;
        same += ((inverse ^ turned) + further) % 16 == rank[k];
      }
      found |= same == 16;
    }
    assert_true(found);
    asc_sampler_destroy(made);
  }
}

static void many_groups_are_no_copies_of_each_other(void **state) {
  (void)state;
  enum { MANY = 40, SAMPLES = 64 };
  uint32_t sizes[MANY];
  for (size_t g = 0; g < MANY; g++) sizes[g] = g ? 1 : 2;
  asc_sampler *made = NULL;
  assert_int_equal(try_arrange("regular", SAMPLES, 3, sizes, MANY, ASC_ARRANGEMENT_DECORRELATED, 0, &made, NULL),
                   ASC_OK);
  static double points[SAMPLES][MANY + 1];
  fill(made, 0, 0, 0, SAMPLES, 0, MANY + 1, &points[0][0]);
  /* Ranks of different bases: of random orders, the correlation would have the standard deviation 1/8. */
  for (uint32_t one = 2; one <= MANY; one++)
    for (uint32_t other = one + 1; other <= MANY; other++) {
      double sum = 0.0;
      for (size_t i = 0; i < SAMPLES; i++) sum += 12.0 * (points[i][one] - 0.5) * (points[i][other] - 0.5);
      assert_true(fabs(sum / SAMPLES) < 5.5 / 8.0);
    }
  asc_sampler_destroy(made);
}

static void patterns_of_space_and_time_drive_three_dimensions(void **state) {
  (void)state;
  const char *const specs[] = {"cook", "pan-diagonal", "mitchell-spacetime"};
  for (size_t s = 0; s < 3; s++)
    for (size_t a = 0; a < 2; a++) {
      asc_sampler *made = arrange(specs[s], 16, 6, arranged[a]);
      double plain[16 * 3], points[16 * 3], lens[16][2];
      points_of(specs[s], 16, 3, 6, plain);
      fill(made, 0, 0, 0, 16, 0, 3, points);
      assert_memory_equal(points, plain, sizeof plain);
      fill(made, 0, 0, 0, 16, 5, 2, &lens[0][0]);
      int cells_met[16] = {0};
      for (size_t i = 0; i < 16; i++) cells_met[(size_t)(4.0 * lens[i][0]) + 4 * (size_t)(4.0 * lens[i][1])]++;
      for (size_t i = 0; i < 16; i++) assert_int_equal(cells_met[i], 1); /* jittered */
      asc_sampler_destroy(made);
    }
}

static void what_is_refused(void **state) {
  (void)state;
  const uint32_t none[] = {2, 0}, lens[] = {2, 2};
  asc_sampler *made = NULL;
  asc_error error = {{0}};
  assert_int_equal(try_arrange("sobol", 16, 0, NULL, 1, ASC_ARRANGEMENT_PADDED, 0, &made, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_arrange("sobol", 16, 0, groups, 0, ASC_ARRANGEMENT_PADDED, 0, &made, NULL),
                   ASC_INVALID_ARGUMENT);
  assert_int_equal(try_arrange("sobol", 16, 0, none, 2, ASC_ARRANGEMENT_PADDED, 0, &made, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_arrange("sobol", 16, 0, groups, 4, (asc_arrangement)3, 0, &made, NULL), ASC_INVALID_ARGUMENT);
  assert_int_equal(try_arrange("soboll", 16, 0, groups, 4, ASC_ARRANGEMENT_PADDED, 0, &made, NULL), ASC_UNKNOWN_NAME);
  assert_int_equal(try_arrange("sobol", 16385, 0, groups, 4, ASC_ARRANGEMENT_DECORRELATED, 0, &made, &error),
                   ASC_UNSUPPORTED);
  assert_non_null(strstr(error.text, "16384"));
  assert_int_equal(try_arrange("gauss-legendre", 16, 0, groups, 4, ASC_ARRANGEMENT_PADDED, 0, &made, &error),
                   ASC_UNSUPPORTED);
  assert_non_null(strstr(error.text, "dimensions=joint"));
  assert_int_equal(try_arrange("cook", 16, 0, lens, 2, ASC_ARRANGEMENT_PADDED, 0, &made, NULL), ASC_UNSUPPORTED);
  assert_int_equal(try_arrange("regular", 16, 0, groups, 4, ASC_ARRANGEMENT_JOINT, 0, &made, &error), ASC_UNSUPPORTED);
  assert_non_null(strstr(error.text, "dimensions=padded"));
  assert_int_equal(try_arrange("cook", 15, 0, groups, 4, ASC_ARRANGEMENT_JOINT, 0, &made, &error), ASC_UNSUPPORTED);
  assert_null(strstr(error.text, "dimensions=padded"));
  assert_null(made);
}

static void the_desc_can_be_read_back(void **state) {
  (void)state;
  asc_sampler *made = arrange("n-rooks:centred=0", 16, 7, ASC_ARRANGEMENT_PADDED);
  asc_arrangement_desc desc;
  assert_int_equal(asc_sampler_arranged(made, &desc), ASC_OK);
  assert_string_equal(desc.spec, "n-rooks");
  assert_int_equal(desc.samples, 16);
  assert_int_equal(desc.seed, 7);
  assert_int_equal(desc.arrangement, ASC_ARRANGEMENT_PADDED);
  assert_int_equal(desc.group_count, GROUPS);
  assert_memory_equal(desc.groups, groups, sizeof groups);
  asc_sampler_desc resolved;
  assert_int_equal(asc_sampler_resolved(made, &resolved), ASC_OK);
  assert_int_equal(resolved.dimensions, DIMENSIONS);
  double weights[16];
  assert_int_equal(asc_sampler_weights(made, 0, 16, weights), ASC_OK);
  assert_true(weights[15] == 1.0 / 16.0);
  asc_sampler_destroy(made);
  made = make("sobol", 16, 5, 7);
  assert_int_equal(asc_sampler_arranged(made, &desc), ASC_OK);
  assert_int_equal(desc.arrangement, ASC_ARRANGEMENT_JOINT);
  assert_null(desc.groups);
  asc_sampler_destroy(made);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nearly_every_sampler_can_be_arranged),
      cmocka_unit_test(pieces_in_any_order_equal_all_at_once),
      cmocka_unit_test(few_of_many_samples_are_the_same),
      cmocka_unit_test(threads_give_the_same_bits),
      cmocka_unit_test(joint_is_the_sampler_itself),
      cmocka_unit_test(the_first_group_is_the_sampler_itself),
      cmocka_unit_test(groups_have_the_points_of_the_sampler),
      cmocka_unit_test(groups_keep_their_stratification),
      cmocka_unit_test(a_padded_sequence_stays_one),
      cmocka_unit_test(every_sample_meets_all_of_a_group),
      cmocka_unit_test(shuffling_parts_patterns_that_are_the_same),
      cmocka_unit_test(nearby_in_space_is_far_in_time),
      cmocka_unit_test(many_groups_are_no_copies_of_each_other),
      cmocka_unit_test(patterns_of_space_and_time_drive_three_dimensions),
      cmocka_unit_test(what_is_refused),
      cmocka_unit_test(the_desc_can_be_read_back),
  };
  take_threads_alone();
  return cmocka_run_group_tests(tests, NULL, NULL);
}

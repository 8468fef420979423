/* Lobes of sixteen lanes: the elementary functions that they are made of, and that samples follow their densities. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "arithmetic.h"
#include "concentric.h"
#include "hash.h"
#include "lobe.h"

static double random_unit(uint64_t *state) { return (double)(asc_mix64((*state)++ * ASC_GOLDEN) >> 11) * 0x1p-53; }

/* `share` of what is there. */
static void assert_near(const char *what, double x, double found, long double there, long double share) {
  if (!(fabsl(found - there) <= share * fabsl(there)))
    fail_msg("%s at %.17g: %.17g, off by %Lg of it", what, x, found, fabsl((found - there) / there));
}

/* By mpmath with 300 bits. */
static void elementary_functions_are_those_of_mpmath(void **state) {
  (void)state;
  static const struct {
    double x;
    long double there;
  } logs[] = {{-0x1.56e1fc2f8f359p-997, -1.0000000000000000251e-300L},
              {-0x1.0000000000000p-53, -1.1102230246251566021e-16L},
              {-0x1.b7cdfd9d7bdbbp-34, -1.0000000000500000364e-10L},
              {-0x1.0000000000000p-2, -0.28768207245178092744L},
              {-0x1.2bec333018868p-2, -0.34657359027997274336L},
              {-0x1.0000000000000p-1, -0.69314718055994530942L},
              {-0x1.6a09e667f3bcdp-1, -1.227947177299515845L},
              {-0x1.ff7ced916872bp-1, -6.9077552789821361639L},
              {-0x1.fffffffffffffp-1, -36.736800569677101399L}},
    exponentials[] = {{-0x1.56e1fc2f8f359p-997, -1.0000000000000000251e-300L},
                      {-0x1.0000000000000p-40, -9.0949470177251464761e-13L},
                      {-0x1.62e42fefa39efp-2, -0.2928932188134524674L},
                      {-0x1.62e42fefa39f0p-2, -0.29289321881345250665L},
                      {-0x1.62e42fefa39efp-1, -0.4999999999999999884L},
                      {-0x1.0000000000000p+0, -0.6321205588285576784L},
                      {-0x1.6000000000000p+2, -0.99591322856153593301L},
                      {-0x1.2600000000000p+5, -0.99999999999999989043L},
                      {-0x1.d800000000000p+5, -1.0L},
                      {-0x1.9000000000000p+7, -1.0L}};
  static const struct {
    double base, exponent;
    long double there;
  } powers[] = {{0x1.0000000000000p-1, 1.0, 0.5L},
                {0x1.fffeb074a771dp-1, 1e6, 0.000045397659809679106972L},
                {0x1.fffffffffffffp-1, 1e6, 0.99999999988897769754L},
                {0x1.a09d495182a99p-1, 0x1.129999999999ap+7, 5.0903844809583132387e-13L},
                {0x1.47ae147ae147bp-7, 3.5, 1.0000000000000000729e-7L},
                {0x1.ccccccccccccdp-1, 2000.0, 3.0550539125986596938e-92L},
                {1.0, 1e6, 1.0L}};
  for (size_t i = 0; i < sizeof logs / sizeof *logs; i++)
    assert_near("log_of_one_plus", logs[i].x, log_of_one_plus(logs[i].x), logs[i].there, 2e-16L);
  for (size_t i = 0; i < sizeof exponentials / sizeof *exponentials; i++)
    assert_near("exponential_less_one", exponentials[i].x, exponential_less_one(exponentials[i].x),
                exponentials[i].there, 2.5e-16L);
  for (size_t i = 0; i < sizeof powers / sizeof *powers; i++)
    assert_near("power_of_fraction", powers[i].base, power_of_fraction(powers[i].base, powers[i].exponent),
                powers[i].there, 3e-16L * (1.0L - logl(powers[i].there)));
}

static void elementary_functions_have_their_limits(void **state) {
  (void)state;
  assert_true(log_of_one_plus(0.0) == 0.0 && log_of_one_plus(-1.0) == -INFINITY);
  assert_true(exponential_less_one(0.0) == 0.0 && exponential_less_one(-INFINITY) == -1.0);
  assert_true(power_of_fraction(0.25, 0.0) == 1.0 && power_of_fraction(0.01, 1e6) == 0.0);
  assert_true(power_of_fraction(exp(-699.0), 1.0) > 0.0 && power_of_fraction(exp(-701.0), 1.0) == 0.0);
}

/* The C library's long doubles are off by 2^-63 or so. The largest of 2 x 10^7 such differences were 1.5e-16, 2.1e-16
 * and 2.5e-16 (1 + |log|). */
static void elementary_functions_are_within_what_is_said(void **state) {
  (void)state;
  uint64_t numbers = 1;
  for (int i = 0; i < 200000; i++) {
    const double u = random_unit(&numbers), v = random_unit(&numbers), w = random_unit(&numbers);
    const double x = -u * pow(2.0, -(i % 40)), y = -v * pow(2.0, 5 - i % 40);
    const double base = i % 2 ? w : 1.0 - w * pow(2.0, -(i % 30)), exponent = 1.0 + v * pow(2.0, i % 21);
    const long double power = powl(base, exponent), logarithm = fabsl(exponent * logl(base));
    if (u > 0.0) assert_near("log_of_one_plus", x, log_of_one_plus(x), log1pl(x), 2e-16L);
    assert_near("exponential_less_one", y, exponential_less_one(y), expm1l(y), 2.5e-16L);
    if (logarithm < 690.0L)
      assert_near("power_of_fraction", base, power_of_fraction(base, exponent), power, 3e-16L * (1.0L + logarithm));
  }
}

/* What points of discs are made of. */
static void eighths_of_turns_are_within_two_roundings(void **state) {
  (void)state;
  uint64_t numbers = 3;
  for (int i = 0; i < 100000; i++) {
    const double x = (2.0 * random_unit(&numbers) - 1.0) * (ASC_PI / 4.0) * pow(2.0, -(i % 20));
    double sine, cosine;
    asc_eighth_turn(x, &sine, &cosine);
    assert_near("sine", x, sine, sinl(x), 0x1p-52L);
    assert_near("cosine", x, cosine, cosl(x), 0x1p-52L);
  }
}

/* --- lobes ----------------------------------------------------------------------------------------------------------
 */

static const asc_lobe lobes[] = {
    {.kind = ASC_LOBE_PHONG, .exponent = 1.0},   {.kind = ASC_LOBE_PHONG, .exponent = 137.3},
    {.kind = ASC_LOBE_PHONG, .exponent = 1e6},   {.kind = ASC_LOBE_GGX, .roughness = 1.0},
    {.kind = ASC_LOBE_GGX, .roughness = 0.1137}, {.kind = ASC_LOBE_GGX, .roughness = 1e-3}};

static void random_direction(uint64_t *numbers, double way[3]) {
  const double z = 2.0 * random_unit(numbers) - 1.0, out = sqrt(1.0 - z * z),
               turn = 2.0 * ASC_PI * random_unit(numbers);
  way[0] = out * cos(turn);
  way[1] = out * sin(turn);
  way[2] = z;
}

/* Lanes with normals and ways to the eye before them, in one lane along the normal, in one along the surface. */
static void set_lanes(uint64_t *numbers, vectors *normal, vectors *to_eye, pairs *u) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    double facing[3], eye[3];
    random_direction(numbers, facing);
    random_direction(numbers, eye);
    if (lane == 3) memcpy(eye, facing, sizeof eye);
    if (lane == 5) cross(facing, (const double[3]){1.0, 0.0, 0.0}, eye);
    const double length = sqrt(dot(eye, eye)), side = dot(facing, eye) < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; i++) eye[i] *= side / length;
    set_lane(normal, lane, facing);
    set_lane(to_eye, lane, eye);
    for (int i = 0; i < 2; i++) u->row[i][lane] = random_unit(numbers);
  }
}

/* How far the angle to the normal or the axis, and so what is steep in it, is off by rounding. */
static double tolerance(const asc_lobe *lobe) {
  return lobe->kind == ASC_LOBE_PHONG ? 1e-14 * (100.0 + lobe->exponent) : 1e-13 / (lobe->roughness * lobe->roughness);
}

/* What a sample says of itself is what the lobe has towards it. */
static void samples_have_the_density_of_their_lobe(void **state) {
  (void)state;
  uint64_t numbers = 7;
  for (size_t k = 0; k < sizeof lobes / sizeof *lobes; k++) {
    uint32_t above = 0;
    for (int round = 0; round < 500; round++) {
      vectors normal, to_eye;
      pairs u;
      lobe_ways ways;
      lobe_at at;
      set_lanes(&numbers, &normal, &to_eye, &u);
      lobe_sample(&lobes[k], &normal, &to_eye, &u, &ways);
      lobe_towards(&lobes[k], &normal, &to_eye, &ways.way, &at);
      for (uint32_t lane = 0; lane < PACKET; lane++) {
        double way[3], facing[3], eye[3];
        get_lane(&ways.way, lane, way);
        get_lane(&normal, lane, facing);
        get_lane(&to_eye, lane, eye);
        assert_true(fabs(dot(way, way) - 1.0) < 1e-13);
        if (lane == 5 || !(ways.share.of[lane] > 0.0)) continue; /* along the surface all cancels */
        above++;
        const double share = ways.share.of[lane] * ways.density.of[lane];
        const double near = tolerance(&lobes[k]) / (dot(facing, way) * dot(facing, eye)); /* steep near the surface */
        assert_near("density", u.row[0][lane], ways.density.of[lane], at.density.of[lane], near);
        assert_near("value", u.row[0][lane], share, at.value.of[lane], near);
      }
    }
    assert_true(above > 4000);
  }
}

/* cos^(exponent + 1) of the angle to the mirrored way is 1 - r^2, r the point's ring in the square; and the density the
 * derivative of that, and of the C library's functions. */
static void phong_samples_lie_where_their_lobe_has_them(void **state) {
  (void)state;
  uint64_t numbers = 11;
  for (size_t k = 0; k < 3; k++) {
    for (int round = 0; round < 500; round++) {
      vectors normal, to_eye;
      pairs u;
      lobe_ways ways;
      set_lanes(&numbers, &normal, &to_eye, &u);
      if (round == 0) u.row[0][0] = u.row[1][0] = 0.5; /* the axis itself */
      if (round == 1) u.row[0][0] = 0.0;               /* the border */
      lobe_sample(&lobes[k], &normal, &to_eye, &u, &ways);
      for (uint32_t lane = 0; lane < PACKET; lane++) {
        double facing[3], eye[3], way[3], axis[3], off[3];
        get_lane(&normal, lane, facing);
        get_lane(&to_eye, lane, eye);
        get_lane(&ways.way, lane, way);
        for (int i = 0; i < 3; i++) axis[i] = 2.0 * dot(facing, eye) * facing[i] - eye[i];
        for (int i = 0; i < 3; i++) off[i] = way[i] - axis[i];
        const double ring = fmax(fabs(2.0 * u.row[0][lane] - 1.0), fabs(2.0 * u.row[1][lane] - 1.0));
        const long double n = lobes[k].exponent, cosine = powl(1.0L - (long double)ring * ring, 1.0L / (n + 1.0L));
        /* 1 - r^2 is that of a rounded square */
        const long double lost = 4e-16L / fmaxl(1.0L - ring, 0x1p-60L), moved = cosine * lost / (n + 1.0L);
        assert_true(fabsl(dot(way, axis) - cosine) < 1e-14L + moved);
        assert_true(fabsl(sqrt(dot(off, off)) - sqrtl(2.0L * (1.0L - cosine))) < 5e-15L + 2.0L * moved);
        const long double density = cosine > 0.0L ? (n + 1.0L) / (2.0L * ASC_PI) * powl(cosine, n) : 0.0L;
        assert_near("density", ring, ways.density.of[lane], density, 4e-14L + lost);
      }
    }
  }
}

static void nothing_is_below_the_surface(void **state) {
  (void)state;
  uint64_t numbers = 13;
  for (size_t k = 0; k < sizeof lobes / sizeof *lobes; k++) {
    vectors normal, to_eye, below;
    pairs u;
    lobe_at at;
    set_lanes(&numbers, &normal, &to_eye, &u);
    for (int i = 0; i < 3; i++)
      for (uint32_t lane = 0; lane < PACKET; lane++) below.row[i][lane] = -normal.row[i][lane];
    lobe_towards(&lobes[k], &normal, &to_eye, &below, &at);
    for (uint32_t lane = 0; lane < PACKET; lane++) assert_true(at.value.of[lane] == 0.0 && at.density.of[lane] == 0.0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(elementary_functions_are_those_of_mpmath),
      cmocka_unit_test(elementary_functions_have_their_limits),
      cmocka_unit_test(elementary_functions_are_within_what_is_said),
      cmocka_unit_test(eighths_of_turns_are_within_two_roundings),
      cmocka_unit_test(samples_have_the_density_of_their_lobe),
      cmocka_unit_test(phong_samples_lie_where_their_lobe_has_them),
      cmocka_unit_test(nothing_is_below_the_surface),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

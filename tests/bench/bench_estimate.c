/* What estimates cost beside their samples: nanoseconds a value, a quantile, a decision. */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "criterion.h"

static double seconds(void) {
  struct timespec now;
  (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void print(const char *what, double elapsed, double count) {
  printf("estimate  %-34s %9.1f ns\n", what, 1e9 * elapsed / count);
}

static void moments(void) {
  static double values[4096];
  for (int i = 0; i < 4096; i++) values[i] = (double)(i * 7919 % 4096);
  asc_moments one = {0};
  asc_tally three[3];
  memset(three, 0, sizeof three);
  enum { ROUNDS = 5000 };
  double start = seconds();
  for (int i = 0; i < ROUNDS; i++) (void)asc_moments_add(&one, values, 4096);
  print("moments, a value", seconds() - start, ROUNDS * 4096.0);
  start = seconds();
  for (int i = 0; i < ROUNDS; i++) (void)asc_tally_add(three, 3, values, 1365);
  print("tally of three channels, a sample", seconds() - start, ROUNDS * 1365.0);
}

static void quantiles(void) {
  const struct {
    const char *what;
    asc_status (*of)(double p, double degrees, double *x);
    double degrees;
  } laws[] = {{"Student's t, 7 degrees", asc_student_t_quantile, 7},
              {"Student's t, 1000 degrees", asc_student_t_quantile, 1000},
              {"Student's t, 1e6 degrees", asc_student_t_quantile, 1e6},
              {"chi-squared, 7 degrees", asc_chi_squared_quantile, 7},
              {"chi-squared, 1000 degrees", asc_chi_squared_quantile, 1000},
              {"chi-squared, 1e6 degrees", asc_chi_squared_quantile, 1e6}};
  enum { COUNT = 2000 };
  double x, sum = 0.0;
  double start = seconds();
  for (int i = 1; i <= COUNT; i++) sum += asc_normal_quantile(i / (COUNT + 1.0), &x) ? 0.0 : x;
  print("normal quantile", seconds() - start, COUNT);
  for (size_t k = 0; k < sizeof laws / sizeof *laws; k++) {
    start = seconds();
    for (int i = 1; i <= COUNT; i++) sum += laws[k].of(i / (COUNT + 1.0), laws[k].degrees, &x) ? 0.0 : x;
    print(laws[k].what, seconds() - start, COUNT);
  }
  if (sum == 0.0) puts("no quantile");
}

static void decisions(void) {
  const struct {
    const char *what;
    asc_criterion criterion;
  } criteria[] = {
      {"decision by contrast", {.kind = ASC_BY_CONTRAST, .contrast = {0.4, 0.3, 0.6}}},
      {"decision by Student's t", {.kind = ASC_BY_STUDENT_T, .tolerance = 1e9, .confidence = 0.95}},
      {"decision by chi-squared", {.kind = ASC_BY_CHI_SQUARED, .tolerance = 1e9, .confidence = 0.95}},
  };
  const double values[] = {0.5, 0.5, 0.5, 0.6, 0.6, 0.6, 0.55, 0.55, 0.55, 0.57, 0.57, 0.57};
  asc_tally tallies[3];
  memset(tallies, 0, sizeof tallies);
  (void)asc_tally_add(tallies, 3, values, 4);
  enum { COUNT = 10000000 };
  for (size_t k = 0; k < sizeof criteria / sizeof *criteria; k++) {
    asc_criterion made = criteria[k].criterion;
    double start = seconds();
    if (asc_criterion_make(&made, 1024)) continue;
    const double making = seconds() - start;
    int satisfied = 0;
    start = seconds();
    for (int i = 0; i < COUNT; i++) satisfied += asc_criterion_satisfied(&made, 3, tallies);
    print(criteria[k].what, seconds() - start, COUNT);
    if (made.known) printf("estimate  its %4u quantiles, all together %6.2f ms\n", (unsigned)made.known, 1e3 * making);
    if (satisfied != COUNT) puts("not satisfied");
    asc_criterion_free(&made);
  }
}

int main(void) {
  moments();
  quantiles();
  decisions();
  return 0;
}

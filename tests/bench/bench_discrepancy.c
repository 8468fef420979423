/* Milliseconds of CPU time for each measure in two dimensions, on random points and on a set of low discrepancy, at the
 * N that they were built for and below; then how the time of `star` grows up to 2^17. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "aliascope/discrepancy.h"

#define LARGEST ((size_t)1 << 17)
#define ROUNDS 3
#define LONG_ENOUGH 0.5 /* seconds, after which one round is enough */

static double points[2 * LARGEST];

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* `random`, or the additive recurrence (i/N, frac(i golden)), which is better spread and so harder to prune. */
static int draw(const char *sampler, size_t count) {
  if (strcmp(sampler, "kronecker") == 0) {
    for (size_t i = 0; i < count; i++) {
      points[2 * i] = ((double)i + 0.5) / (double)count;
      points[2 * i + 1] = fmod((double)i * 0.6180339887498949, 1.0);
    }
    return 0;
  }
  const asc_sampler_desc desc = {sizeof desc, sampler, count, 2, 1};
  asc_sampler *made = NULL;
  asc_error error;
  if (asc_sampler_create(&desc, &made, &error)) return 1;
  const asc_range range = {0, 0, 0, count, 0, 2};
  const int failed = asc_sampler_fill(made, &range, points) != ASC_OK;
  asc_sampler_destroy(made);
  return failed;
}

/* The least of several rounds, in milliseconds: what disturbs only adds. Negative: the measure cannot. */
static double measure(const char *spec, size_t count) {
  const asc_discrepancy_desc desc = {sizeof desc, spec, points, count, 2, 0};
  double least = INFINITY;
  for (int round = 0; round < ROUNDS && !(round > 0 && least > LONG_ENOUGH); round++) {
    asc_measurement made = {.struct_size = sizeof made};
    asc_error error;
    const double begun = now();
    if (asc_discrepancy(&desc, &made, &error)) return -1.0;
    least = fmin(least, now() - begun);
  }
  return least * 1e3;
}

static void show_all(const char *sampler) {
  static const size_t counts[] = {100, 400, 1600, 4096};
  printf("milliseconds, %s points, one thread\n  %-16s", sampler, "N");
  for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) printf(" %10zu", counts[k]);
  printf("\n");
  for (size_t i = 0; i < asc_measure_count(); i++) {
    asc_measure_info info;
    if (asc_measure_describe(i, &info)) continue;
    printf("  %-16s", info.name);
    for (size_t k = 0; k < sizeof counts / sizeof *counts; k++) {
      /* What would take more than some seconds is left out. */
      const double spent =
          counts[k] > 3 * info.quick_points || draw(sampler, counts[k]) ? -1.0 : measure(info.name, counts[k]);
      if (spent < 0.0)
        printf(" %10s", "-");
      else
        printf(" %10.3f", spent);
    }
    printf("\n");
  }
}

/* The slope of log time against log N, by least squares. */
static void show_growth(const char *spec) {
  double sums[4] = {0.0}, count = 0.0;
  printf("%s, milliseconds, random points:\n ", spec);
  for (size_t n = 1 << 10; n <= LARGEST; n *= 2) {
    if (draw("random", n)) return;
    const double spent = measure(spec, n);
    if (spent < 0.0) return;
    printf(" %zu: %.2f", n, spent);
    const double x = log((double)n), y = log(spent);
    sums[0] += x;
    sums[1] += y;
    sums[2] += x * x;
    sums[3] += x * y;
    count += 1.0;
  }
  printf("\n  as N^%.2f\n", (count * sums[3] - sums[0] * sums[1]) / (count * sums[2] - sums[0] * sums[0]));
}

int main(void) {
  show_all("random");
  show_all("kronecker");
  show_growth("star");
  return 0;
}

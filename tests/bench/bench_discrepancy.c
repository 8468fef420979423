/* Milliseconds of each registered measure, of random points and of well-spread ones, which leave less to prune, beside
 * what is aimed at; and how star grows with the number of points. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "aliascope/discrepancy.h"

#define MOST_POINTS ((size_t)1 << 17)
#define USUAL_POINTS 1600
#define ROUNDS 5
#define MOST_GROWTH 1.6 /* the exponent of star's time that is aimed at */
#define ENOUGH_S 2.0    /* spent on one measure, then no further round */

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double points[MOST_POINTS * 2];

#define WELL_SPREAD "(i/N, i golden)" /* an additive recurrence */

static int make_points(const char *sampler_spec, size_t count) {
  if (strcmp(sampler_spec, WELL_SPREAD) == 0) {
    for (size_t i = 0; i < count; i++) {
      points[2 * i] = ((double)i + 0.5) / (double)count;
      points[2 * i + 1] = fmod((double)i * 0.6180339887498949, 1.0);
    }
    return 1;
  }
  const asc_sampler_desc desc = {sizeof desc, sampler_spec, count, 2, 1};
  const asc_range range = {0, 0, 0, count, 0, 2};
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  asc_status status = asc_sampler_create(&desc, &sampler, &error);
  if (status == ASC_OK) status = asc_sampler_fill(sampler, &range, points);
  asc_sampler_destroy(sampler);
  if (status) printf("  %s: %s\n", sampler_spec, error.text);
  return status == ASC_OK;
}

/* The least of several rounds, in milliseconds: what disturbs only adds. Negative, and said why, where it fails. */
static double measure(const char *spec, size_t count) {
  double least = INFINITY, spent = 0.0;
  for (int round = 0; round < ROUNDS && spent < ENOUGH_S; round++) {
    const asc_discrepancy_desc desc = {sizeof desc, spec, points, count, 2, 1};
    asc_measurement made = {.struct_size = sizeof made};
    asc_error error = {{0}};
    const double begun = now();
    const asc_status status = asc_discrepancy(&desc, &made, &error);
    const double took = now() - begun;
    spent += took;
    if (took < least) least = took;
    if (status == ASC_OK) continue;
    printf("  %-14s %8zu  %s\n", spec, count, error.text);
    return -1.0;
  }
  return least * 1e3;
}

typedef struct aim {
  const char *name;
  size_t count;
  double target_ms; /* 0: none is set */
} aim;

static aim aim_of(const char *name) {
  static const aim aims[] = {{"star", 4096, 15.0},
                             {"box", 1600, 1000.0},
                             {"half-plane", 1600, 100.0},
                             {"edge-rms", 1600, 5.0},
                             {"t-value", 4096, 0.0}}; /* a power of the base */
  for (size_t i = 0; i < sizeof aims / sizeof *aims; i++)
    if (strcmp(aims[i].name, name) == 0) return aims[i];
  if (strncmp(name, "l2-", 3) == 0) return (aim){name, 4096, 7.0};
  return (aim){name, USUAL_POINTS, 0.0};
}

static void show(const char *name) {
  const aim of = aim_of(name);
  if (!make_points("random", of.count)) return;
  const double random = measure(name, of.count);
  if (!make_points(WELL_SPREAD, of.count)) return;
  const double spread = measure(name, of.count);
  if (random < 0.0 || spread < 0.0) return;
  printf("  %-14s %8zu %10.2f %12.2f", name, of.count, random, spread);
  if (of.target_ms > 0.0)
    printf(" %10.0f  %s", of.target_ms, fmax(random, spread) <= of.target_ms ? "reached" : "MISSED");
  printf("\n");
}

/* The exponent is the slope of the least-squares line of log time against log N. */
static void show_growth(const char *name, const char *sampler_spec) {
  printf("%s of %s points, milliseconds\n", name, sampler_spec);
  double xs = 0.0, ys = 0.0, xx = 0.0, xy = 0.0, number = 0.0;
  for (size_t count = (size_t)1 << 10; count <= MOST_POINTS; count *= 2) {
    if (!make_points(sampler_spec, count)) return;
    const double took = measure(name, count), x = log2((double)count), y = log2(took);
    if (took < 0.0) return;
    printf("  %-14s %8zu %10.2f\n", name, count, took);
    xs += x, ys += y, xx += x * x, xy += x * y, number += 1.0;
  }
  const double exponent = (number * xy - xs * ys) / (number * xx - xs * xs);
  printf("  growing as N^%.2f, to reach: N^%.1f  %s\n", exponent, MOST_GROWTH,
         exponent <= MOST_GROWTH ? "reached" : "MISSED");
}

int main(void) {
  printf("milliseconds a measure, two dimensions, one thread\n");
  printf("  %-14s %8s %10s %12s %10s\n", "measure", "N", "random", "well spread", "to reach");
  for (size_t i = 0; i < asc_measure_count(); i++) {
    asc_measure_info info;
    if (asc_measure_describe(i, &info) == ASC_OK && info.least_dimensions <= 2 && info.most_dimensions >= 2)
      show(info.name);
  }
  show_growth("star", "random");
  show_growth("star", WELL_SPREAD);
  return 0;
}

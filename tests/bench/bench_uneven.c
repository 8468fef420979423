/* Milliseconds for the weights of 4,096 unevenly spread samples, by method, filter and how the samples lie, beside what
 * is aimed at for the areas of Voronoi cells; and how the cells grow with the number of samples. */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <time.h>

#include "aliascope/uneven.h"

#define USUAL 4096
#define MOST ((size_t)1 << 17)
#define ROUNDS 15
#define TARGET_MS 10.0

static double points[MOST * 2], weights[MOST];

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* In [0, 1), by a multiplicative congruential generator. */
static double drawn(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (double)(*state >> 11) * 0x1p-53;
}

typedef enum way { UNIFORM, CROWDED, LINE, CIRCLE, WHEEL, GRID, WAYS } way;
static const char *const names[WAYS] = {"uniform", "in a corner", "on a line", "on a circle", "circle, hub", "grid"};

static void spread(way how, size_t count) {
  uint64_t state = 1;
  const size_t side = (size_t)ceil(sqrt((double)count));
  for (size_t i = 0; i < count; i++) {
    const double a = drawn(&state) - 0.5, b = drawn(&state) - 0.5, turn = 6.283185307179586 * a;
    double *at = points + 2 * i;
    at[0] = a, at[1] = b;
    if (how == CROWDED) at[0] = 0.499 + 0.002 * a, at[1] = 0.499 + 0.002 * b;
    if (how == LINE) at[1] = 0.5 * a;
    if (how == CIRCLE || how == WHEEL) at[0] = 0.4 * cos(turn), at[1] = 0.4 * sin(turn);
    if (how == WHEEL && i == 0) at[0] = at[1] = 0.0;
    if (how == GRID) at[0] = ((double)(i % side) + 0.5) / (double)side - 0.5;
    if (how == GRID) at[1] = ((double)(i / side) + 0.5) / (double)side - 0.5;
  }
}

/* The least of several rounds, in milliseconds: what disturbs only adds. Negative, and said why, where it fails. */
static double measure(const char *spec, const asc_filter *filter, size_t count) {
  const asc_uneven_desc desc = {sizeof desc, spec, filter, points, count};
  double least = INFINITY;
  for (int round = 0; round < ROUNDS; round++) {
    asc_error error = {{0}};
    const double begun = now();
    const asc_status status = asc_uneven_weights(&desc, weights, &error);
    const double took = now() - begun;
    if (took < least) least = took;
    if (status == ASC_OK) continue;
    printf("  %s: %s\n", spec, error.text);
    return -1.0;
  }
  return least * 1e3;
}

static void show(const char *spec, const char *filter_spec, double target_ms) {
  const asc_filter_desc desc = {sizeof desc, filter_spec};
  asc_filter *filter = NULL;
  if (filter_spec && asc_filter_create(&desc, &filter, NULL)) return;
  printf("  %-16s %-9s", spec, filter_spec ? filter_spec : "-");
  for (int how = 0; how < WAYS; how++) {
    spread((way)how, USUAL);
    printf(" %11.2f", measure(spec, filter, USUAL));
  }
  if (target_ms > 0.0) printf(" %9.0f", target_ms);
  printf("\n");
  asc_filter_destroy(filter);
}

int main(void) {
  printf("milliseconds for the weights of %d samples, one thread\n  %-16s %-9s", USUAL, "weighting", "filter");
  for (int how = 0; how < WAYS; how++) printf(" %11s", names[how]);
  printf(" %9s\n", "to reach");
  show("area", NULL, TARGET_MS);
  show("area", "mitchell", TARGET_MS);
  show("area", "lanczos", TARGET_MS);
  show("average", "mitchell", 0.0);
  show("multi-stage", NULL, 0.0);
  show("inverse-density", NULL, 0.0);
  printf("area, milliseconds a thousand samples\n");
  for (size_t count = (size_t)1 << 10; count <= MOST; count *= 4) {
    printf("  %-26zu", count);
    for (int how = 0; how < WAYS; how++) {
      spread((way)how, count);
      printf(" %11.3f", measure("area", NULL, count) / (double)count * 1e3);
    }
    printf("\n");
  }
  return 0;
}

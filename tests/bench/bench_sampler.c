/* Nanoseconds a two-dimensional point of each registered sampler, beside a bare loop that only writes the memory. */
#define _POSIX_C_SOURCE 200809L
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "aliascope/sampler.h"

#define POINTS 4096
#define FILLS 200
#define ROUNDS 7

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static double points[POINTS * 2];

/* The least of several rounds, in nanoseconds a point: what disturbs only adds. */
static double measure(const asc_sampler *sampler) {
  double least = 1e9;
  for (int round = 0; round < ROUNDS; round++) {
    const double begun = now();
    for (int32_t i = 0; i < FILLS; i++) {
      const asc_range range = {i, round, 0, POINTS, 0, 2};
      if (sampler)
        (void)asc_sampler_fill(sampler, &range, points);
      else
        for (size_t k = 0; k < POINTS * 2; k++) ((volatile double *)points)[k] = (double)k;
    }
    const double spent = now() - begun;
    if (spent < least) least = spent;
  }
  return least / FILLS / POINTS * 1e9;
}

static void show(const char *spec) {
  const asc_sampler_desc desc = {sizeof desc, spec, POINTS, 2, 1};
  asc_sampler *sampler = NULL;
  asc_error error;
  if (asc_sampler_create(&desc, &sampler, &error)) {
    printf("  %-26s %s\n", spec, error.text);
    return;
  }
  printf("  %-26s %6.2f\n", spec, measure(sampler));
  asc_sampler_destroy(sampler);
}

int main(void) {
  printf("nanoseconds a point, two dimensions, %d points a call, one thread\n", POINTS);
  printf("  %-26s %6.2f\n", "(writing alone)", measure(NULL));
  for (size_t i = 0; i < asc_sampler_count(); i++) {
    asc_sampler_info info;
    if (asc_sampler_describe(i, &info)) continue;
    show(info.name);
    for (size_t k = 0; k < info.parameter_count; k++) {
      /* Every word of every choice but the default. */
      const char *choice = info.parameters[k].choices;
      for (int index = 0; choice && *choice; index++) {
        const int length = (int)strcspn(choice, "|");
        char spec[128];
        (void)snprintf(spec, sizeof spec, "%s:%s=%.*s", info.name, info.parameters[k].name, length, choice);
        if (index != (int)info.parameters[k].fallback) show(spec);
        choice += length + (choice[length] == '|');
      }
    }
  }
  return 0;
}

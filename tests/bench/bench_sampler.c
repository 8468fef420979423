/* Nanoseconds a dimension of every registered sampler, on one thread:
 *
 *   bulk     all N points of a pixel, BLOCK of them a call, into memory that stays in cache
 *   random   one sample a call, all its dimensions, the indices in shuffled order
 *
 * N and the number of dimensions are the largest of those below that the pattern has and fills in reasonable time;
 * patterns that are made whole with every call are filled whole in one. */
#define _POSIX_C_SOURCE 200809L
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "aliascope/sampler.h"

#define MOST_POINTS 1048576
#define MOST_DIMENSIONS 4
#define BLOCK 1024   /* x 4 dimensions: 32 KiB */
#define RANDOM 4096  /* samples of one timing of random access */
#define ROUNDS 15    /* the least of them counts: what disturbs only adds */
#define PATIENCE 0.1 /* seconds: a pattern that needs longer for a call is taken with fewer points */
#define ENOUGH 0.4   /* seconds of rounds of one figure */

static double points[MOST_POINTS * MOST_DIMENSIONS];
static uint32_t order[RANDOM];

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

typedef struct workload {
  asc_sampler *sampler; /* NULL: writing alone */
  uint32_t samples, dimensions, block;
} workload;

static void fill(const workload *load, int32_t pixel, uint32_t first, uint32_t count) {
  const asc_range range = {pixel, 0, first, count, 0, load->dimensions};
  if (load->sampler)
    (void)asc_sampler_fill(load->sampler, &range, points);
  else
    for (size_t k = 0; k < (size_t)count * load->dimensions; k++) ((volatile double *)points)[k] = (double)k;
}

static void bulk(const workload *load, int32_t pixel) {
  for (uint32_t first = 0; first < load->samples; first += load->block) {
    const uint32_t left = load->samples - first;
    fill(load, pixel, first, left < load->block ? left : load->block);
  }
}

static void at_random(const workload *load, int32_t pixel) {
  for (uint32_t i = 0; i < RANDOM; i++) fill(load, pixel, (uint32_t)((uint64_t)order[i] * load->samples >> 32), 1);
}

/* Nanoseconds a value of `run`, which makes `values` of them. */
static double measure(const workload *load, void (*run)(const workload *, int32_t), double values) {
  double least = 1e9;
  const double begun = now();
  for (int32_t round = 0; round < ROUNDS && (round == 0 || now() - begun < ENOUGH); round++) {
    const double start = now();
    run(load, round);
    const double spent = now() - start;
    if (spent < least) least = spent;
  }
  return least / values * 1e9;
}

/* Counts near 2^20, 2^16, 2^12, 2^8, 2^4: powers of two and four, squares and cubes of primes, Fibonacci numbers. */
static const uint32_t counts[][4] = {
    {16, 25, 27, 13},
    {256, 289, 343, 233},
    {4096, 3721, 4913, 4181},
    {65536, 63001, 68921, 46368},
    {MOST_POINTS, 1042441, 1030301, 832040},
};
static const uint32_t dimension_choices[] = {4, 3, 2, 1};

static asc_sampler *create(const char *spec, uint32_t samples, uint32_t dimensions, asc_error *error) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, 1};
  asc_sampler *sampler = NULL;
  (void)asc_sampler_create(&desc, &sampler, error);
  return sampler;
}

/* Climbs from few points to many, as long as they can be had and a call is quick. */
static workload choose(const char *spec, uint32_t most_dimensions, asc_error *error) {
  workload chosen = {0};
  for (size_t d = 0; d < 4 && !chosen.sampler; d++) {
    if (dimension_choices[d] > most_dimensions) continue;
    for (size_t size = 0; size < sizeof counts / sizeof *counts; size++) {
      const double begun = now();
      workload next = {NULL, 0, dimension_choices[d], BLOCK};
      for (size_t k = 0; k < 4 && !next.sampler; k++) {
        next.samples = counts[size][k];
        next.sampler = create(spec, next.samples, next.dimensions, error);
      }
      if (!next.sampler) continue;
      fill(&next, 0, 0, 1);
      const double alone = now();
      if (alone - begun > 1e-3) next.block = next.samples; /* made whole for one point: so ask for all */
      asc_sampler_destroy(chosen.sampler);
      chosen = next;
      if (alone - begun > PATIENCE) break;
    }
  }
  return chosen;
}

static void show(const char *spec, uint32_t most_dimensions) {
  asc_error error;
  workload load = choose(spec, most_dimensions, &error);
  if (!load.sampler) {
    printf("  %-40s %s\n", spec, error.text);
    return;
  }
  const double each = measure(&load, bulk, (double)load.samples * load.dimensions);
  printf("  %-40s %8u %4u %9.2f", spec, load.samples, load.dimensions, each);
  /* Whole patterns are made again for each sample: a figure without meaning. */
  if (load.block == BLOCK)
    printf(" %9.2f\n", measure(&load, at_random, (double)RANDOM * load.dimensions));
  else
    printf("   (whole)\n");
  asc_sampler_destroy(load.sampler);
}

static void show_forms(const asc_sampler_info *info) {
  show(info->name, MOST_DIMENSIONS);
  show(info->name, 2);
  for (size_t k = 0; k < info->parameter_count; k++) {
    /* Every word of every choice but the default. */
    const char *choice = info->parameters[k].choices;
    for (int index = 0; choice && *choice; index++) {
      const int length = (int)strcspn(choice, "|");
      char spec[128];
      (void)snprintf(spec, sizeof spec, "%s:%s=%.*s", info->name, info->parameters[k].name, length, choice);
      if (index != (int)info->parameters[k].fallback) show(spec, MOST_DIMENSIONS);
      choice += length + (choice[length] == '|');
    }
  }
}

int main(void) {
  uint32_t state = 1;
  for (size_t i = 0; i < RANDOM; i++) order[i] = state = state * 1664525u + 1013904223u; /* Numerical Recipes */
  printf("nanoseconds a dimension, one thread; bulk: %d points a call; random: one\n", BLOCK);
  printf("  %-40s %8s %4s %9s %9s\n", "", "N", "d", "bulk", "random");
  const workload alone = {NULL, MOST_POINTS, MOST_DIMENSIONS, BLOCK};
  printf("  %-40s %8d %4d %9.2f %9.2f\n", "(writing alone)", MOST_POINTS, MOST_DIMENSIONS,
         measure(&alone, bulk, (double)MOST_POINTS * MOST_DIMENSIONS),
         measure(&alone, at_random, (double)RANDOM * MOST_DIMENSIONS));
  for (size_t i = 0; i < asc_sampler_count(); i++) {
    asc_sampler_info info;
    if (asc_sampler_describe(i, &info) == ASC_OK) show_forms(&info);
  }
  return 0;
}

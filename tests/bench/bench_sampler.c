/* Nanoseconds a value (one dimension of one sample) of every registered sampler, on one thread, of CPU time:
 *
 *   bulk     all N points of a pixel, BLOCK of them a call, into memory that stays in cache
 *   random   one sample a call, all its dimensions, of a pixel and an index both drawn at random (before the clock
 *            starts). No call needs the one before, as in a renderer whose paths do not wait for each other, so the
 *            processor overlaps their ends and beginnings: this is throughput. A call whose arguments wait for the
 *            result of the one before takes longer.
 *
 * First what was asked for, beside the figures to be reached; then all, in their kinds. N and the number of dimensions
 * are the largest of those below that the pattern has and fills in reasonable time; patterns that are made whole with
 * every call are filled whole in one. `bench_sampler SPEC...` measures those alone.
 *
 * What else runs on the machine shows in the calibration, which should be the same at both ends. */
#define _POSIX_C_SOURCE 200809L
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "aliascope/sampler.h"

#define MOST_POINTS 1048576
#define MOST_DIMENSIONS 4
#define BLOCK 1024     /* x 4 dimensions: 32 KiB */
#define RANDOM 4096    /* samples of one timing of random access */
#define ROUNDS 15      /* the least of them counts: what disturbs only adds */
#define PATIENCE 0.004 /* seconds: a pattern that needs longer for a call is not tried with more points */
#define ENOUGH 0.3     /* seconds of rounds of one figure */
#define MOST_LEFT_OUT 64

static _Alignas(64) double points[MOST_POINTS * MOST_DIMENSIONS];
static asc_range places[RANDOM];
static char left_out[MOST_LEFT_OUT][512];
static size_t left_out_count;

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* Numerical Recipes, "quick and dirty" generators. */
static uint32_t next_random(uint32_t *state) { return *state = *state * 1664525u + 1013904223u; }

typedef struct workload {
  asc_sampler *sampler; /* NULL: writing alone */
  uint32_t samples, dimensions, block;
} workload;

static void fill(const workload *load, const asc_range *range) {
  if (load->sampler)
    (void)asc_sampler_fill(load->sampler, range, points);
  else
    for (size_t k = 0; k < range->sample_count * load->dimensions; k++) ((volatile double *)points)[k] = (double)k;
}

static void bulk(const workload *load, int32_t pixel) {
  for (uint32_t first = 0; first < load->samples; first += load->block) {
    const uint32_t left = load->samples - first;
    const asc_range range = {pixel, 0, first, left < load->block ? left : load->block, 0, load->dimensions};
    fill(load, &range);
  }
}

static void at_random(const workload *load, int32_t round) {
  (void)round;
  for (size_t i = 0; i < RANDOM; i++) fill(load, &places[i]);
}

static void draw_places(const workload *load) {
  uint32_t state = 1;
  for (size_t i = 0; i < RANDOM; i++) {
    const int32_t x = (int32_t)(next_random(&state) >> 20), y = (int32_t)(next_random(&state) >> 20);
    places[i] = (asc_range){x, y, (uint64_t)next_random(&state) * load->samples >> 32, 1, 0, load->dimensions};
  }
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

/* Integer steps that do not wait for each other, SplitMix64's. */
static void mix(const workload *load, int32_t round) {
  uint64_t sum = 0;
  for (uint64_t i = 0; i < load->samples; i++) {
    uint64_t x = ((uint64_t)round << 32) + i;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    sum += x ^ (x >> 31);
  }
  ((volatile double *)points)[0] = (double)sum;
}

static void calibrate(const char *when) {
  const workload load = {NULL, 65536, 1, 1};
  printf("calibration %s: %.2f ns a SplitMix64 number\n", when, measure(&load, mix, load.samples));
}

/* Counts near 2^20, 2^16, 2^12, 2^8, 2^4: powers of two and four, squares and cubes of primes, Fibonacci numbers. */
static const uint32_t counts[][4] = {
    {8, 9, 5, 13},
    {16, 25, 27, 13},
    {256, 289, 343, 233},
    {4096, 3721, 4913, 4181},
    {65536, 63001, 68921, 46368},
    {MOST_POINTS, 1042441, 1030301, 832040},
};

static asc_sampler *create(const char *spec, uint32_t samples, uint32_t dimensions, asc_error *error) {
  const asc_sampler_desc desc = {sizeof desc, spec, samples, dimensions, 1};
  asc_sampler *sampler = NULL;
  (void)asc_sampler_create(&desc, &sampler, error);
  return sampler;
}

/* Seconds since `begun` after making one point more: the last, for which some patterns make all others. */
static double one_point(const workload *load, double begun) {
  const asc_range last = {0, 0, load->samples - 1, 1, 0, load->dimensions};
  fill(load, &last);
  return now() - begun;
}

/* Climbs from few points to many, as long as they can be had and a call is quick. Without a sampler where the pattern
 * has none of the counts in `dimensions`. */
static workload choose(const char *spec, uint32_t dimensions, asc_error *error) {
  workload chosen = {0};
  for (size_t size = 0; size < sizeof counts / sizeof *counts; size++) {
    const double begun = now();
    workload next = {NULL, 0, dimensions, BLOCK};
    for (size_t k = 0; k < 4 && !next.sampler; k++) {
      next.samples = counts[size][k];
      next.sampler = create(spec, next.samples, next.dimensions, error);
    }
    if (!next.sampler) continue;
    const double with_making = one_point(&next, begun);
    if (one_point(&next, now()) > 1e-4) next.block = next.samples; /* all made for one: so ask for all */
    asc_sampler_destroy(chosen.sampler);
    chosen = next;
    if (with_making > PATIENCE) break;
  }
  return chosen;
}

static void leave_out(const char *spec, uint32_t dimensions, const char *why) {
  if (left_out_count < MOST_LEFT_OUT)
    (void)snprintf(left_out[left_out_count++], sizeof left_out[0], "%s, %u dimensions: %s", spec, dimensions, why);
}

static void print_target(double target) {
  if (target > 0.0)
    printf(" %6g", target);
  else
    printf(" %6s", "");
}

/* A line, with the figures to be reached where they are not 0. */
static void show(const char *spec, const workload *load, double bulk_target, double random_target) {
  printf("  %-42s %8u %2u %10.2f", spec, load->samples, load->dimensions,
         measure(load, bulk, (double)load->samples * load->dimensions));
  print_target(bulk_target);
  draw_places(load);
  /* Whole patterns are made again for each sample: a figure without meaning. */
  if (load->block == BLOCK || !load->sampler) {
    printf(" %10.2f", measure(load, at_random, (double)RANDOM * load->dimensions));
    print_target(random_target);
  } else {
    printf("    (whole)");
  }
  printf("\n");
}

static int show_chosen(const char *spec, uint32_t dimensions, asc_error *error) {
  workload load = choose(spec, dimensions, error);
  if (!load.sampler) return 0;
  show(spec, &load, 0.0, 0.0);
  asc_sampler_destroy(load.sampler);
  return 1;
}

/* In four dimensions and in two; those of a pattern that has neither as it has them. */
static void show_spec(const char *spec) {
  asc_error error = {{0}};
  const int four = show_chosen(spec, 4, &error), two = show_chosen(spec, 2, &error);
  if (four && !two) leave_out(spec, 2, error.text);
  if (four || two || show_chosen(spec, 3, &error) || show_chosen(spec, 1, &error)) return;
  leave_out(spec, 1, error.text);
}

static void show_forms(const asc_sampler_info *info) {
  show_spec(info->name);
  for (size_t k = 0; k < info->parameter_count; k++) {
    /* Every word of every choice but the default. */
    const char *choice = info->parameters[k].choices;
    for (int index = 0; choice && *choice; index++) {
      const int length = (int)strcspn(choice, "|");
      char spec[128];
      (void)snprintf(spec, sizeof spec, "%s:%s=%.*s", info->name, info->parameters[k].name, length, choice);
      if (index != (int)info->parameters[k].fallback) show_spec(spec);
      choice += length + (choice[length] == '|');
    }
  }
}

static void show_heading(const char *title) {
  printf("\n%s\n  %-42s %8s %2s %10s %6s %10s %6s\n", title, "", "N", "d", "bulk", "asked", "random", "asked");
  printf("  %-42s %8s %2s %10s %6s %10s %6s\n", "", "points", "", "ns/value", "", "ns/value", "");
}

/* What a renderer can afford: nanoseconds a value, of poisson-disk 3 microseconds a point of two. */
static const struct {
  const char *spec;
  uint32_t samples, dimensions;
  double bulk, random;
} asked[] = {
    {"sobol:scramble=owen", MOST_POINTS, 4, 1, 4},
    {"halton", MOST_POINTS, 4, 5, 20},
    {"jittered", MOST_POINTS, 4, 2, 10},
    {"jittered", MOST_POINTS, 2, 2, 10},
    {"hammersley", MOST_POINTS, 4, 2, 10},
    {"hammersley", MOST_POINTS, 2, 2, 10},
    {"n-rooks", MOST_POINTS, 4, 5, 20},
    {"n-rooks", MOST_POINTS, 2, 5, 20},
    {"pmj02", MOST_POINTS, 4, 2, 10},
    {"pmj02", MOST_POINTS, 2, 2, 10},
    {"poisson-disk", 100000, 2, 1500, 0},
};

static void show_asked(void) {
  show_heading("asked for");
  for (size_t k = 0; k < sizeof asked / sizeof *asked; k++) {
    const int whole = asked[k].random == 0.0;
    asc_error error;
    const workload load = {create(asked[k].spec, asked[k].samples, asked[k].dimensions, &error), asked[k].samples,
                           asked[k].dimensions, whole ? asked[k].samples : BLOCK};
    show(asked[k].spec, &load, asked[k].bulk, asked[k].random);
    asc_sampler_destroy(load.sampler);
  }
}

int main(int count, char **specs) {
  calibrate("at first");
  if (count == 1) show_asked();
  show_heading(count == 1 ? "all" : "of these");
  const workload alone = {NULL, MOST_POINTS, MOST_DIMENSIONS, BLOCK};
  show("(writing alone)", &alone, 0.0, 0.0);
  for (int k = 1; k < count; k++) show_spec(specs[k]);
  for (size_t i = 0; i < asc_sampler_count() && count == 1; i++) {
    asc_sampler_info info;
    if (asc_sampler_describe(i, &info) == ASC_OK) show_forms(&info);
  }
  if (left_out_count) printf("\nleft out\n");
  for (size_t k = 0; k < left_out_count; k++) printf("  %s\n", left_out[k]);
  printf("\n");
  calibrate("at last");
  return 0;
}

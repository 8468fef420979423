/* The multi-stage filter: box filters of ever increasing width, one after the other, each divided by what there is.
 *
 * Source: Mitchell 1987, "Generating antialiased images at low sampling densities". First the samples are averaged over
 * boxes a quarter of a pixel wide, around the positions of a fine grid; then these averages over boxes of a half, those
 * once more, and at last over the pixel. A crowd of samples counts for no more than the box that it lies in. Boxes
 * without a sample, or without an average, are left out of the next: so each stage is normalised where it is. Where
 * samples are everywhere, it is the filter `multi-stage` (multi_stage.c), but for the grid, of a 32nd of the widest
 * box: its response is that filter's within 0.005 up to two cycles over the widest box.
 *
 * The weight of a sample is computed backward: the value at the centre is spread over the positions of the last stage,
 * each position's part over those of the stage before, and in the end over the samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "weighting.h"

#define STEPS 32 /* of the grid in the widest box; the boxes of later stages hold whole numbers of positions */
#define BOXES 3
static const int widths[BOXES] = {STEPS / 2, STEPS / 2, STEPS}; /* in steps, after the first of STEPS / 4 */

/* Positions a side: those that reach the centre from stage 1, 2, 3. */
#define SIDE (STEPS + STEPS / 2 + STEPS / 2 - 2)
static const int sides[BOXES] = {SIDE, SIDE - STEPS / 2 + 1, STEPS};

typedef double grid[SIDE][SIDE];

typedef struct stages {
  grid counts[BOXES]; /* what each position's average is of: samples, then averages */
  grid parts[BOXES];  /* what each position's average weighs in the end */
  grid between;
} stages;

/* Where the box around a position of the first stage holds a sample: rows or columns begin to end - 1. */
typedef struct reach {
  int begin, end;
} reach;

static reach reach_of(double x, double step) {
  const double steps = STEPS, side = sides[0];
  const double first = ceil(x / step + 0.5 * (side - 1.0) - steps / 8.0);
  return (reach){(int)fmax(first, 0.0), (int)fmin(first + steps / 4.0, side)};
}

static void count_samples(const asc_samples *samples, double step, grid counts) {
  for (size_t i = 0; i < samples->count; i++) {
    const reach columns = reach_of(samples->points[2 * i], step), rows = reach_of(samples->points[2 * i + 1], step);
    for (int row = rows.begin; row < rows.end; row++)
      for (int column = columns.begin; column < columns.end; column++) counts[row][column] += 1.0;
  }
}

/* How many positions of the stage before have an average, in the box of each. */
static void count_averages(stages *of, int stage) {
  const int width = widths[stage - 1], side = sides[stage];
  memset(of->between, 0, sizeof of->between);
  for (int row = 0; row < sides[stage - 1]; row++)
    for (int k = 0; k < width; k++)
      for (int column = 0; column < side; column++)
        of->between[row][column] += of->counts[stage - 1][row][column + k] > 0.0 ? 1.0 : 0.0;
  for (int row = 0; row < side; row++)
    for (int k = 0; k < width; k++)
      for (int column = 0; column < side; column++) of->counts[stage][row][column] += of->between[row + k][column];
}

/* Each position's part in equal shares to the averages in its box. */
static void spread(stages *of, int stage) {
  const int width = widths[stage - 1], side = sides[stage], before = sides[stage - 1];
  memset(of->between, 0, sizeof of->between);
  for (int row = 0; row < side; row++)
    for (int column = 0; column < side; column++)
      if (of->counts[stage][row][column] > 0.0) of->parts[stage][row][column] /= of->counts[stage][row][column];
  for (int row = 0; row < side; row++)
    for (int k = 0; k < width; k++)
      for (int column = 0; column < side; column++) of->between[row][column + k] += of->parts[stage][row][column];
  for (int row = 0; row < side; row++)
    for (int k = 0; k < width; k++)
      for (int column = 0; column < before; column++) of->parts[stage - 1][row + k][column] += of->between[row][column];
  for (int row = 0; row < before; row++)
    for (int column = 0; column < before; column++)
      if (of->counts[stage - 1][row][column] == 0.0) of->parts[stage - 1][row][column] = 0.0;
}

static void weigh_samples(const asc_samples *samples, double step, const stages *of, double *weights) {
  for (size_t i = 0; i < samples->count; i++) {
    const reach columns = reach_of(samples->points[2 * i], step), rows = reach_of(samples->points[2 * i + 1], step);
    weights[i] = 0.0;
    for (int row = rows.begin; row < rows.end; row++)
      for (int column = columns.begin; column < columns.end; column++)
        weights[i] += of->parts[0][row][column] / of->counts[0][row][column];
  }
}

static asc_status multi_stage_weigh(const asc_samples *samples, const double *values, double *weights) {
  (void)values;
  const double step = samples->radius / 1.125 / STEPS;
  stages *of = calloc(1, sizeof *of);
  if (!of) return ASC_OUT_OF_MEMORY;
  count_samples(samples, step, of->counts[0]);
  for (int stage = 1; stage < BOXES; stage++) count_averages(of, stage);
  for (int row = 0; row < STEPS; row++)
    for (int column = 0; column < STEPS; column++)
      of->parts[BOXES - 1][row][column] = of->counts[BOXES - 1][row][column] > 0.0 ? 1.0 : 0.0;
  for (int stage = BOXES - 1; stage > 0; stage--) spread(of, stage);
  weigh_samples(samples, step, of, weights);
  free(of);
  return ASC_OK;
}

const asc_weighting_interface asc_weighting_multi_stage = {
    .name = "multi-stage",
    .title = "boxes of a quarter, a half, a half and a pixel in turn, each an average of what it holds",
    .source = "Mitchell 1987",
    .filter = "multi-stage",
    .radius = 1.125,
    .weigh = multi_stage_weigh,
};

/* N queens on a board of N x N that do not attack each other: one point in each row and column, and at most one on each
 * diagonal. Each lies anywhere in its cell; centred=1 puts it at the centre. Any N but 2 and 3, which have no solution,
 * up to 2^20.
 *
 * solution=search: from a random permutation, two rows exchange their queens wherever that leaves fewer attacks, until
 * there are none (Sosic and Gu 1994, "Efficient local search with conflict minimization: a case study of the n-queens
 * problem"). Bounds: 2 N exchanges, at most 128, are tried for a queen in one sweep over the rows; a start ends with
 * the first sweep that exchanges nothing; after 256 starts the construction answers instead. Every solution is reached
 * up to N = 8 (the tests hold that), but not all equally often.
 *
 * solution=construction: the solution of Pauls 1874 as Hoffman, Loessi, Moore 1969 ("Constructions for the solution of
 * the m queens problem") state it, for any N in linear time: knight's moves, one solution a board. Both turn or reflect
 * the board at random, one of 8 ways.
 *
 * Biased in two dimensions, whatever N: each coordinate is uniform, but the two together are not. A uniform
 * pattern would have a queen on every one of the longest diagonals, which cross in the middle and end in the corners;
 * solutions have fewer there and more at the middle of each side, and so it is for almost all solutions of a large
 * board (Simkin 2021, "The number of n-queens configurations"). Measured for `search`, in blocks of 1/8 x 1/8, against
 * 1 for a uniform pattern:
 *
 *        N   corner   middle   side's middle   integral of [x + y < 0.7], 0.245, is off by
 *       16     0.64     0.78            1.27   0.016
 *       64     0.73     0.81            1.21   0.014
 *      256     0.75     0.82            1.20   0.013
 *     4096     0.76     0.82            1.19   0.012
 *
 * So more queens do not make the error of an integral go to zero. What depends on one coordinate is not biased.
 *
 * The points come in random order. More than two dimensions are padded (planar.h). */
#include <stdlib.h>

#include "cell.h"
#include "planar.h"
#include "stream.h"

#define MOST_QUEENS ((uint64_t)1 << 20) /* made whole, in time proportional to N */
#define MOST_STARTS 256
#define MOST_TRIES 128 /* of exchanges, for one queen in one sweep */

enum { SOLUTION_SEARCH, SOLUTION_CONSTRUCTION };

typedef struct queens_state {
  uint64_t samples, seed;
  int centred, solution;
} queens_state;

static asc_status queens_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const uint64_t samples = config->samples;
  if (samples == 2 || samples == 3)
    return asc_fail(error, ASC_UNSUPPORTED, "n-queens has no solution for %llu: choose 1, or 4 and more",
                    (unsigned long long)samples);
  if (samples > MOST_QUEENS)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "n-queens has at most 2^20 points, made whole in each pixel; %llu are asked for",
                    (unsigned long long)samples);
  queens_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "n-queens: out of memory");
  *state = (queens_state){samples, config->seed, (int)config->values[0], (int)config->values[1]};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, samples};
  return ASC_OK;
}

/* One queen a row, in `column[row]`, and how many stand on each diagonal of either direction. */
typedef struct board {
  uint32_t size;
  uint32_t *column, *rising, *falling;
} board;

static uint32_t *rising_at(const board *of, uint32_t row, uint32_t column) {
  return of->rising + row + (of->size - 1 - column);
}

static uint32_t *falling_at(const board *of, uint32_t row, uint32_t column) { return of->falling + row + column; }

static int attacked(const board *of, uint32_t row) {
  return *rising_at(of, row, of->column[row]) > 1 || *falling_at(of, row, of->column[row]) > 1;
}

/* Attacks are counted as the queens of a diagonal beyond its first. Returns how many a queen adds. */
static int place(const board *of, uint32_t row, uint32_t column) {
  return ((*rising_at(of, row, column))++ > 0) + ((*falling_at(of, row, column))++ > 0);
}

/* How many attacks the queen's removal takes away. */
static int lift(const board *of, uint32_t row, uint32_t column) {
  return (--*rising_at(of, row, column) > 0) + (--*falling_at(of, row, column) > 0);
}

/* Exchanges the queens of two rows if that leaves fewer attacks; by how many it does. */
static int exchange(const board *of, uint32_t a, uint32_t b) {
  const uint32_t left = of->column[a], right = of->column[b];
  const int before = lift(of, a, left) + lift(of, b, right);
  const int after = place(of, a, right) + place(of, b, left);
  if (after < before) {
    of->column[a] = right;
    of->column[b] = left;
    return before - after;
  }
  lift(of, a, right);
  lift(of, b, left);
  place(of, a, left);
  place(of, b, right);
  return 0;
}

static void shuffle(uint32_t *values, uint32_t count, asc_stream *stream) {
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t j = asc_stream_below(stream, i + 1);
    values[i] = values[j];
    values[j] = i;
  }
}

/* One start of the search; 1 where it ends at a solution. */
static int search(const board *of, asc_stream *stream) {
  const uint32_t n = of->size;
  const uint32_t most_tries = n < MOST_TRIES / 2 ? 2 * n : MOST_TRIES;
  int attacks = 0, mended;
  for (uint32_t i = 0; i < 2 * n - 1; i++) of->rising[i] = of->falling[i] = 0;
  shuffle(of->column, n, stream);
  for (uint32_t row = 0; row < n; row++) attacks += place(of, row, of->column[row]);
  do {
    mended = 0;
    for (uint32_t row = 0; row < n && attacks > mended; row++) {
      int better = !attacked(of, row);
      for (uint32_t tries = 0; tries < most_tries && !better; tries++) {
        const uint32_t other = asc_stream_below(stream, n);
        if (other == row) continue;
        better = exchange(of, row, other);
        mended += better;
      }
    }
    attacks -= mended;
  } while (attacks > 0 && mended > 0);
  return attacks == 0;
}

/* For an even number of queens from 4 on, rows and columns from 0 instead of the paper's 1. */
static void construct_even(uint32_t *column, uint32_t n) {
  const uint32_t half = n / 2;
  for (uint32_t row = 0; row < half; row++) {
    if (n % 6 != 2) { /* construction A */
      column[row] = 2 * row + 1;
      column[half + row] = 2 * row;
    } else { /* construction B */
      const uint32_t at = (2 * row + half - 1) % n;
      column[row] = at;
      column[n - 1 - row] = n - 1 - at;
    }
  }
}

/* Construction C: an odd board is an even one, which leaves the main diagonal empty, and a queen in the corner. */
static void construct(uint32_t *column, uint32_t n) {
  if (n > 1) construct_even(column, n - n % 2);
  if (n % 2) column[n - 1] = n - 1;
}

static asc_status solve(const queens_state *state, uint32_t *column, asc_stream *stream) {
  const uint32_t n = (uint32_t)state->samples;
  int solved = 0;
  if (state->solution == SOLUTION_SEARCH) {
    uint32_t *diagonals = malloc(2 * (2 * (size_t)n - 1) * sizeof *diagonals);
    if (!diagonals) return ASC_OUT_OF_MEMORY;
    const board of = {n, column, diagonals, diagonals + (2 * (size_t)n - 1)};
    for (int start = 0; start < MOST_STARTS && !solved; start++) solved = search(&of, stream);
    free(diagonals);
  }
  if (!solved) construct(column, n);
  return ASC_OK;
}

static asc_status queens_plane(const void *opaque, asc_key key, uint32_t pair, double (*points)[2]) {
  const queens_state *state = opaque;
  const uint32_t n = (uint32_t)state->samples;
  uint32_t *column = malloc(2 * (size_t)n * sizeof *column), *order = column + n;
  if (!column) return ASC_OUT_OF_MEMORY;
  asc_stream stream;
  asc_stream_begin(&stream, key, pair);
  const asc_status status = solve(state, column, &stream);
  if (status == ASC_OK) {
    shuffle(order, n, &stream);
    const uint32_t symmetry = asc_stream_bits(&stream);
    const uint32_t across = symmetry & 1u, flip_x = symmetry >> 1 & 1u, flip_y = symmetry >> 2 & 1u;
    for (uint32_t row = 0; row < n; row++) {
      const uint32_t x = flip_x ? n - 1 - column[row] : column[row], y = flip_y ? n - 1 - row : row;
      const asc_block bits = asc_hash(key, row, pair, ASC_PURPOSE_UNIFORM);
      double *point = points[order[row]];
      point[across] = asc_in_cell_or_centre(x, n, bits.word[0], state->centred);
      point[1 - across] = asc_in_cell_or_centre(y, n, bits.word[1], state->centred);
    }
  }
  free(column);
  return status;
}

static asc_status queens_fill(const void *opaque, const asc_range *range, double *points) {
  const queens_state *state = opaque;
  return asc_planar_fill(state, state->samples, state->seed, queens_plane, range, points);
}

static const asc_parameter queens_parameters[] = {
    {"centred", ASC_INTEGER, NULL, 0, 1, 0, "1: the centre of each cell"},
    {"solution", ASC_CHOICE, "search|construction", 0, 0, SOLUTION_SEARCH,
     "a random search, or one regular solution turned or reflected at random"},
};

const asc_sampler_interface asc_sampler_n_queens = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "n-queens",
    .title = "queens that do not attack each other; biased in two dimensions",
    .source = "Hoffman, Loessi, Moore 1969; Sosic, Gu 1994",
    .parameters = queens_parameters,
    .parameter_count = 2,
    .create = queens_create,
    .destroy = free,
    .fill = queens_fill,
};

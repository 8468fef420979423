/* Cells of a random Latin square, an n x n table in which each of n symbols stands once in each row and column.
 *
 * In three dimensions the n^2 cells of the whole square, (column, row, symbol), so N = n^2: each two of the three axes
 * have one point in each of n x n cells. The square is drawn uniformly from all Latin squares of order n by a walk of
 * n^2 + 20 steps (Jacobson and Matthews 1996, "Generating uniformly distributed random Latin squares", section 3), a
 * step leading from one proper square to the next, past improper ones: n moves on average (measured, n from 3 to 256).
 * Half as many steps leave no trace of the square that the walk starts from, in the mean number of 2 x 2 subsquares and
 * the share of cells that keep their symbol (measured, n from 4 to 33). Then rows, columns and symbols are permuted at
 * random, so squares that are renamings of one another are equally likely whatever the walk did. n is limited to 256:
 * n^3 moves take most of a second there.
 *
 * In two dimensions the n cells of one symbol, N = n. To permute the rows of a Latin square gives another, so the cells
 * of one symbol of a uniform one are a uniform permutation; it is drawn as such, any sample without the others. One or
 * more than three dimensions are padded from these: an independent square for each pair (0,1), (2,3), ..., shuffled
 * against each other, which is a permutation for each dimension.
 *
 * Each point lies anywhere in its cell; centred=1 puts it at the centre. */
#include <stdlib.h>

#include "cell.h"
#include "pattern.h"
#include "permutation.h"
#include "stream.h"

#define MOST_ORDER 256 /* an element fits in 8 bits */
#define FEWEST_STEPS 20

typedef struct latin_state {
  uint64_t samples, seed;
  uint32_t order; /* of the whole square, 0 where single symbols make the pattern */
  int centred;
} latin_state;

static asc_status latin_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const uint64_t samples = config->samples;
  const uint64_t order = config->dimensions == 3 ? asc_exact_root(samples, 2) : 0;
  if (config->dimensions == 3 && (order == 0 || order > MOST_ORDER))
    return asc_fail(error, ASC_UNSUPPORTED,
                    "latin-square has n x n points in three dimensions, n up to %d; %llu is not such a number: choose "
                    "1, 4, 9, 16, ... %d",
                    MOST_ORDER, (unsigned long long)samples, MOST_ORDER * MOST_ORDER);
  if (samples > ASC_NET_END)
    return asc_fail(error, ASC_UNSUPPORTED, "latin-square has at most 2^32 points; %llu are asked for",
                    (unsigned long long)samples);
  latin_state *state = malloc(sizeof *state);
  if (!state) return asc_fail(error, ASC_OUT_OF_MEMORY, "latin-square: out of memory");
  *state = (latin_state){samples, config->seed, (uint32_t)order, (int)config->values[0]};
  *made = (asc_sampler_state){state, ASC_TRAIT_RANDOMISED, samples};
  return ASC_OK;
}

/* Row, column and symbol. */
typedef struct triple {
  uint32_t row, column, symbol;
} triple;

/* The square as its incidence cube: a 1 at (row, column, symbol) for each cell. Each line of the cube is kept as the
 * place of its 1. In an improper square one entry, `hole`, is -1; the three lines through it have a second 1, at
 * `spare`. */
typedef struct square {
  uint32_t order;
  int improper;
  triple hole, spare;
  uint8_t *symbol; /* [row][column] */
  uint8_t *column; /* [row][symbol] */
  uint8_t *row;    /* [column][symbol] */
} square;

static uint8_t *line(const square *of, uint8_t *table, uint32_t first, uint32_t second) {
  return table + (size_t)first * of->order + second;
}

/* Takes one of the two 1s of a line at random and leaves the other in the table. */
static uint32_t take_one(uint8_t *kept, uint32_t spare, uint32_t coin) {
  if (coin & 1u) return spare;
  const uint32_t taken = *kept;
  *kept = (uint8_t)spare;
  return taken;
}

/* One +-1 move: adds 1 at `at` and takes 1 away at the ends of three edges from there, and so on around the box between
 * `at` and `to`. */
static void move(square *of, asc_stream *stream) {
  const uint32_t n = of->order;
  triple at, to;
  if (of->improper) {
    const uint32_t coins = asc_stream_bits(stream);
    at = of->hole;
    to.symbol = take_one(line(of, of->symbol, at.row, at.column), of->spare.symbol, coins);
    to.column = take_one(line(of, of->column, at.row, at.symbol), of->spare.column, coins >> 1);
    to.row = take_one(line(of, of->row, at.column, at.symbol), of->spare.row, coins >> 2);
  } else { /* any place of the cube that holds 0 */
    const uint32_t draw = asc_stream_below(stream, n * n * (n - 1));
    at = (triple){draw % n, draw / n % n, draw / (n * n)};
    to.symbol = *line(of, of->symbol, at.row, at.column);
    if (at.symbol >= to.symbol) at.symbol++;
    to.column = *line(of, of->column, at.row, at.symbol);
    to.row = *line(of, of->row, at.column, at.symbol);
    *line(of, of->symbol, at.row, at.column) = (uint8_t)at.symbol;
    *line(of, of->column, at.row, at.symbol) = (uint8_t)at.column;
    *line(of, of->row, at.column, at.symbol) = (uint8_t)at.row;
  }
  *line(of, of->symbol, at.row, to.column) = *line(of, of->symbol, to.row, at.column) = (uint8_t)to.symbol;
  *line(of, of->column, at.row, to.symbol) = *line(of, of->column, to.row, at.symbol) = (uint8_t)to.column;
  *line(of, of->row, at.column, to.symbol) = *line(of, of->row, to.column, at.symbol) = (uint8_t)to.row;
  of->improper = *line(of, of->symbol, to.row, to.column) != to.symbol;
  if (of->improper) {
    of->hole = to;
    of->spare = at;
    return;
  }
  *line(of, of->symbol, to.row, to.column) = (uint8_t)at.symbol;
  *line(of, of->column, to.row, to.symbol) = (uint8_t)at.column;
  *line(of, of->row, to.column, to.symbol) = (uint8_t)at.row;
}

/* From the cyclic square. Orders 1 and 2 have no place to go but by renaming. */
static void walk(square *of, asc_stream *stream) {
  const uint32_t n = of->order;
  for (uint32_t a = 0; a < n; a++)
    for (uint32_t b = 0; b < n; b++) {
      *line(of, of->symbol, a, b) = (uint8_t)((a + b) % n);
      *line(of, of->column, a, b) = *line(of, of->row, a, b) = (uint8_t)((b + n - a) % n);
    }
  of->improper = 0;
  for (uint32_t step = 0; n > 2 && step < n * n + FEWEST_STEPS; step++) {
    do move(of, stream);
    while (of->improper);
  }
}

static void shuffle(uint8_t *names, uint32_t count, asc_stream *stream) {
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t j = asc_stream_below(stream, i + 1);
    names[i] = names[j];
    names[j] = (uint8_t)i;
  }
}

static asc_status fill_square(const latin_state *state, const asc_range *range, asc_key key, double *points) {
  const uint32_t n = state->order;
  uint8_t *tables = malloc(3 * (size_t)n * n);
  if (!tables) return ASC_OUT_OF_MEMORY;
  square of = {.order = n, .symbol = tables, .column = tables + (size_t)n * n, .row = tables + 2 * (size_t)n * n};
  asc_stream stream;
  asc_stream_begin(&stream, key, 0);
  walk(&of, &stream);
  uint8_t names[3][MOST_ORDER];
  for (int axis = 0; axis < 3; axis++) shuffle(names[axis], n, &stream);
  for (size_t i = 0; i < range->sample_count; i++) {
    const uint64_t sample = range->first_sample + i;
    const uint32_t row = (uint32_t)(sample / n), column = (uint32_t)(sample % n);
    const uint32_t cell[3] = {names[0][column], names[1][row], names[2][*line(&of, of.symbol, row, column)]};
    const asc_block bits = asc_hash(key, sample, 0, ASC_PURPOSE_UNIFORM);
    for (uint32_t d = 0; d < range->dimension_count; d++) {
      const uint32_t dimension = range->first_dimension + d;
      points[i * range->dimension_count + d] =
          asc_in_cell_or_centre(cell[dimension], n, bits.word[dimension], state->centred);
    }
  }
  free(tables);
  return ASC_OK;
}

static void fill_dimension(const latin_state *state, const asc_range *range, asc_key key, uint32_t dimension,
                           double *points) {
  asc_permutation permutation;
  asc_permutation_make(&permutation, state->samples, key, dimension);
  for (size_t done = 0; done < range->sample_count; done += ASC_LANES) {
    asc_lanes bits;
    const size_t left = range->sample_count - done, count = left < ASC_LANES ? left : ASC_LANES;
    asc_cell_bits(key, range->first_sample + done, count, dimension, &bits);
    for (size_t i = 0; i < count; i++) {
      const uint64_t cell = asc_permutation_at(&permutation, range->first_sample + done + i);
      points[(done + i) * range->dimension_count + (dimension - range->first_dimension)] =
          asc_in_cell_or_centre(cell, state->samples, bits.word[0][i], state->centred);
    }
  }
}

static asc_status latin_fill(const void *opaque, const asc_range *range, double *points) {
  const latin_state *state = opaque;
  const asc_key key = asc_stream_key(state->seed, range->pixel_x, range->pixel_y);
  if (state->order) return fill_square(state, range, key, points);
  for (uint32_t d = 0; d < range->dimension_count; d++)
    fill_dimension(state, range, key, range->first_dimension + d, points);
  return ASC_OK;
}

static const asc_parameter latin_parameters[] = {
    {"centred", ASC_INTEGER, NULL, 0, 1, 0, "1: the centre of each cell"},
};

const asc_sampler_interface asc_sampler_latin_square = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "latin-square",
    .title = "one symbol of a random Latin square; in three dimensions the whole square",
    .source = "Jacobson, Matthews 1996",
    .parameters = latin_parameters,
    .parameter_count = 1,
    .create = latin_create,
    .destroy = free,
    .fill = latin_fill,
};

/* Nearby in space, far in time: k x k points, their slots of time exchanged until neighbours are far apart.
 *
 * Source: after Mitchell 1991, "Spectrally optimal sampling for distribution ray tracing", as Hanrahan 2000, CS348B,
 * has it: "nearby samples in space should differ greatly in time". The objective and the search are ours. Within a
 * distance r lie about pi r^2 samples, which share the time evenly if two at distance r are some 1/r^2 apart, so what
 * is made small is the sum over pairs, both distances around the border, r in cells up to sqrt 5, of (1/(r^2 |dt|))^2.
 * The slots begin as a random permutation; then 64 N times two random cells exchange theirs if that lowers the sum,
 * which takes about 13 microseconds a cell, 0.8 s for the most. The seed alone determines the table. How pixels differ,
 * what is jittered and centred=1 (the table of seed 0): space_time.h. */
#include <stdlib.h>

#include "space_time.h"
#include "stream.h"

#define LARGEST_SIDE 256
#define EXCHANGES 64 /* a cell */
#define REACH 2
#define NEIGHBOURS 20 /* with r^2 <= REACH^2 + 1 */

typedef struct search {
  uint32_t *slots;
  int32_t side, cells;
  int32_t offset[NEIGHBOURS][2];
  double weight[NEIGHBOURS]; /* r^-4 */
} search;

static uint64_t mitchell_slot(const asc_space_time *pattern, uint64_t column, uint64_t row) {
  return pattern->slots[row * pattern->side + column];
}

static search begin_search(asc_space_time *pattern) {
  const int32_t side = (int32_t)pattern->side;
  search made = {.slots = pattern->slots, .side = side, .cells = side * side};
  int count = 0;
  for (int y = -REACH; y <= REACH; y++)
    for (int x = -REACH; x <= REACH; x++) {
      const int square = x * x + y * y;
      if (square == 0 || square > REACH * REACH + 1) continue;
      made.offset[count][0] = x;
      made.offset[count][1] = y;
      made.weight[count++] = 1.0 / (square * square);
    }
  return made;
}

static int32_t around(int32_t at, int32_t side) {
  if (side <= REACH) return (at + 2 * side) % side;
  return at < 0 ? at + side : at >= side ? at - side : at;
}

/* |dt|^-2, dt in slots, around the border; 1 for equal slots, which only cells that do not count have. */
static inline double closeness(int32_t one, int32_t other, int32_t slots) {
  const int32_t apart = one > other ? one - other : other - one;
  const int32_t nearest = apart < slots - apart ? apart : slots - apart;
  const double dt = nearest > 1 ? nearest : 1;
  return 1.0 / (dt * dt);
}

/* How much the sum would grow if `cell` had slot `after` and not `before`; its pair with `other`, with which it
 * exchanges, stays as far apart. */
static double growth(const search *in, int32_t cell, int32_t other, int32_t before, int32_t after) {
  const int32_t column = cell % in->side, row = cell / in->side;
  int32_t slots[NEIGHBOURS];
  double weight[NEIGHBOURS], term[NEIGHBOURS], sum = 0.0;
  for (int i = 0; i < NEIGHBOURS; i++) {
    const int32_t there =
        around(row + in->offset[i][1], in->side) * in->side + around(column + in->offset[i][0], in->side);
    slots[i] = (int32_t)in->slots[there];
    weight[i] = there == cell || there == other ? 0.0 : in->weight[i];
  }
  for (int i = 0; i < NEIGHBOURS; i++) /* apart from the loop above and the sum, so that it is vectorised */
    term[i] = weight[i] * (closeness(slots[i], after, in->cells) - closeness(slots[i], before, in->cells));
  for (int i = 0; i < NEIGHBOURS; i++) sum += term[i];
  return sum;
}

static void exchange(uint32_t *slots, uint32_t one, uint32_t other) {
  const uint32_t kept = slots[one];
  slots[one] = slots[other];
  slots[other] = kept;
}

static void optimise(asc_space_time *pattern) {
  const search within = begin_search(pattern);
  const uint32_t cells = (uint32_t)within.cells;
  uint32_t *slots = pattern->slots;
  asc_stream stream;
  asc_stream_begin(&stream, asc_stream_key(pattern->centred ? 0 : pattern->seed, 0, 0), 0);
  for (uint32_t i = 0; i < cells; i++) {
    slots[i] = i;
    exchange(slots, i, asc_stream_below(&stream, i + 1));
  }
  for (uint32_t step = 0; step < EXCHANGES * cells; step++) {
    const uint32_t one = asc_stream_below(&stream, cells), other = asc_stream_below(&stream, cells);
    const int32_t a = (int32_t)one, b = (int32_t)other, at_a = (int32_t)slots[one], at_b = (int32_t)slots[other];
    if (growth(&within, a, b, at_a, at_b) + growth(&within, b, a, at_b, at_a) < 0.0) exchange(slots, one, other);
  }
}

static asc_status mitchell_spacetime_create(const asc_sampler_config *config, asc_sampler_state *made,
                                            asc_error *error) {
  const asc_status status = asc_space_time_check("mitchell-spacetime", config, error);
  if (status) return status;
  const uint64_t side = asc_exact_root(config->samples, 2);
  if (side == 0 || side > LARGEST_SIDE)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "mitchell-spacetime has k x k points, k up to %d, not %llu: choose 1, 4, 9, 16, ... 65536",
                    LARGEST_SIDE, (unsigned long long)config->samples);
  asc_space_time *pattern = asc_space_time_new(config, side, mitchell_slot, (size_t)config->samples);
  if (!pattern) return asc_fail(error, ASC_OUT_OF_MEMORY, "mitchell-spacetime: out of memory");
  optimise(pattern);
  *made = asc_space_time_state(pattern);
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_mitchell_spacetime = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "mitchell-spacetime",
    .title = "nearby in space, far in time, by optimisation, in x, y and t",
    .source = "after Mitchell 1991; Hanrahan 2000, CS348B",
    .parameters = &asc_space_time_centred,
    .parameter_count = 1,
    .create = mitchell_spacetime_create,
    .destroy = free,
    .fill = asc_space_time_fill,
};

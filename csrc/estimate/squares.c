/* Dividing squares, and finding their corners. */
#include "squares.h"

#include <math.h>
#include <stdlib.h>

/* ---- The table ---- */

static size_t slot_of(const asc_point_table *table, uint64_t key) {
  /* Fibonacci hashing (Knuth, volume 3, 6.4): the keys of a picture come in rows. */
  size_t slot = (size_t)((key * 0x9e3779b97f4a7c15u) >> 32) & (table->capacity - 1);
  while (table->keys[slot] && table->keys[slot] != key + 1) slot = (slot + 1) & (table->capacity - 1);
  return slot;
}

static asc_status enlarge(asc_point_table *table) {
  const size_t capacity = table->capacity ? 2 * table->capacity : 1024;
  asc_point_table larger = {calloc(capacity, sizeof *larger.keys), malloc(capacity * sizeof *larger.found), capacity,
                            table->count};
  if (!larger.keys || !larger.found) {
    free(larger.keys);
    free(larger.found);
    return ASC_OUT_OF_MEMORY;
  }
  for (size_t i = 0; i < table->capacity; i++) {
    if (!table->keys[i]) continue;
    const size_t slot = slot_of(&larger, table->keys[i] - 1);
    larger.keys[slot] = table->keys[i];
    larger.found[slot] = table->found[i];
  }
  free(table->keys);
  free(table->found);
  *table = larger;
  return ASC_OK;
}

static int look_up(const asc_point_table *table, uint64_t key, uint32_t *found) {
  if (!table->capacity) return 0;
  const size_t slot = slot_of(table, key);
  if (!table->keys[slot]) return 0;
  *found = table->found[slot];
  return 1;
}

static asc_status insert(asc_point_table *table, uint64_t key, uint32_t found) {
  if (2 * (table->count + 1) > table->capacity) {
    const asc_status status = enlarge(table);
    if (status) return status;
  }
  const size_t slot = slot_of(table, key);
  table->keys[slot] = key + 1;
  table->found[slot] = found;
  table->count++;
  return ASC_OK;
}

/* ---- Points ---- */

static uint64_t own_key(uint32_t pixel, uint32_t x, uint32_t y) {
  return (uint64_t)pixel << 32 | (uint64_t)y << 16 | x;
}

static uint64_t shared_key(const asc_squares *of, uint32_t pixel, uint32_t x, uint32_t y) {
  const uint64_t columns = of->area.columns;
  const uint64_t across = ((pixel % columns) << of->depth) + x, down = ((pixel / columns) << of->depth) + y;
  return down * ((columns << of->depth) + 1) + across;
}

static int on_border(const asc_squares *of, uint32_t x, uint32_t y) {
  const uint32_t inside = (1u << of->depth) - 1;
  return (x & inside) == 0 || (y & inside) == 0;
}

uint64_t asc_squares_index(const asc_squares *of, uint32_t x, uint32_t y) {
  /* Not row by row: the points of a column would all be displaced to the same part of their cells, since the last
   * digits of an index are the first of a radical inverse. So both rows and columns have all last digits. */
  const uint64_t side = 1ull << of->depth;
  return y * side + (x + 3ull * y) % side;
}

static asc_status add_point(asc_squares *of, uint32_t pixel, uint32_t x, uint32_t y, uint32_t *found) {
  const uint64_t key = shared_key(of, pixel, x, y);
  if (on_border(of, x, y) && look_up(&of->shared, key, found)) return ASC_OK;
  if (of->point_count == of->point_capacity) {
    const uint32_t capacity = of->point_capacity ? 2 * of->point_capacity : 1024;
    void *points = realloc(of->points, (size_t)capacity * sizeof *of->points);
    if (points) of->points = points;
    void *values = realloc(of->values, (size_t)capacity * of->self->channels * sizeof *of->values);
    if (values) of->values = values;
    if (!points || !values || capacity < of->point_capacity) return ASC_OUT_OF_MEMORY;
    of->point_capacity = capacity;
  }
  *found = of->point_count;
  of->points[of->point_count++] = (struct asc_squares_wish){pixel, x, y};
  return on_border(of, x, y) ? insert(&of->shared, key, *found) : ASC_OK;
}

/* Notes that a pixel uses a point. */
static asc_status use_point(asc_squares *of, uint32_t pixel, uint32_t x, uint32_t y, uint32_t *found) {
  const uint64_t key = own_key(pixel, x, y);
  if (look_up(&of->own, key, found)) return ASC_OK;
  const asc_status status = add_point(of, pixel, x, y, found);
  if (status) return status;
  of->spent[pixel]++;
  return insert(&of->own, key, *found);
}

asc_status asc_squares_take(asc_squares *of, asc_integrand integrand, void *context, uint64_t *spent,
                            asc_error *error) {
  const uint32_t count = of->point_count - of->taken, side = 1u << of->depth;
  const double step = 1.0 / side;
  if (count == 0) return ASC_OK;
  asc_draw *draws = calloc(count, sizeof *draws);
  if (!draws) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  for (uint32_t i = 0; i < count; i++) {
    const struct asc_squares_wish *point = &of->points[of->taken + i];
    /* A point belongs to the pixel to whose lower right it lies: all that share it find the same sample. */
    const uint32_t x = point->x % side, y = point->y % side;
    const asc_pixel pixel = asc_pixel_of(&of->area, point->pixel);
    draws[i] = (asc_draw){.pixel = {pixel.x + (point->x == side), pixel.y + (point->y == side)},
                          .first = asc_squares_index(of, x, y),
                          .count = 1,
                          .x = (x - 0.5) * step,
                          .y = (y - 0.5) * step,
                          .width = step,
                          .height = step,
                          .values = of->values + (size_t)(of->taken + i) * of->self->channels};
  }
  const asc_status status = asc_take(of->self, &of->group, draws, count, integrand, context, error);
  free(draws);
  of->taken = of->point_count;
  *spent += count;
  return status;
}

static const double *values_at(const asc_squares *of, uint32_t pixel, uint32_t x, uint32_t y) {
  uint32_t found = 0;
  (void)look_up(&of->own, own_key(pixel, x, y), &found);
  return of->values + (size_t)found * of->self->channels;
}

const double *asc_squares_corner(const asc_squares *of, const asc_square *square, int corner) {
  return of->values + (size_t)square->corners[corner] * of->self->channels;
}

const double *asc_squares_origin(const asc_squares *of, uint32_t pixel) { return values_at(of, pixel, 0, 0); }

/* ---- Squares ---- */

asc_status asc_squares_make(asc_squares *made, const asc_estimator *self, const asc_group *group, uint32_t ring,
                            uint32_t depth) {
  *made = (asc_squares){.self = self, .group = *group, .ring = ring, .depth = depth};
  const int32_t out = (int32_t)ring;
  made->area = (asc_group){group->x - out, group->y - out, group->columns + 2 * ring, group->rows + 2 * ring};
  made->spent = calloc((size_t)made->area.columns * made->area.rows, sizeof *made->spent);
  return made->spent ? ASC_OK : ASC_OUT_OF_MEMORY;
}

void asc_squares_free(asc_squares *made) {
  free(made->squares);
  free(made->own.keys);
  free(made->own.found);
  free(made->shared.keys);
  free(made->shared.found);
  free(made->points);
  free(made->values);
  free(made->spent);
}

static asc_status add_square(asc_squares *to, asc_square square) {
  if (to->count == to->capacity) {
    const uint32_t capacity = to->capacity ? 2 * to->capacity : 1024;
    void *larger = capacity > to->capacity ? realloc(to->squares, (size_t)capacity * sizeof *to->squares) : NULL;
    if (!larger) return ASC_OUT_OF_MEMORY;
    to->squares = larger;
    to->capacity = capacity;
  }
  const uint32_t side = 1u << (to->depth - square.level);
  asc_status status = ASC_OK;
  for (uint32_t corner = 0; corner < 4 && status == ASC_OK; corner++)
    status = use_point(to, square.pixel, square.x + corner % 2 * side, square.y + corner / 2 * side,
                       &square.corners[corner]);
  to->squares[to->count++] = square;
  return status;
}

asc_status asc_squares_add_pixel(asc_squares *to, uint32_t pixel) {
  return add_square(to, (asc_square){.pixel = pixel});
}

asc_status asc_squares_add_points(asc_squares *to, uint32_t pixel, uint32_t start) {
  const uint32_t past = 1u << start, step = 1u << (to->depth - start);
  uint32_t found = 0;
  asc_status status = ASC_OK;
  for (uint32_t y = 0; y <= past; y++)
    for (uint32_t x = 0; x <= past && status == ASC_OK; x++) status = use_point(to, pixel, x * step, y * step, &found);
  return status;
}

const double *asc_squares_around(const asc_squares *of, uint32_t pixel, int64_t x, int64_t y) {
  const int64_t side = (int64_t)1 << of->depth;
  /* A point on a border is one of either pixel: of the nearer one, which is there. */
  const int64_t across = x < 0 ? -1 : x > side ? 1 : 0, down = y < 0 ? -1 : y > side ? 1 : 0;
  return values_at(of, (uint32_t)(pixel + down * (int64_t)of->area.columns + across), (uint32_t)(x - across * side),
                   (uint32_t)(y - down * side));
}

/* How many of the nine points of a square in quarters its pixel does not use yet. */
static uint64_t new_points(const asc_squares *of, const asc_square *square, uint32_t half) {
  uint64_t count = 0;
  for (uint32_t i = 0; i < 9; i++) {
    uint32_t found;
    count += !look_up(&of->own, own_key(square->pixel, square->x + i % 3 * half, square->y + i / 3 * half), &found);
  }
  return count;
}

asc_status asc_squares_divide(asc_squares *of, uint32_t square, uint64_t most) {
  const asc_square whole = of->squares[square];
  const uint32_t half = 1u << (of->depth - whole.level - 1);
  if (of->spent[whole.pixel] + new_points(of, &whole, half) > most) return ASC_OK;
  of->squares[square].divided = 1;
  asc_status status = ASC_OK;
  for (uint32_t i = 0; i < 4 && status == ASC_OK; i++)
    status = add_square(of, (asc_square){.pixel = whole.pixel,
                                         .x = whole.x + i % 2 * half,
                                         .y = whole.y + i / 2 * half,
                                         .level = whole.level + 1});
  return status;
}

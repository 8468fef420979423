/* Nearby in the first group, far apart in the others: sampler.h has the arrangement, asc_arrangement.
 *
 * Source: after Hanrahan 2000, CS348B, "Space-time patterns": "nearby samples in space should differ greatly in time".
 * The construction is ours: that of Hammersley 1960 between ranks along curves. Hilbert 1891, "Ueber die stetige
 * Abbildung einer Linie auf ein Flaechenstueck". */
#include <stdlib.h>
#include <string.h>

#include "arrangement.h"
#include "permutation.h"

#define CURVE_LEVELS 24 /* binary digits of each coordinate along the curve */
#define INDEX_BITS 14   /* of a sample's */

static const uint8_t bases[] = {2,  3,  5,  7,  11, 13, 17, 19, 23, 29, 31, 37,
                                41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89};
#define BASES (sizeof bases / sizeof *bases)

/* How far along the Hilbert curve of the unit square, in 4^-CURVE_LEVELS: level by level the quadrant's number, and the
 * coordinates turned into that quadrant's own. */
static uint64_t along_curve(double x, double y) {
  uint32_t column = (uint32_t)(x * (1u << CURVE_LEVELS)), row = (uint32_t)(y * (1u << CURVE_LEVELS));
  uint64_t distance = 0;
  for (uint32_t half = 1u << (CURVE_LEVELS - 1); half > 0; half /= 2) {
    const uint32_t right = (column & half) != 0, upper = (row & half) != 0;
    distance = 4 * distance + ((3 * right) ^ upper);
    /* In the lower quadrants the curve is mirrored, in the right one turned over too: by masks, as which is random. */
    const uint32_t turned = 0u - (right & (upper ^ 1)), mirrored = upper - 1;
    column ^= turned;
    row ^= turned;
    const uint32_t exchanged = (column ^ row) & mirrored;
    column ^= exchanged;
    row ^= exchanged;
  }
  return distance;
}

/* Sorts by merging runs, which double; through `scratch`, of the same size. */
static void sort(uint64_t *values, uint64_t *scratch, size_t count) {
  uint64_t *from = values, *to = scratch;
  for (size_t run = 1; run < count; run *= 2) {
    for (size_t begin = 0; begin < count; begin += 2 * run) {
      const size_t middle = begin + run < count ? begin + run : count;
      const size_t end = begin + 2 * run < count ? begin + 2 * run : count;
      size_t left = begin, right = middle;
      for (size_t i = begin; i < end; i++) {
        const int from_left = right == end || (left < middle && from[left] < from[right]);
        to[i] = from_left ? from[left] : from[right];
        left += (size_t)from_left;
        right += (size_t)!from_left;
      }
    }
    uint64_t *const kept = from;
    from = to;
    to = kept;
  }
  if (from != values) memcpy(values, from, count * sizeof *values);
}

/* Writes the numbers of points in their order along a curve of their first two dimensions, or of their one. */
static void order_points(const double *points, size_t count, uint32_t dimensions, uint64_t *order, uint64_t *scratch) {
  for (size_t i = 0; i < count; i++) {
    const double *point = points + i * dimensions;
    const uint64_t place = dimensions > 1 ? along_curve(point[0], point[1]) : (uint64_t)(point[0] * 0x1p48);
    order[i] = place << INDEX_BITS | i; /* its number below, so that no two are alike */
  }
  sort(order, scratch, count);
  for (size_t i = 0; i < count; i++) order[i] &= ((uint64_t)1 << INDEX_BITS) - 1;
}

/* Writes the numbers k = 0 .. count - 1 in the order of their radical inverses, the digits of each place permuted. */
static void order_inverses(asc_key key, size_t group, size_t count, uint64_t *order, uint64_t *scratch) {
  const uint32_t base = bases[group - 1];
  memset(order, 0, count * sizeof *order);
  uint64_t power = 1;
  for (uint32_t place = 0; power < count; place++, power *= base) {
    asc_permutation digits; /* of up to 64 kinds they are all alike, of more the keyed one's */
    asc_permutation_make(&digits, base, key, (uint32_t)(64 * group) + place);
    uint64_t digit = 0;
    for (size_t k = 0; k < count; digit = digit + 1 < base ? digit + 1 : 0) {
      const uint64_t permuted = asc_permutation_at(&digits, digit);
      const size_t end = count - k < power ? count : k + (size_t)power;
      for (; k < end; k++) order[k] = order[k] * base + permuted;
    }
  }
  for (size_t k = 0; k < count; k++) order[k] = order[k] << INDEX_BITS | k;
  sort(order, scratch, count);
  for (size_t k = 0; k < count; k++) order[k] &= ((uint64_t)1 << INDEX_BITS) - 1;
}

static size_t rotation(asc_key key, size_t group, uint32_t which, size_t count) {
  const uint64_t bits = asc_draw(key, (uint32_t)(2 * group) + which, ASC_PURPOSE_RANK);
  return (size_t)(((bits >> 32) * count) >> 32);
}

/* Writes which point of a further group each rank of the first has. `order`: the group's points along their curve. */
static void match(asc_key key, size_t group, size_t count, const uint64_t *order, uint64_t *scratch, uint64_t *point) {
  if (group > BASES) {
    asc_permutation shuffle;
    asc_permutation_make(&shuffle, count, key, (uint32_t)(64 * group));
    for (size_t k = 0; k < count; k++) point[k] = asc_permutation_at(&shuffle, k);
    return;
  }
  order_inverses(key, group, count, scratch, point);
  const size_t first = rotation(key, group, 0, count), further = rotation(key, group, 1, count);
  for (size_t rank = 0; rank < count; rank++) {
    const size_t k = (size_t)scratch[rank] + first, there = rank + further;
    point[k < count ? k : k - count] = order[there < count ? there : there - count];
  }
}

/* Memory of one call: of the first group's points and one other's, and five numbers of each sample. */
typedef struct work {
  double *first, *further;
  uint64_t *ranked; /* the samples along the first group's curve */
  uint64_t *order, *scratch, *point;
} work;

static asc_status fill_group(const asc_arranged *of, size_t g, const work *in, const asc_range *range,
                             const asc_columns *columns, double *points) {
  const asc_arranged_group *group = &of->groups[g];
  const size_t count = (size_t)of->desc.samples;
  const asc_range whole = {range->pixel_x, range->pixel_y, 0, count, 0, group->size};
  const asc_status status = asc_sampler_fill(group->pattern, &whole, in->further);
  if (status) return status;
  order_points(in->further, count, group->size, in->order, in->scratch);
  match(asc_arranged_key(of, range), g, count, in->order, in->scratch, in->point);
  for (size_t rank = 0; rank < count; rank++) {
    const uint64_t sample = in->ranked[rank];
    if (sample < range->first_sample || sample - range->first_sample >= range->sample_count) continue;
    memcpy(points + (sample - range->first_sample) * range->dimension_count + columns->column,
           in->further + in->point[rank] * group->size + columns->first, columns->count * sizeof *points);
  }
  return ASC_OK;
}

static asc_status fill_groups(const asc_arranged *of, const work *in, const asc_range *range, double *points) {
  const size_t count = (size_t)of->desc.samples;
  const asc_arranged_group *first = &of->groups[0];
  const asc_range whole = {range->pixel_x, range->pixel_y, 0, count, 0, first->size};
  asc_status status = asc_sampler_fill(first->pattern, &whole, in->first);
  if (status) return status;
  order_points(in->first, count, first->size, in->ranked, in->scratch);
  for (size_t g = 0; g < of->count && status == ASC_OK; g++) {
    const asc_columns columns = asc_columns_of(&of->groups[g], range);
    if (columns.count == 0) continue;
    if (g > 0) {
      status = fill_group(of, g, in, range, &columns, points);
      continue;
    }
    for (size_t i = 0; i < range->sample_count; i++)
      memcpy(points + i * range->dimension_count + columns.column,
             in->first + (range->first_sample + i) * first->size + columns.first, columns.count * sizeof *points);
  }
  return status;
}

asc_status asc_decorrelated_fill(const void *arranged, const asc_range *range, double *points) {
  const asc_arranged *of = arranged;
  const size_t count = (size_t)of->desc.samples;
  uint32_t widest = 0;
  for (size_t g = 1; g < of->count; g++) widest = of->groups[g].size > widest ? of->groups[g].size : widest;
  double *values = malloc(count * (of->groups[0].size + widest) * sizeof *values);
  uint64_t *numbers = malloc(count * 4 * sizeof *numbers);
  asc_status status = ASC_OUT_OF_MEMORY;
  if (values && numbers) {
    const work in = {values,
                     values + count * of->groups[0].size,
                     numbers,
                     numbers + count,
                     numbers + 2 * count,
                     numbers + 3 * count};
    status = fill_groups(of, &in, range, points);
  }
  free(values);
  free(numbers);
  return status;
}

#include "gaps.h"

#include <math.h>
#include <stdlib.h>

#define BORDER 3
#define NEIGHBOURS ((2 * BORDER + 1) * (2 * BORDER + 1))
#define MOST_ALONG ((uint64_t)1 << 30) /* squares along an edge: below that no area is left */
#define NOWHERE 8.0                    /* the coordinates of an empty cell's point: far from all */

void asc_gaps_end(asc_gaps *gaps) {
  free(gaps->centre);
  free(gaps->open);
  free(gaps->next);
}

asc_status asc_gaps_begin(asc_gaps *gaps, double radius, int toroidal, const double (*points)[2], size_t count) {
  const uint32_t side = (uint32_t)ceil(sqrt(2.0) / radius), stride = side + 2 * BORDER;
  const size_t cells = (size_t)stride * stride, capacity = (size_t)4 * side * side;
  *gaps = (asc_gaps){.radius = radius,
                     .squared_radius = radius * radius,
                     .toroidal = toroidal,
                     .side = side,
                     .stride = stride,
                     .reach = radius * side <= 2.0 ? 2 : BORDER,
                     .capacity = capacity};
  gaps->centre = malloc(cells * sizeof *gaps->centre);
  gaps->open = malloc(capacity * sizeof *gaps->open);
  gaps->next = malloc(capacity * sizeof *gaps->next);
  if (!gaps->centre || !gaps->open || !gaps->next) {
    asc_gaps_end(gaps);
    return ASC_OUT_OF_MEMORY;
  }
  for (size_t i = 0; i < cells; i++) gaps->centre[i][0] = gaps->centre[i][1] = NOWHERE;
  for (size_t i = 0; i < count; i++) asc_gaps_add(gaps, points[i]);
  for (uint32_t y = 0; y < side; y++)
    for (uint32_t x = 0; x < side; x++)
      if (gaps->centre[(size_t)(y + BORDER) * stride + x + BORDER][0] == NOWHERE)
        gaps->open[gaps->count++] = (asc_gaps_square){x, y};
  return ASC_OK;
}

void asc_gaps_add(asc_gaps *gaps, const double point[2]) {
  const int64_t side = gaps->side, stride = gaps->stride;
  const int64_t column = (int64_t)(point[0] * (double)side), row = (int64_t)(point[1] * (double)side);
  const int64_t turns = gaps->toroidal ? (BORDER + side - 1) / side : 0;
  for (int64_t v = -turns; v <= turns; v++)
    for (int64_t u = -turns; u <= turns; u++) {
      const int64_t x = column + u * side + BORDER, y = row + v * side + BORDER;
      if (x < 0 || y < 0 || x >= stride || y >= stride) continue;
      gaps->centre[y * stride + x][0] = point[0] + (double)u;
      gaps->centre[y * stride + x][1] = point[1] + (double)v;
    }
}

static double along(const asc_gaps *gaps) { return (double)((uint64_t)gaps->side << gaps->level); }

size_t asc_gaps_draw(const asc_gaps *gaps, asc_stream *stream, double place[2]) {
  const size_t k = asc_stream_below(stream, (uint32_t)gaps->count);
  const double squares = along(gaps);
  place[0] = ((double)gaps->open[k].x + asc_stream_unit(stream)) / squares;
  place[1] = ((double)gaps->open[k].y + asc_stream_unit(stream)) / squares;
  for (int axis = 0; axis < 2; axis++)
    if (place[axis] >= 1.0) place[axis] = 1.0 - 0x1p-53; /* by rounding, in the smallest squares */
  return k;
}

/* The cells that hold points as near as the radius to a place of square k: (2 reach + 1) rows from this one on. */
static const double (*neighbourhood(const asc_gaps *gaps, size_t k))[2] {
  const size_t column = (gaps->open[k].x >> gaps->level) + BORDER - gaps->reach;
  const size_t row = (gaps->open[k].y >> gaps->level) + BORDER - gaps->reach;
  return (const double(*)[2])gaps->centre + row * gaps->stride + column;
}

/* Rows of a width that the compiler knows, so that it unrolls them. */
static inline double nearest_of_rows(const double (*row)[2], size_t stride, uint32_t width, const double place[2],
                                     double enough) {
  double least = NOWHERE * NOWHERE;
  for (uint32_t j = 0; j < width && least > enough; j++, row += stride)
    for (uint32_t i = 0; i < width; i++) {
      const double dx = row[i][0] - place[0], dy = row[i][1] - place[1];
      const double squared = dx * dx + dy * dy;
      least = squared < least ? squared : least;
    }
  return least;
}

double asc_gaps_nearest(const asc_gaps *gaps, size_t k, const double place[2], double enough) {
  const double(*row)[2] = neighbourhood(gaps, k);
  return gaps->reach == 2 ? nearest_of_rows(row, gaps->stride, 5, place, enough)
                          : nearest_of_rows(row, gaps->stride, 2 * BORDER + 1, place, enough);
}

void asc_gaps_drop(asc_gaps *gaps, size_t k) { gaps->open[k] = gaps->open[--gaps->count]; }

/* The points whose discs can cover part of square k. */
static uint32_t gather(const asc_gaps *gaps, size_t k, double (*centres)[2]) {
  const double(*row)[2] = neighbourhood(gaps, k);
  const uint32_t width = 2 * gaps->reach + 1;
  uint32_t count = 0;
  for (uint32_t j = 0; j < width; j++, row += gaps->stride)
    for (uint32_t i = 0; i < width; i++) {
      centres[count][0] = row[i][0];
      centres[count][1] = row[i][1];
      count += row[i][0] != NOWHERE; /* no branch: none could be predicted */
    }
  return count;
}

/* Whether the square around (x, y) lies inside a disc around one of `centres`: its farthest corner does. */
static int covered(const double (*centres)[2], uint32_t count, double x, double y, double half, double squared_radius) {
  for (uint32_t i = 0; i < count; i++) {
    /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): the first `count` were written */
    const double dx = fabs(centres[i][0] - x) + half, dy = fabs(centres[i][1] - y) + half;
    if (dx * dx + dy * dy < squared_radius) return 1;
  }
  return 0;
}

int asc_gaps_quarter(asc_gaps *gaps) {
  const double squares = 2.0 * along(gaps), half = 0.5 / squares;
  if (squares > (double)MOST_ALONG) return 0;
  size_t kept = 0;
  for (size_t k = 0; k < gaps->count; k++) {
    double centres[NEIGHBOURS + 1][2]; /* one is written past those that count */
    const uint32_t near = gather(gaps, k, centres);
    if (kept + 4 > gaps->capacity) return 0;
    for (uint32_t q = 0; q < 4; q++) {
      const asc_gaps_square part = {2 * gaps->open[k].x + (q & 1u), 2 * gaps->open[k].y + (q >> 1)};
      const double x = ((double)part.x + 0.5) / squares, y = ((double)part.y + 0.5) / squares;
      gaps->next[kept] = part;
      kept += !covered((const double(*)[2])centres, near, x, y, half, gaps->squared_radius);
    }
  }
  asc_gaps_square *swapped = gaps->open;
  gaps->open = gaps->next;
  gaps->next = swapped;
  gaps->count = kept;
  gaps->level++;
  return 1;
}

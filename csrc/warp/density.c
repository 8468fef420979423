/* Densities that are constant in each cell of a regular grid, by the inverse of the distribution function: of the row
 * (the marginal), then within the row (the conditional).
 *
 * Source: Devroye 1986, "Non-uniform random variate generation", sections II.2 and XI.1. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "rows.h"

#define MOST_CELLS ((size_t)1 << 31) /* of one axis: x tells cells apart with 22 bits to spare */

struct asc_density {
  size_t columns, rows;
  uint32_t dimensions;
  double *rows_below;  /* [rows + 1]: the share of the rows below each */
  double *cells_below; /* [rows][columns + 1]: the share of its row that lies left of each cell */
  double *height;      /* [rows][columns]: the pdf */
  double storage[];
};

/* Shares of n weights below each, from 0 to exactly 1; all 0 where the sum is 0. `weights` may be `below + 1`. */
static void cumulate(const double *weights, size_t n, double *below) {
  long double whole = 0.0L, sum = 0.0L;
  for (size_t i = 0; i < n; i++) whole += weights[i];
  below[0] = 0.0;
  for (size_t i = 0; i < n; i++) {
    sum += weights[i];
    below[i + 1] = whole > 0.0L ? (double)(sum / whole) : 0.0;
  }
}

static asc_status check_weights(const asc_density_desc *desc, size_t rows, double *largest, asc_error *error) {
  *largest = 0.0;
  for (size_t i = 0; i < rows * desc->columns; i++) {
    const double weight = desc->weights[i];
    if (!(weight >= 0.0 && isfinite(weight)))
      return asc_fail(error, ASC_INVALID_VALUE,
                      "weight %g of row %zu, column %zu: weights of a density are finite and not negative", weight,
                      i / desc->columns, i % desc->columns);
    *largest = fmax(*largest, weight);
  }
  if (*largest == 0.0) return asc_fail(error, ASC_INVALID_VALUE, "all weights are zero: one at least must be above 0");
  return ASC_OK;
}

/* Fills in heights and shares. Weights are scaled by the largest, so that no sum overflows. */
static void tabulate(asc_density *made, const double *weights, double largest) {
  const size_t columns = made->columns, rows = made->rows;
  long double whole = 0.0L;
  for (size_t row = 0; row < rows; row++) {
    long double sum = 0.0L;
    for (size_t i = row * columns; i < (row + 1) * columns; i++) sum += made->height[i] = weights[i] / largest;
    cumulate(made->height + row * columns, columns, made->cells_below + row * (columns + 1));
    made->rows_below[row + 1] = (double)sum;
    whole += sum;
  }
  cumulate(made->rows_below + 1, rows, made->rows_below);
  const long double scale = (long double)columns * (long double)rows / whole;
  for (size_t i = 0; i < rows * columns; i++) made->height[i] = (double)(made->height[i] * scale);
}

asc_status asc_density_create(const asc_density_desc *desc, asc_density **density, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->weights || !density)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_density_create: desc needs its struct_size and weights");
  *density = NULL;
  const size_t columns = desc->columns, rows = desc->rows ? desc->rows : 1;
  if (columns < 1 || columns > MOST_CELLS || rows > MOST_CELLS || rows > SIZE_MAX / 64 / columns)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a density has 1 to 2^31 columns and rows; not %zu and %zu", columns,
                    rows);
  double largest;
  const asc_status status = check_weights(desc, rows, &largest, error);
  if (status) return status;
  const size_t shares = (rows + 1) + rows * (columns + 1);
  asc_density *made = malloc(sizeof *made + (shares + rows * columns) * sizeof(double));
  if (!made) return asc_fail(error, ASC_OUT_OF_MEMORY, "a density of %zu cells: out of memory", rows * columns);
  made->columns = columns;
  made->rows = rows;
  made->dimensions = desc->rows ? 2 : 1;
  made->rows_below = made->storage;
  made->cells_below = made->rows_below + rows + 1;
  made->height = made->storage + shares;
  tabulate(made, desc->weights, largest);
  *density = made;
  return ASC_OK;
}

void asc_density_destroy(asc_density *density) { free(density); }

uint32_t asc_density_dimensions(const asc_density *density) { return density ? density->dimensions : 0; }

/* The cell of a position in [0, 1), as everybody computes it. */
static size_t cell_of(double x, size_t n) {
  const size_t cell = (size_t)(x * (double)n);
  return cell < n ? cell : n - 1;
}

/* The cell whose shares enclose u, so never an empty one, and the position in [0, 1) that is u in it. */
static double find(const double *below, size_t n, double u, size_t *cell) {
  const double share = fmin(u, 1.0 - 0x1p-53);
  size_t low = 0, high = n; /* below[low] <= share < below[high] */
  while (high - low > 1) {
    const size_t middle = low + (high - low) / 2;
    *(below[middle] <= share ? &low : &high) = middle;
  }
  *cell = low;
  const double part = (share - below[low]) / (below[low + 1] - below[low]);
  double x = ((double)low + part) / (double)n;
  /* Rounding must not lead into a neighbour, whose weight may be 0: one step, two at most. */
  while (x >= 1.0 || cell_of(x, n) > low) x = nextafter(x, 0.0);
  while (cell_of(x, n) < low) x = nextafter(x, 1.0);
  return x;
}

static double share_of(const double *below, size_t n, size_t cell, double x) {
  const double part = asc_limited(x * (double)n - (double)cell, 0.0, 1.0);
  return below[cell] + part * (below[cell + 1] - below[cell]);
}

asc_status asc_density_sample(const asc_density *density, const double *u, size_t n, double *points) {
  if (!density || (n > 0 && (!u || !points))) return ASC_INVALID_ARGUMENT;
  const uint32_t dimensions = density->dimensions;
  for (size_t i = 0; i < n; i++, u += dimensions, points += dimensions) {
    size_t row = 0, column;
    if (!asc_in_unit(u[0]) || !asc_in_unit(u[dimensions - 1])) return ASC_INVALID_ARGUMENT;
    if (dimensions == 2) points[1] = find(density->rows_below, density->rows, u[1], &row);
    points[0] = find(density->cells_below + row * (density->columns + 1), density->columns, u[0], &column);
  }
  return ASC_OK;
}

/* Whether a point lies in [0, 1) or [0, 1)^2, and in which cell. */
static int locate(const asc_density *density, const double *point, size_t *row, size_t *column) {
  const double x = point[0], y = density->dimensions == 2 ? point[1] : 0.0;
  if (!(x >= 0.0 && x < 1.0 && y >= 0.0 && y < 1.0)) return 0;
  *row = cell_of(y, density->rows);
  *column = cell_of(x, density->columns);
  return 1;
}

asc_status asc_density_inverse(const asc_density *density, const double *points, size_t n, double *u) {
  if (!density || (n > 0 && (!u || !points))) return ASC_INVALID_ARGUMENT;
  const uint32_t dimensions = density->dimensions;
  for (size_t i = 0; i < n; i++, u += dimensions, points += dimensions) {
    size_t row, column;
    if (!locate(density, points, &row, &column)) return ASC_INVALID_ARGUMENT;
    if (density->height[row * density->columns + column] == 0.0) return ASC_INVALID_ARGUMENT;
    if (dimensions == 2) u[1] = share_of(density->rows_below, density->rows, row, points[1]);
    u[0] = share_of(density->cells_below + row * (density->columns + 1), density->columns, column, points[0]);
  }
  return ASC_OK;
}

asc_status asc_density_pdf(const asc_density *density, const double *points, size_t n, double *pdf) {
  if (!density || (n > 0 && (!pdf || !points))) return ASC_INVALID_ARGUMENT;
  const uint32_t dimensions = density->dimensions;
  for (size_t i = 0; i < n; i++, points += dimensions) {
    size_t row, column;
    if (isnan(points[0]) || isnan(points[dimensions - 1])) return ASC_INVALID_ARGUMENT;
    pdf[i] = locate(density, points, &row, &column) ? density->height[row * density->columns + column] : 0.0;
  }
  return ASC_OK;
}

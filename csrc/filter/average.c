/* The plain average: each sample weighs what the filter has at its place, however crowded that is.
 *
 * Source: Cook 1986, "Stochastic sampling in computer graphics", for the weighted average of uneven samples. */
#include <math.h>
#include <stdlib.h>

#include "weighting.h"

asc_status asc_filter_at_samples(const asc_samples *samples, double *values) {
  const size_t count = samples->count;
  if (!samples->filter) {
    for (size_t i = 0; i < count; i++) values[i] = 1.0;
    return ASC_OK;
  }
  double *columns = calloc(2 * count, sizeof *columns);
  if (!columns) return ASC_OUT_OF_MEMORY;
  const double last = nextafter(samples->radius, 0.0); /* a profile is zero at its radius: half open, as pixels are */
  for (size_t i = 0; i < count; i++) {
    columns[i] = fmin(samples->points[2 * i], last);
    columns[count + i] = fmin(samples->points[2 * i + 1], last);
  }
  asc_status status = asc_filter_evaluate(samples->filter, columns, 2 * count, columns);
  for (size_t i = 0; i < count; i++) values[i] = columns[i] * columns[count + i];
  free(columns);
  return status;
}

static asc_status average_weigh(const asc_samples *samples, const double *values, double *weights) {
  (void)values;
  return asc_filter_at_samples(samples, weights);
}

const asc_weighting_interface asc_weighting_average = {
    .name = "average",
    .title = "the filter's value at the sample: the plain average, which takes the samples for even",
    .source = "Cook 1986",
    .radius = 0.5,
    .weigh = average_weigh,
};

/* The filters at any place, their integrals and responses; and the weights of uneven samples with them. */
#include "aliascope/filter.h"
#include "aliascope/uneven.h"
#include "bytes.h"

enum { MOST_POINTS = 24 };

/* Two integrals of the header's 1e-14 each, one of them times at most a few. */
#define INTEGRAL_TOLERANCE 1e-12

/* Sums of at most 24 weights, each up to some tens where negative lobes nearly cancel the others. */
#define SUM_TOLERANCE 1e-9

static void check_profile(const asc_filter *filter, const char *spec, bytes *from) {
  const double radius = asc_filter_radius(filter);
  require(radius >= ASC_FILTER_RADIUS_LEAST && radius <= ASC_FILTER_RADIUS_MOST, "%s: radius %g", spec, radius);
  double x[4], values[4], responses[4];
  for (int i = 0; i < 4; i++) x[i] = take_double(from);
  require(asc_filter_evaluate(filter, x, 4, values) == ASC_OK, "%s: not evaluated", spec);
  for (int i = 0; i < 4; i++) {
    require(isfinite(values[i]), "%s at %g: %g", spec, x[i], values[i]);
    if (!(x[i] >= -radius && x[i] < radius)) require(values[i] == 0.0, "%s at %g: %g", spec, x[i], values[i]);
  }
  double all, there, back;
  require(asc_filter_integral(filter, -INFINITY, INFINITY, &all) == ASC_OK, "%s: no integral", spec);
  require(fabs(all - 1.0) <= INTEGRAL_TOLERANCE, "%s: its integral is %.17g", spec, all);
  const asc_status status = asc_filter_integral(filter, x[0], x[1], &there);
  require(status == (isnan(x[0]) || isnan(x[1]) ? ASC_INVALID_ARGUMENT : ASC_OK), "%s: integral", spec);
  if (status == ASC_OK) {
    require(asc_filter_integral(filter, x[1], x[0], &back) == ASC_OK, "%s: no integral back", spec);
    require(isfinite(there) && fabs(there + back) <= INTEGRAL_TOLERANCE, "%s from %g to %g: %.17g and %.17g", spec,
            x[0], x[1], there, back);
  }
  for (int i = 0; i < 4; i++) {
    const asc_status answered = asc_filter_response(filter, x + i, 1, responses + i);
    const int within = fabs(x[i]) <= ASC_FILTER_FREQUENCY_MOST;
    require(answered == (within ? ASC_OK : ASC_INVALID_ARGUMENT), "%s: response at %g: %d", spec, x[i], (int)answered);
    if (within) require(isfinite(responses[i]), "%s: response at %g", spec, x[i]);
  }
}

static double *rotated(const double *points, size_t count, size_t by) {
  double *made = malloc(2 * count * sizeof *made);
  require(made != NULL, "no memory");
  for (size_t i = 0; i < count; i++) memcpy(made + (i + by) % count * 2, points + 2 * i, 2 * sizeof *made);
  return made;
}

/* Sum 1, and in another order the same to the bit. */
static void check_weights(const asc_uneven_desc *desc, const char *filter) {
  double weights[MOST_POINTS], others[MOST_POINTS];
  asc_error error = {{0}};
  const asc_status status = asc_uneven_weights(desc, weights, &error);
  if (status) {
    require(error.text[0] != '\0', "%s: refused without a reason", desc->spec);
    return;
  }
  double sum = 0.0, size = 0.0;
  for (size_t i = 0; i < desc->count; i++) {
    require(isfinite(weights[i]), "%s of %s: weight %zu is %g", desc->spec, filter, i, weights[i]);
    sum += weights[i];
    size += fabs(weights[i]);
  }
  require(fabs(sum - 1.0) <= SUM_TOLERANCE * fmax(size, 1.0), "%s of %s: the sum is %.17g", desc->spec, filter, sum);
  asc_uneven_desc other = *desc;
  const size_t by = desc->count / 2;
  double *points = rotated(desc->points, desc->count, by);
  other.points = points;
  require(asc_uneven_weights(&other, others, &error) == ASC_OK, "%s: not in another order: %s", desc->spec, error.text);
  for (size_t i = 0; i < desc->count; i++)
    require(others[(i + by) % desc->count] == weights[i], "%s of %s: weight %zu is %.17g, in another order %.17g",
            desc->spec, filter, i, weights[i], others[(i + by) % desc->count]);
  free(points);
}

static void check_uneven(const asc_filter *filter, const char *spec, bytes *from) {
  asc_weighting_info info;
  require(asc_weighting_describe(take_below(from, (uint32_t)asc_weighting_count()), &info) == ASC_OK, "no weighting");
  char method[512];
  (void)snprintf(method, sizeof method, "%s", info.name);
  take_keys(from, info.parameters, info.parameter_count, 64.0, method, sizeof method);
  const size_t count = 1 + take_below(from, MOST_POINTS);
  const int box = take_below(from, 2) == 1;
  const double radius = box ? 0.5 : asc_filter_radius(filter);
  double *points = malloc(2 * count * sizeof *points);
  require(points != NULL, "no memory");
  for (size_t i = 0; i < 2 * count; i++) {
    const uint32_t kind = take_below(from, 8);
    points[i] = i > 1 && kind == 0 ? points[i - 2] : (2.0 * take_coordinate(from) - 1.0) * radius;
  }
  const asc_uneven_desc desc = {sizeof desc, method, box ? NULL : filter, points, count};
  check_weights(&desc, box ? "the box" : spec);
  free(points);
}

/* Cells fill the bounds: to within what places are read to, which may be all of a side that is much the shorter. */
static void check_cells(bytes *from) {
  const size_t count = 1 + take_below(from, MOST_POINTS);
  const int unit = take_below(from, 2) == 1;
  double bounds[4] = {0.0, 0.0, 1.0, 1.0}, areas[MOST_POINTS];
  for (int i = 0; i < 4 && !unit; i++) bounds[i] = take_double(from);
  double *points = malloc(2 * count * sizeof *points);
  require(points != NULL, "no memory");
  for (size_t i = 0; i < 2 * count; i++) {
    const double share = take_coordinate(from), low = bounds[i % 2], high = bounds[2 + i % 2];
    points[i] = low + share * (high - low);
  }
  asc_error error = {{0}};
  const asc_status status = asc_voronoi_areas(points, count, bounds, areas, &error);
  if (status) require(error.text[0] != '\0', "cells: refused without a reason");
  double sum = 0.0;
  for (size_t i = 0; i < count && status == ASC_OK; i++) {
    require(areas[i] >= 0.0 && isfinite(areas[i]), "cell %zu has the area %g", i, areas[i]);
    sum += areas[i];
  }
  const double whole = (bounds[2] - bounds[0]) * (bounds[3] - bounds[1]);
  if (status == ASC_OK && unit) require(fabs(sum - whole) <= SUM_TOLERANCE * whole, "cells: %.17g", sum);
  free(points);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes from = {data, size};
  asc_filter_info info;
  require(asc_filter_describe(take_below(&from, (uint32_t)asc_filter_count()), &info) == ASC_OK, "no such filter");
  char spec[512];
  (void)snprintf(spec, sizeof spec, "%s", info.name);
  take_keys(&from, info.parameters, info.parameter_count, 64.0, spec, sizeof spec);
  const asc_filter_desc desc = {sizeof desc, spec};
  asc_filter *filter = NULL;
  asc_error error = {{0}};
  const asc_status status = asc_filter_create(&desc, &filter, &error);
  require(status == ASC_OK || (status == ASC_INVALID_VALUE && error.text[0]), "%s: %d: %s", spec, (int)status,
          error.text);
  if (status) return 0;
  const uint32_t what = take_below(&from, 3);
  if (what == 0) check_profile(filter, spec, &from);
  if (what == 1) check_uneven(filter, spec, &from);
  if (what == 2) check_cells(&from);
  asc_filter_destroy(filter);
  return 0;
}

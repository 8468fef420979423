/* The discrepancies: every measure, with keys, of few points that are any doubles. What is a number is finite, within
 * its bounds, the same again, and another order of the points gives it but for rounding. */
#include "aliascope/discrepancy.h"
#include "bytes.h"

enum { MOST_POINTS = 40, MOST_DIMENSIONS = 6, MOST_VALUES = MOST_POINTS * MOST_DIMENSIONS };

/* Sums in another order: of N^2 terms not above 2^d, each rounded. Squares that are the difference of such sums lose
 * half of the digits. */
#define ROUNDING 1e-7

static asc_status measured(const char *spec, const double *points, size_t count, uint32_t dimensions, uint64_t seed,
                           asc_measurement *made, asc_error *error) {
  const asc_discrepancy_desc desc = {sizeof desc, spec, points, count, dimensions, seed};
  *made = (asc_measurement){.struct_size = sizeof *made};
  return asc_discrepancy(&desc, made, error);
}

static void check_measurement(const asc_measurement *made, const char *spec) {
  require(made->struct_size == sizeof *made, "%s: struct_size", spec);
  require(isfinite(made->value) && made->value >= 0.0, "%s: %g", spec, made->value);
  require(isfinite(made->standard_error) && made->standard_error >= 0.0, "%s: +- %g", spec, made->standard_error);
  require(made->lower <= made->value && made->value <= made->upper, "%s: %g in [%g, %g]", spec, made->value,
          made->lower, made->upper);
  if (made->certainty == ASC_EXACT)
    require(made->lower == made->upper && made->standard_error == 0.0, "%s: not exact", spec);
  if (made->certainty == ASC_BOUNDS)
    require(made->value == made->lower || made->value == made->upper, "%s: no bound", spec);
  require(made->witness_count <= ASC_WITNESS_MOST && made->closed <= 1, "%s: witness", spec);
  for (uint32_t k = 0; k < made->witness_count; k++)
    require(isfinite(made->witness[k]), "%s: witness %u is %g", spec, k, made->witness[k]);
}

/* Random draws and steps meet other points in another order. */
static int depends_on_order(const asc_measurement *made, const char *spec) {
  return made->certainty == ASC_ESTIMATED || strncmp(spec, "edge-", 5) == 0 || strncmp(spec, "star-bounds", 11) == 0;
}

/* The points of each copy have a length of their own, so that a sanitizer sees what is read past them. */
static double *reversed(const double *points, size_t count, uint32_t dimensions, uint32_t rotate) {
  double *other = malloc(count * dimensions * sizeof *other);
  require(other != NULL, "no memory");
  for (size_t i = 0; i < count; i++)
    memcpy(other + (count - 1 - (i + rotate) % count) * dimensions, points + i * dimensions,
           dimensions * sizeof *other);
  return other;
}

/* A few of the points are each other's copies, or mirrored in an axis: ties are where comparisons differ. */
static void take_points(bytes *from, size_t count, uint32_t dimensions, double *points) {
  for (size_t i = 0; i < count; i++) {
    const uint32_t kind = take_below(from, 8);
    for (uint32_t d = 0; d < dimensions; d++) {
      double *value = &points[i * dimensions + d];
      if (i > 0 && kind == 0)
        *value = points[(i - 1) * dimensions + d];
      else if (i > 0 && kind == 1)
        *value = d ? points[(i - 1) * dimensions + d] : take_coordinate(from);
      else if (i > 0 && kind == 2)
        *value = 1.0 - points[(i - 1) * dimensions + d];
      else
        *value = take_coordinate(from);
    }
  }
}

static int are_points(const double *points, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!(points[i] >= 0.0 && points[i] <= 1.0)) return 0;
  return 1;
}

static void check(const char *spec, const double *points, size_t count, uint32_t dimensions, uint64_t seed,
                  uint32_t rotate) {
  asc_measurement made, again;
  asc_error error = {{0}};
  const asc_status status = measured(spec, points, count, dimensions, seed, &made, &error);
  if (status) {
    require(error.text[0] != '\0', "%s: refused without a reason", spec);
    require(status == ASC_UNSUPPORTED || status == ASC_NUMERIC || status == ASC_INVALID_VALUE ||
                !are_points(points, count * dimensions),
            "%s of %zu points in %u dimensions: %s", spec, count, dimensions, error.text);
    require(measured(spec, points, count, dimensions, seed, &made, NULL) == status, "%s: another status", spec);
    return;
  }
  require(are_points(points, count * dimensions), "%s: measured what are no points", spec);
  check_measurement(&made, spec);
  require(measured(spec, points, count, dimensions, seed, &again, NULL) == ASC_OK, "%s: not again", spec);
  require(memcmp(&made, &again, offsetof(asc_measurement, closed)) == 0, "%s: not the same again", spec);
  double *other = reversed(points, count, dimensions, rotate);
  require(measured(spec, other, count, dimensions, seed, &again, &error) == ASC_OK, "%s: not of another order: %s",
          spec, error.text);
  check_measurement(&again, spec);
  if (!depends_on_order(&made, spec))
    require(fabs(again.value - made.value) <= ROUNDING, "%s: %.17g, in another order %.17g", spec, made.value,
            again.value);
  free(other);
}

/* Of keys whose usual value takes too long for a fuzzer. */
static void take_default(char spec[512], const char *measure, const char *pair) {
  if (strncmp(spec, measure, strlen(measure)) != 0) return;
  char key[16];
  (void)snprintf(key, sizeof key, "%.*s", (int)strcspn(pair, "=") + 1, pair);
  if (strstr(spec, key)) return;
  const size_t length = strlen(spec);
  (void)snprintf(spec + length, 512 - length, "%s%s", strchr(spec, ':') ? "," : ":", pair);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes from = {data, size};
  asc_measure_info info;
  require(asc_measure_describe(take_below(&from, (uint32_t)asc_measure_count()), &info) == ASC_OK, "no such measure");
  char spec[512];
  (void)snprintf(spec, sizeof spec, "%s", info.name);
  take_keys(&from, info.parameters, info.parameter_count, 64.0, spec, sizeof spec);
  take_default(spec, "edge-m", "draws=50");
  if (strstr(spec, "edges=")) take_default(spec, "edge-rms", "draws=50");
  if (strstr(spec, "edges=") && strstr(spec, "draws=0")) return 0; /* half a million */
  take_default(spec, "star-bounds", "work=0.1");
  const uint32_t least = info.least_dimensions, most = info.most_dimensions < 6 ? info.most_dimensions : 6;
  /* Beside those that the measure does, one that it may not. */
  uint32_t dimensions = least + take_below(&from, most - least + 2);
  if (dimensions > MOST_DIMENSIONS) dimensions = MOST_DIMENSIONS;
  /* The grid of the exact star discrepancy has N^d corners. */
  const size_t count = 1 + take_below(&from, dimensions > 3 ? 12 : MOST_POINTS);
  const uint64_t seed = take(&from, 2);
  const uint32_t rotate = take_below(&from, 16);
  double *points = malloc(count * dimensions * sizeof *points);
  require(points != NULL, "no memory");
  take_points(&from, count, dimensions, points);
  check(spec, points, count, dimensions, seed, rotate);
  free(points);
  return 0;
}

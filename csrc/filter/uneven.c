/* The weightings there are, what is checked for all of them, and their sum of 1. */
#include "aliascope/uneven.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "spec.h"
#include "weighting.h"

#define WEIGHTINGS(X) X(average) X(area) X(multi_stage) X(inverse_density)

#define DECLARE(name) extern const asc_weighting_interface asc_weighting_##name;
WEIGHTINGS(DECLARE)

#define ADDRESS(name) &asc_weighting_##name,
static const asc_weighting_interface *const weightings[] = {WEIGHTINGS(ADDRESS)};
#define COUNT (sizeof weightings / sizeof *weightings)

#define MOST_PARAMETERS 8

size_t asc_weighting_count(void) { return COUNT; }

asc_status asc_weighting_describe(size_t index, asc_weighting_info *info) {
  if (!info || index >= COUNT) return ASC_INVALID_ARGUMENT;
  const asc_weighting_interface *one = weightings[index];
  *info = (asc_weighting_info){one->name, one->title, one->source, one->parameters, one->parameter_count, one->filter};
  return ASC_OK;
}

/* Finds the weighting of a spec and reads its keys into `values`. */
static asc_status resolve(const char *spec, const asc_weighting_interface **found, double values[MOST_PARAMETERS],
                          asc_error *error) {
  char name[ASC_SPEC_LENGTH];
  asc_status status = asc_spec_name(spec, "weighting", name, error);
  if (status) return status;
  const char *names[COUNT];
  for (size_t i = 0; i < COUNT; i++) {
    names[i] = weightings[i]->name;
    if (strcmp(names[i], name) != 0) continue;
    *found = weightings[i];
    const asc_spec_form form = {"weighting", names[i], weightings[i]->parameters, weightings[i]->parameter_count};
    return asc_spec_values(spec, &form, values, error);
  }
  return asc_spec_unknown("weighting", name, names, COUNT, error);
}

asc_status asc_weighting_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error) {
  if (!spec || !canonical) return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_weighting_canonical: no spec");
  const asc_weighting_interface *found = NULL;
  double values[MOST_PARAMETERS];
  char text[ASC_SPEC_LENGTH];
  asc_status status = resolve(spec, &found, values, error);
  if (status) return status;
  const asc_spec_form form = {"weighting", found->name, found->parameters, found->parameter_count};
  status = asc_spec_canonical(&form, values, text);
  if (status) return asc_fail(error, status, "out of memory");
  if (strlen(text) >= capacity) return asc_fail(error, ASC_INVALID_ARGUMENT, "the canonical spec does not fit");
  memcpy(canonical, text, strlen(text) + 1);
  return ASC_OK;
}

/* Whether the weighting takes the filter; one that is a filter of its own takes no other. */
static asc_status check_filter(const asc_weighting_interface *method, const asc_filter *filter, asc_error *error) {
  asc_filter_desc of;
  if (!method->filter || !filter) return ASC_OK;
  asc_status status = asc_filter_resolved(filter, &of);
  if (status) return status;
  const size_t length = strlen(method->filter);
  if (strncmp(of.spec, method->filter, length) == 0 && (of.spec[length] == '\0' || of.spec[length] == ':'))
    return ASC_OK;
  return asc_fail(error, ASC_UNSUPPORTED, "the weighting %s is a filter of its own: it takes %s, not %s", method->name,
                  method->filter, of.spec);
}

static asc_status check_samples(const asc_samples *samples, asc_error *error) {
  if (!samples->points || samples->count == 0)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "there are no samples to be weighted");
  if (samples->count > ASC_UNEVEN_MOST)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "%zu samples: at most %d are weighted at a time", samples->count,
                    ASC_UNEVEN_MOST);
  for (size_t i = 0; i < samples->count; i++) {
    const double x = samples->points[2 * i], y = samples->points[2 * i + 1];
    if (!(isfinite(x) && isfinite(y)))
      return asc_fail(error, ASC_INVALID_ARGUMENT, "sample %zu at (%g, %g) is nowhere", i, x, y);
    if (!(fabs(x) <= samples->radius && fabs(y) <= samples->radius))
      return asc_fail(error, ASC_INVALID_ARGUMENT,
                      "sample %zu at (%g, %g) is outside the filter, which reaches %g pixels from the centre", i, x, y,
                      samples->radius);
  }
  return ASC_OK;
}

static int by_size(const void *a, const void *b) {
  const double left = *(const double *)a, right = *(const double *)b;
  return (left > right) - (left < right);
}

/* The sum, with what each addition loses (Knuth's two-sum): about 106 digits. `sure`: whether it is rounded the same in
 * any order of the weights. */
static double compensated_sum(const double *weights, size_t count, int *sure) {
  double sum = 0.0, lost = 0.0, size = 0.0;
  for (size_t i = 0; i < count; i++) {
    const double before = sum, added = weights[i];
    sum += added;
    const double from_added = sum - before;
    lost += (before - (sum - from_added)) + (added - from_added);
    size += fabs(added);
  }
  /* Four times what the roundings of `lost` come to: so much that sums in two orders, one of them sure, are equal. */
  const double slack = 2.0 * DBL_EPSILON * DBL_EPSILON * (double)count * (double)count * size;
  *sure = sum + (lost - slack) == sum + (lost + slack);
  return sum + lost;
}

/* As they are added up in one order, whatever theirs is. */
static asc_status sum_of(const double *weights, size_t count, double *sum) {
  int sure;
  *sum = compensated_sum(weights, count, &sure);
  if (sure) return ASC_OK;
  double *sorted = malloc(count * sizeof *sorted);
  if (!sorted) return ASC_OUT_OF_MEMORY;
  memcpy(sorted, weights, count * sizeof *sorted);
  qsort(sorted, count, sizeof *sorted, by_size);
  *sum = compensated_sum(sorted, count, &sure);
  free(sorted);
  return ASC_OK;
}

/* Divides by the sum, so that the weights add up to 1 within their own rounding. */
static asc_status normalise(const asc_samples *samples, double *weights, asc_error *error) {
  double sum;
  asc_status status = sum_of(weights, samples->count, &sum);
  if (status) return asc_fail(error, status, "%s", asc_status_text(status));
  if (!(sum > 0.0 && isfinite(1.0 / sum)))
    return asc_fail(error, ASC_NUMERIC, "the filter at these samples adds up to %g: they have no average under it",
                    sum);
  for (size_t i = 0; i < samples->count; i++) weights[i] /= sum;
  return ASC_OK;
}

asc_status asc_uneven_weights(const asc_uneven_desc *desc, double *weights, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->spec || !weights)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_uneven_weights: desc needs its struct_size and a spec");
  const asc_weighting_interface *method = NULL;
  double values[MOST_PARAMETERS];
  asc_status status = resolve(desc->spec, &method, values, error);
  if (status == ASC_OK) status = check_filter(method, desc->filter, error);
  if (status) return status;
  const double radius = desc->filter ? asc_filter_radius(desc->filter) : method->radius;
  const asc_samples samples = {desc->filter, radius, desc->points, desc->count};
  status = check_samples(&samples, error);
  if (status) return status;
  status = method->weigh(&samples, values, weights);
  if (status) return asc_fail(error, status, "%s", asc_status_text(status));
  return normalise(&samples, weights, error);
}

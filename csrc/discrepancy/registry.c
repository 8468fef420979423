/* The measures there are, and what is checked for all of them. */
#include <math.h>
#include <string.h>

#include "measure.h"
#include "spec.h"

/* clang-format off */
#define MEASURES(X) \
  X(l2_star) \
  X(l2_extreme) \
  X(l2_centered) \
  X(l2_wrap) \
  X(l2_mixture) \
  X(l2_periodic) \
  X(edge_rms) \
  X(edge_mean) \
  X(edge_max) \
  X(star) \
  X(box) \
  X(half_plane) \
  X(star_bounds) \
  X(dispersion) \
  X(min_distance) \
  X(t_value) \
  /* end of the list */
/* clang-format on */

#define DECLARE(name) extern const asc_measure_interface asc_measure_##name;
MEASURES(DECLARE)

#define ADDRESS(name) &asc_measure_##name,
static const asc_measure_interface *const measures[] = {MEASURES(ADDRESS)};
#define COUNT (sizeof measures / sizeof *measures)

#define MOST_PARAMETERS 8

size_t asc_measure_count(void) { return COUNT; }

asc_status asc_measure_describe(size_t index, asc_measure_info *info) {
  if (!info || index >= COUNT) return ASC_INVALID_ARGUMENT;
  const asc_measure_interface *measure = measures[index];
  *info = (asc_measure_info){.name = measure->name,
                             .title = measure->title,
                             .source = measure->source,
                             .parameters = measure->parameters,
                             .parameter_count = measure->parameter_count,
                             .least_dimensions = measure->least_dimensions,
                             .most_dimensions = measure->most_dimensions,
                             .quick_points = measure->quick_points};
  return ASC_OK;
}

/* Finds the measure of a spec and reads its keys into `values`. */
static asc_status resolve(const char *spec, const asc_measure_interface **found, double values[MOST_PARAMETERS],
                          asc_error *error) {
  char name[ASC_SPEC_LENGTH];
  asc_status status = asc_spec_name(spec, "measure", name, error);
  if (status) return status;
  const char *names[COUNT];
  for (size_t i = 0; i < COUNT; i++) {
    names[i] = measures[i]->name;
    if (strcmp(names[i], name) != 0) continue;
    *found = measures[i];
    const asc_spec_form form = {"measure", names[i], measures[i]->parameters, measures[i]->parameter_count};
    return asc_spec_values(spec, &form, values, error);
  }
  return asc_spec_unknown("measure", name, names, COUNT, error);
}

asc_status asc_measure_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error) {
  if (!spec || !canonical) return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_measure_canonical: no spec");
  const asc_measure_interface *measure = NULL;
  double values[MOST_PARAMETERS];
  char text[ASC_SPEC_LENGTH];
  asc_status status = resolve(spec, &measure, values, error);
  if (status) return status;
  const asc_spec_form form = {"measure", measure->name, measure->parameters, measure->parameter_count};
  status = asc_spec_canonical(&form, values, text);
  if (status) return asc_fail(error, status, "out of memory");
  if (strlen(text) >= capacity) return asc_fail(error, ASC_INVALID_ARGUMENT, "the canonical spec does not fit");
  memcpy(canonical, text, strlen(text) + 1);
  return ASC_OK;
}

static asc_status check(const asc_discrepancy_desc *desc, const asc_measure_interface *measure, asc_error *error) {
  if (!desc->points || desc->count == 0 || desc->dimensions == 0)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "%s: there are no points", measure->name);
  if (desc->dimensions < measure->least_dimensions || desc->dimensions > measure->most_dimensions) {
    if (measure->least_dimensions == measure->most_dimensions)
      return asc_fail(error, ASC_UNSUPPORTED, "%s is of points in %u dimensions; these have %u", measure->name,
                      measure->least_dimensions, desc->dimensions);
    return asc_fail(error, ASC_UNSUPPORTED, "%s is of points in %u to %u dimensions; these have %u", measure->name,
                    measure->least_dimensions, measure->most_dimensions, desc->dimensions);
  }
  for (size_t i = 0; i < desc->count; i++)
    for (uint32_t d = 0; d < desc->dimensions; d++) {
      const double value = desc->points[i * desc->dimensions + d];
      if (!(value >= 0.0 && value <= 1.0))
        return asc_fail(error, ASC_INVALID_ARGUMENT, "point %zu has %g, which is not in [0, 1]", i, value);
    }
  return ASC_OK;
}

asc_status asc_discrepancy(const asc_discrepancy_desc *desc, asc_measurement *made, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->spec || !made || made->struct_size != sizeof *made)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_discrepancy: desc and result need their struct_size");
  const asc_measure_interface *measure = NULL;
  double values[MOST_PARAMETERS];
  asc_status status = resolve(desc->spec, &measure, values, error);
  if (status == ASC_OK) status = check(desc, measure, error);
  if (status) return status;
  *made = (asc_measurement){.struct_size = sizeof *made};
  const asc_point_set set = {desc->points, desc->count, desc->dimensions, desc->seed};
  status = measure->evaluate(&set, values, made, error);
  if (status) return status;
  return isfinite(made->value) ? ASC_OK : asc_fail(error, ASC_NUMERIC, "%s is not a finite number", measure->name);
}

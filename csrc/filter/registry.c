/* The filters there are, and what holds for all of them: even, normalised, zero past the radius. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "primitive.h"
#include "profile.h"
#include "quadrature.h"
#include "spec.h"
#include "vectorise.h"

/* One line a filter. */
#define BUILT_IN_FILTERS(X)                                                                                            \
  X(box) X(tent) X(gaussian) X(mitchell) X(catmull_rom) X(lanczos) X(blackman_harris) X(multi_stage)

#define DECLARE(name) extern const asc_filter_interface asc_filter_##name;
BUILT_IN_FILTERS(DECLARE)

#define ADDRESS(name) &asc_filter_##name,
static const asc_filter_interface *const built_in[] = {BUILT_IN_FILTERS(ADDRESS)};
#define COUNT (sizeof built_in / sizeof *built_in)

#define MOST_PARAMETERS 8

struct asc_filter {
  const asc_filter_interface *interface;
  double values[MOST_PARAMETERS];
  double radius;
  double scale; /* what makes the interface's profile one of integral 1 */
  asc_primitive_table table;
  char spec[ASC_SPEC_LENGTH];
};

uint32_t asc_one_piece(const double *values) {
  (void)values;
  return 1;
}

double asc_first_value(const double *values) { return values[0]; }

size_t asc_filter_count(void) { return COUNT; }

asc_status asc_filter_describe(size_t index, asc_filter_info *info) {
  if (!info || index >= COUNT) return ASC_INVALID_ARGUMENT;
  const asc_filter_interface *interface = built_in[index];
  *info = (asc_filter_info){interface->name, interface->title, interface->source, interface->parameters,
                            interface->parameter_count};
  return ASC_OK;
}

static const asc_filter_interface *find(const char *name) {
  for (size_t i = 0; i < COUNT; i++)
    if (strcmp(built_in[i]->name, name) == 0) return built_in[i];
  return NULL;
}

/* The integral of the profile as it is, from 0 to x in [0, radius]. */
static double primitive(const asc_filter *filter, double x) {
  const asc_filter_interface *interface = filter->interface;
  if (interface->primitive) return interface->primitive(filter->values, x);
  return asc_profile_integral(interface, filter->values, x, 0.0);
}

static asc_status resolve(asc_filter *filter, const char *spec, asc_error *error) {
  char name[ASC_SPEC_LENGTH];
  asc_status status = asc_spec_name(spec, "filter", name, error);
  if (status) return status;
  filter->interface = find(name);
  if (!filter->interface) {
    const char *names[COUNT];
    for (size_t i = 0; i < COUNT; i++) names[i] = built_in[i]->name;
    return asc_spec_unknown("filter", name, names, COUNT, error);
  }
  const asc_spec_form form = {"filter", name, filter->interface->parameters, filter->interface->parameter_count};
  status = asc_spec_values(spec, &form, filter->values, error);
  if (status) return status;
  status = asc_spec_canonical(&form, filter->values, filter->spec);
  if (status) return asc_fail(error, status, "out of memory");
  filter->radius = filter->interface->radius(filter->values);
  filter->scale = 0.5 / primitive(filter, filter->radius);
  return ASC_OK;
}

asc_status asc_filter_create(const asc_filter_desc *desc, asc_filter **filter, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->spec || !filter)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_filter_create: desc needs its struct_size and a spec");
  *filter = NULL;
  asc_filter *made = calloc(1, sizeof *made);
  if (!made) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  asc_status status = resolve(made, desc->spec, error);
  if (status == ASC_OK && asc_primitive_table_create(made, &made->table))
    status = asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  if (status) {
    free(made);
    return status;
  }
  *filter = made;
  return ASC_OK;
}

void asc_filter_destroy(asc_filter *filter) {
  if (filter) asc_primitive_table_destroy(&filter->table);
  free(filter);
}

asc_status asc_filter_resolved(const asc_filter *filter, asc_filter_desc *desc) {
  if (!filter || !desc) return ASC_INVALID_ARGUMENT;
  *desc = (asc_filter_desc){sizeof *desc, filter->spec};
  return ASC_OK;
}

double asc_filter_knot_spacing(const asc_filter *filter) {
  return filter->radius / filter->interface->pieces(filter->values);
}

const asc_primitive_table *asc_filter_table(const asc_filter *filter) { return &filter->table; }

double asc_filter_radius(const asc_filter *filter) { return filter ? filter->radius : 0.0; }

ASC_VECTORISE
asc_status asc_filter_evaluate(const asc_filter *filter, const double *x, size_t n, double *values) {
  enum { CHUNK = 256 };
  if (!filter || (n && (!x || !values))) return ASC_INVALID_ARGUMENT;
  const double radius = filter->radius, scale = filter->scale;
  for (size_t done = 0; done < n; done += CHUNK) {
    const size_t count = n - done < CHUNK ? n - done : CHUNK;
    const double *at = x + done;
    double distance[CHUNK], profile[CHUNK];
    for (size_t i = 0; i < count; i++) distance[i] = fabs(at[i]) < radius ? fabs(at[i]) : radius;
    filter->interface->evaluate(filter->values, distance, count, profile);
    for (size_t i = 0; i < count; i++) {
      const double inside = (double)((at[i] >= -radius) & (at[i] < radius));
      values[done + i] = scale * profile[i] * inside;
    }
  }
  return ASC_OK;
}

/* The integral from 0 to x, x any number. */
static double half_integral(const asc_filter *filter, double x) {
  return copysign(filter->scale * primitive(filter, fmin(fabs(x), filter->radius)), x);
}

/* The integral from |x| outward. */
static double tail(const asc_filter *filter, double x) {
  return filter->scale * filter->interface->tail(filter->values, fmin(fabs(x), filter->radius));
}

asc_status asc_filter_integral(const asc_filter *filter, double a, double b, double *integral) {
  if (!filter || !integral || isnan(a) || isnan(b)) return ASC_INVALID_ARGUMENT;
  if (filter->interface->tail && signbit(a) == signbit(b)) {
    const double first = tail(filter, a), second = tail(filter, b);
    *integral = signbit(a) ? second - first : first - second;
    return ASC_OK;
  }
  *integral = half_integral(filter, b) - half_integral(filter, a);
  return ASC_OK;
}

asc_status asc_filter_response(const asc_filter *filter, const double *frequencies, size_t n, double *response) {
  if (!filter || (n && (!frequencies || !response))) return ASC_INVALID_ARGUMENT;
  for (size_t i = 0; i < n; i++)
    if (!(fabs(frequencies[i]) <= ASC_FILTER_FREQUENCY_MOST)) return ASC_INVALID_ARGUMENT;
  for (size_t i = 0; i < n; i++)
    response[i] = 2.0 * filter->scale *
                  asc_profile_integral(filter->interface, filter->values, filter->radius, fabs(frequencies[i]));
  return ASC_OK;
}

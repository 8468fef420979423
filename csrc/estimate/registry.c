/* The estimators there are, and what is checked for all of them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "estimator.h"

/* clang-format off */
#define ESTIMATORS(X) \
  X(fixed) \
  X(stratified) \
  X(student_t) \
  X(chi_squared) \
  X(mitchell) \
  X(kajiya) \
  X(whitted) \
  /* end of the list */
/* clang-format on */

#define DECLARE(name) extern const asc_estimator_interface asc_estimator_##name;
ESTIMATORS(DECLARE)

#define ADDRESS(name) &asc_estimator_##name,
static const asc_estimator_interface *const estimators[] = {ESTIMATORS(ADDRESS)};
#define COUNT (sizeof estimators / sizeof *estimators)

size_t asc_estimator_count(void) { return COUNT; }

asc_status asc_estimator_describe(size_t index, asc_estimator_info *info) {
  if (!info || index >= COUNT) return ASC_INVALID_ARGUMENT;
  const asc_estimator_interface *interface = estimators[index];
  *info = (asc_estimator_info){interface->name, interface->title, interface->source, interface->parameters,
                               interface->parameter_count};
  return ASC_OK;
}

/* Fills in interface, values and spec. */
static asc_status resolve(asc_estimator *made, const char *spec, asc_error *error) {
  char name[ASC_SPEC_LENGTH];
  asc_status status = asc_spec_name(spec, "estimator", name, error);
  if (status) return status;
  const char *names[COUNT];
  for (size_t i = 0; i < COUNT; i++) {
    names[i] = estimators[i]->name;
    if (strcmp(names[i], name) != 0) continue;
    made->interface = estimators[i];
    const asc_spec_form form = {"estimator", names[i], estimators[i]->parameters, estimators[i]->parameter_count};
    status = asc_spec_values(spec, &form, made->values, error);
    if (status) return status;
    status = asc_spec_canonical(&form, made->values, made->spec);
    return status ? asc_fail(error, status, "out of memory") : ASC_OK;
  }
  (void)asc_spec_unknown("estimator", name, names, COUNT, error);
  return ASC_UNKNOWN_NAME;
}

asc_status asc_estimator_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error) {
  if (!spec || !canonical) return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_estimator_canonical: no spec");
  asc_estimator found = {0};
  const asc_status status = resolve(&found, spec, error);
  if (status) return status;
  if (strlen(found.spec) >= capacity) return asc_fail(error, ASC_INVALID_ARGUMENT, "the canonical spec does not fit");
  memcpy(canonical, found.spec, strlen(found.spec) + 1);
  return ASC_OK;
}

/* Fills in what the estimator has of its sampler. */
static asc_status take_sampler(asc_estimator *made, const asc_sampler *sampler, asc_error *error) {
  const char *name = made->interface->name;
  asc_sampler_desc desc;
  asc_status status = asc_sampler_resolved(sampler, &desc);
  if (status) return asc_fail(error, status, "%s: the sampler has no description", name);
  const uint32_t traits = asc_sampler_traits(sampler);
  if (!made->interface->any_sampler && !(traits & ASC_TRAIT_SEQUENCE))
    return asc_fail(error, ASC_UNSUPPORTED,
                    "%s takes as many samples as it needs, and %s is no sequence: its points depend on how many there "
                    "are",
                    name, desc.spec);
  if (!made->interface->any_sampler && traits & ASC_TRAIT_WEIGHTED)
    return asc_fail(error, ASC_UNSUPPORTED, "%s cannot use the weights of %s", name, desc.spec);
  if (desc.dimensions < made->interface->least_dimensions)
    return asc_fail(error, ASC_UNSUPPORTED, "%s needs %u dimensions; %s has %u", name,
                    made->interface->least_dimensions, desc.spec, desc.dimensions);
  made->sampler = sampler;
  made->samples = desc.samples;
  made->dimensions = desc.dimensions;
  return ASC_OK;
}

asc_status asc_estimator_create(const asc_estimator_desc *desc, asc_estimator **made, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->spec || !desc->sampler || !made)
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "asc_estimator_create: desc needs its struct_size, a spec and a sampler");
  *made = NULL;
  if (desc->channels < 1 || desc->channels > ASC_CHANNELS_MOST)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "an integrand has 1 to %d channels, not %u", ASC_CHANNELS_MOST,
                    desc->channels);
  asc_estimator *estimator = calloc(1, sizeof *estimator);
  if (!estimator) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  estimator->channels = desc->channels;
  asc_status status = resolve(estimator, desc->spec, error);
  if (status == ASC_OK) status = take_sampler(estimator, desc->sampler, error);
  if (status == ASC_OK && estimator->interface->prepare) status = estimator->interface->prepare(estimator, error);
  if (status) {
    asc_estimator_destroy(estimator);
    return status;
  }
  *made = estimator;
  return ASC_OK;
}

void asc_estimator_destroy(asc_estimator *made) {
  if (!made) return;
  asc_criterion_free(&made->criterion);
  asc_sampler_destroy(made->fresh);
  free(made);
}

asc_status asc_estimator_resolved(const asc_estimator *of, asc_estimator_desc *desc) {
  if (!of || !desc) return ASC_INVALID_ARGUMENT;
  *desc = (asc_estimator_desc){sizeof *desc, of->spec, of->sampler, of->channels};
  return ASC_OK;
}

uint32_t asc_estimator_reach(const asc_estimator *of) {
  return of && of->interface->reach ? of->interface->reach(of->values) : 0;
}

asc_status asc_estimate(const asc_estimator *with, const asc_group *group, asc_integrand integrand, void *context,
                        asc_estimates *made, asc_error *error) {
  if (!with || !group || !integrand || !made || made->struct_size != sizeof *made || !made->means)
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "asc_estimate: needs an estimator, a group, an integrand and estimates with their struct_size and "
                    "means");
  if (group->columns == 0 || group->rows == 0)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_estimate: there are no pixels");
  /* The pixels up to `reach` outside have 32 bits too. */
  const int64_t reach = asc_estimator_reach(with);
  if (group->x - reach < INT32_MIN || group->y - reach < INT32_MIN ||
      (int64_t)group->x + group->columns + reach > INT32_MAX || (int64_t)group->y + group->rows + reach > INT32_MAX)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_estimate: the coordinates of pixels have 32 bits");
  const size_t pixels = (size_t)group->columns * group->rows;
  for (size_t i = 0; made->standard_errors && i < pixels * with->channels; i++) made->standard_errors[i] = NAN;
  for (size_t i = 0; made->degrees && i < pixels; i++) made->degrees[i] = NAN;
  made->spent = 0;
  return with->interface->run(with, group, integrand, context, made, error);
}

/* What the files of estimators share. Each estimator is one asc_estimator_interface; registry.c lists them. */
#ifndef ASC_ESTIMATOR_H
#define ASC_ESTIMATOR_H

#include "aliascope/estimate.h"

#define ASC_ESTIMATOR_PARAMETERS 12

typedef struct asc_estimator_interface {
  const char *name;   /* kebab-case */
  const char *title;  /* in a few words */
  const char *source; /* the publication */
  const asc_parameter *parameters;
  size_t parameter_count;
  uint32_t least_dimensions; /* of the sampler: 2 for those that divide the pixel */
  /* NULL: 0. In pixels. */
  uint32_t (*reach)(const double *values);
  /* NULL: nothing to check. Whether the values go together and with the sampler's N: `samples`. */
  asc_status (*check)(const double *values, uint64_t samples, asc_error *error);
  asc_status (*run)(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                    asc_estimates *made, asc_error *error);
} asc_estimator_interface;

struct asc_estimator {
  const asc_estimator_interface *interface;
  const asc_sampler *sampler;
  uint64_t samples; /* the most of a pixel */
  uint32_t dimensions, channels;
  double values[ASC_ESTIMATOR_PARAMETERS]; /* one a parameter */
  char *spec;                              /* canonical */
};

#endif

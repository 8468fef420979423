/* What the files of estimators share. Each estimator is one asc_estimator_interface; registry.c lists them. */
#ifndef ASC_ESTIMATOR_H
#define ASC_ESTIMATOR_H

#include "criterion.h"
#include "spec.h"

#define ASC_ESTIMATOR_PARAMETERS 12

typedef struct asc_estimator_interface {
  const char *name;   /* kebab-case */
  const char *title;  /* in a few words */
  const char *source; /* the publication */
  const asc_parameter *parameters;
  size_t parameter_count;
  uint32_t least_dimensions; /* of the sampler: 2 for those that divide the pixel */
  int any_sampler; /* 1: one that is no sequence, or is weighted, will do, as the estimator takes all its N points */
  /* NULL: 0. In pixels. */
  uint32_t (*reach)(const double *values);
  /* NULL: nothing to do. Checks whether the values go together and with `samples`; makes the criterion, if it has one.
   */
  asc_status (*prepare)(asc_estimator *self, asc_error *error);
  /* Writes `means`, `counts`, `spent`, and what it knows of the rest, which is NaN before. */
  asc_status (*run)(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                    asc_estimates *made, asc_error *error);
} asc_estimator_interface;

struct asc_estimator {
  const asc_estimator_interface *interface;
  const asc_sampler *sampler;
  uint64_t samples; /* the most of a pixel */
  uint32_t dimensions, channels;
  double values[ASC_ESTIMATOR_PARAMETERS]; /* one a parameter */
  asc_criterion criterion;                 /* of `prepare`; freed with the estimator */
  asc_sampler *fresh;                      /* of asc_prepare_fresh, or NULL; freed with the estimator */
  char spec[ASC_SPEC_LENGTH];              /* canonical */
};

/* ---- Asking the integrand ---- */

/* Samples [first, first + count) of a pixel's sequence, the first two dimensions moved to a part of the pixel. */
typedef struct asc_draw {
  asc_pixel pixel;
  uint64_t first, count;
  /* The part; a width of 0: the whole pixel. x and y may be negative: what lies over the pixel's left or upper border
   * is a sample of the pixel there. */
  double x, y, width, height;
  const asc_sampler *sampler; /* NULL: the estimator's */
  asc_tally *to;              /* [channels], where the values are added, in the order of the samples; may be NULL */
  double *values;             /* [count][channels], where they are kept; may be NULL */
} asc_draw;

/* Takes all these samples, many of them with one call of the integrand. The group is the one that was asked for: what
 * fails in a pixel outside of it is told of the pixel of the group that is next to that one. */
asc_status asc_take(const asc_estimator *self, const asc_group *group, const asc_draw *draws, size_t count,
                    asc_integrand integrand, void *context, asc_error *error);

/* Tells of a sample whose values cannot be added: of which pixel of the group, the first channel that is not finite (or
 * else the largest), its value, and where the sample is, (dimensions) in its own pixel. Returns `status`. */
asc_status asc_fail_value(const asc_estimator *self, const asc_group *group, asc_pixel pixel, const double *point,
                          const double *values, asc_status status, asc_error *error);

/* Tells of samples that the sampler did not give, of all its dimensions, and of weights. Return `status`. */
asc_status asc_fail_samples(const asc_sampler *sampler, const asc_group *group, const asc_range *range,
                            const double *points, asc_status status, asc_error *error);
asc_status asc_fail_weights(const asc_sampler *sampler, uint64_t first, size_t count, const double *weights,
                            asc_status status, asc_error *error);

/* Makes `fresh`, the same pattern with the seed xor 0x9e3779b97f4a7c15: Kirk and Arvo 1991 ask for samples that know
 * nothing of those that decided, and the next points of a sequence lie where its first do not. ASC_UNSUPPORTED for a
 * pattern without seed. */
asc_status asc_prepare_fresh(asc_estimator *self, asc_error *error);

/* The pixel with this number in its group. */
asc_pixel asc_pixel_of(const asc_group *group, size_t number);

/* Writes what the tallies say of independent samples: means, standard errors, degrees; `spent` to counts and all. */
void asc_write_tallies(asc_estimates *made, size_t pixel, uint32_t channels, const asc_tally *tallies, uint64_t spent);

#endif

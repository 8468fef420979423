/* Samples until the mean is known: until Student's interval about it, t s/sqrt(n) to either side at `confidence`, is
 * within the tolerance, in every channel. t is the quantile (1 + confidence)/2 with n - 1 degrees of freedom.
 *
 * Purgathofer 1987, "A statistical method for adaptive stochastic sampling", Computers & Graphics 11(2). The interval
 * is that of normal values; those of a pixel are not normal, and looking again and again stops at a lucky moment:
 * `aliascope estimate` measures what both do. */
#include "sequential.h"

static const asc_parameter parameters[ASC_SEQUENTIAL_COUNT] = {
    {"tolerance", ASC_REAL, NULL, 0.0, 1e300, 0.02, "half the width of the mean's interval that is narrow enough"},
    ASC_SEQUENTIAL_PARAMETERS};

static asc_status prepare(asc_estimator *self, asc_error *error) {
  return asc_sequential_prepare(self, ASC_BY_STUDENT_T, error);
}

const asc_estimator_interface asc_estimator_student_t = {
    .name = "student-t",
    .title = "until Student's interval of the mean is within the tolerance",
    .source = "Purgathofer 1987, A statistical method for adaptive stochastic sampling",
    .parameters = parameters,
    .parameter_count = ASC_SEQUENTIAL_COUNT,
    .reach = asc_sequential_reach,
    .prepare = prepare,
    .run = asc_sequential_run};

/* Specs of what is registered, samplers and filters: `name` or `name:key=value,key=value`. */
#ifndef ASC_SPEC_H
#define ASC_SPEC_H

#include "aliascope/sampler.h"

#define ASC_SPEC_LENGTH 512

/* What a spec of one name may say. `kind` is what messages call it: "sampler". */
typedef struct asc_spec_form {
  const char *kind, *name;
  const asc_parameter *parameters;
  size_t parameter_count;
} asc_spec_form;

/* Copies the name, the part before the colon, to `name`. ASC_INVALID_ARGUMENT where it is empty or too long. */
asc_status asc_spec_name(const char *spec, const char *kind, char name[ASC_SPEC_LENGTH], asc_error *error);

/* ASC_UNKNOWN_NAME, and a message that lists the near misses among `names`. */
asc_status asc_spec_unknown(const char *kind, const char *name, const char *const *names, size_t count,
                            asc_error *error);

/* Reads the keys into `values`, one a parameter, defaults where not named. */
asc_status asc_spec_values(const char *spec, const asc_spec_form *form, double *values, asc_error *error);

/* Writes the canonical form: keys sorted, defaults left out. */
asc_status asc_spec_canonical(const asc_spec_form *form, const double *values, char canonical[ASC_SPEC_LENGTH]);

/* Appends `; did you mean "x" or "y"?` to a text, for the names within two edits of `word`; else the list of all. */
void asc_near_misses(const char *word, const char *const *names, size_t count, char *text, size_t capacity);

#endif

/* Specs of samplers: `name` or `name:key=value,key=value`. */
#ifndef ASC_SPEC_H
#define ASC_SPEC_H

#include "aliascope/plugin.h"

#define ASC_SPEC_LENGTH 512

/* Copies the name, the part before the colon, to `name`. ASC_INVALID_ARGUMENT where it is empty or too long. */
asc_status asc_spec_name(const char *spec, char name[ASC_SPEC_LENGTH], asc_error *error);

/* Reads the keys into `values`, one a parameter, defaults where not named. */
asc_status asc_spec_values(const char *spec, const asc_sampler_interface *interface, double *values, asc_error *error);

/* Writes the canonical form: keys sorted, defaults left out. */
asc_status asc_spec_canonical(const asc_sampler_interface *interface, const double *values,
                              char canonical[ASC_SPEC_LENGTH]);

/* Appends `; did you mean "x" or "y"?` to a text, for the names within two edits of `word`; else the list of all. */
void asc_near_misses(const char *word, const char *const *names, size_t count, char *text, size_t capacity);

#endif

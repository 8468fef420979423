#define _GNU_SOURCE /* newlocale, uselocale: numbers are read and written with a point whatever the host's locale */
#include "spec.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

asc_status asc_spec_name(const char *spec, const char *kind, char name[ASC_SPEC_LENGTH], asc_error *error) {
  /* First, and without a look past it: a text without an end is refused as well. */
  if (strnlen(spec, ASC_SPEC_LENGTH) == ASC_SPEC_LENGTH)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "a %s's spec has at most %d characters", kind, ASC_SPEC_LENGTH - 1);
  const size_t length = strcspn(spec, ":");
  if (length == 0) return asc_fail(error, ASC_INVALID_ARGUMENT, "the %s's spec \"%s\" has no name", kind, spec);
  memcpy(name, spec, length);
  name[length] = '\0';
  return ASC_OK;
}

/* Edits (insertions, deletions, substitutions) from a to b; words longer than a key's are never near. */
static size_t edit_distance(const char *a, const char *b) {
  enum { LONGEST = 48 };
  const size_t m = strlen(a), n = strlen(b);
  if (m >= LONGEST || n >= LONGEST) return LONGEST;
  size_t row[LONGEST];
  for (size_t j = 0; j <= n; j++) row[j] = j;
  for (size_t i = 1; i <= m; i++) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= n; j++) {
      const size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
      const size_t shorter = row[j] < row[j - 1] ? row[j] : row[j - 1];
      diagonal = row[j];
      row[j] = substituted < shorter + 1 ? substituted : shorter + 1;
    }
  }
  return row[n];
}

static void append(char *text, size_t capacity, const char *tail) {
  const size_t length = strlen(text);
  if (length + 1 < capacity) (void)snprintf(text + length, capacity - length, "%s", tail);
}

void asc_near_misses(const char *word, const char *const *names, size_t count, char *text, size_t capacity) {
  int found = 0;
  for (size_t i = 0; i < count; i++) {
    const size_t allowed = strlen(names[i]) > 4 ? 2 : 1;
    if (edit_distance(word, names[i]) > allowed) continue;
    append(text, capacity, found++ ? "\" or \"" : "; did you mean \"");
    append(text, capacity, names[i]);
  }
  if (found) {
    append(text, capacity, "\"?");
    return;
  }
  append(text, capacity, count ? "; known: " : "; it has none");
  for (size_t i = 0; i < count; i++) {
    if (i) append(text, capacity, ", ");
    append(text, capacity, names[i]);
  }
}

asc_status asc_spec_unknown(const char *kind, const char *name, const char *const *names, size_t count,
                            asc_error *error) {
  if (!error) return ASC_UNKNOWN_NAME;
  (void)asc_fail(error, ASC_UNKNOWN_NAME, "unknown %s \"%s\"", kind, name);
  asc_near_misses(name, names, count, error->text, sizeof error->text);
  return ASC_UNKNOWN_NAME;
}

static asc_status read_choice(const asc_parameter *parameter, const char *word, double *value) {
  const char *choice = parameter->choices;
  for (int index = 0; *choice; index++) {
    const size_t length = strcspn(choice, "|");
    if (strlen(word) == length && memcmp(word, choice, length) == 0) {
      *value = index;
      return ASC_OK;
    }
    choice += length + (choice[length] == '|');
  }
  return ASC_INVALID_VALUE;
}

static asc_status read_value(const asc_spec_form *form, const asc_parameter *parameter, const char *word, double *value,
                             asc_error *error) {
  if (parameter->kind == ASC_CHOICE) {
    if (read_choice(parameter, word, value) == ASC_OK) return ASC_OK;
    return asc_fail(error, ASC_INVALID_VALUE, "%s \"%s\": %s=\"%s\" is none of %s", form->kind, form->name,
                    parameter->name, word, parameter->choices);
  }
  char *end = NULL;
  *value = strtod(word, &end);
  if (end == word || *end || !isfinite(*value) || (parameter->kind == ASC_INTEGER && *value != nearbyint(*value)))
    return asc_fail(error, ASC_INVALID_VALUE, "%s \"%s\": %s=\"%s\" is not %s number", form->kind, form->name,
                    parameter->name, word, parameter->kind == ASC_INTEGER ? "a whole" : "a");
  if (*value < parameter->minimum || *value > parameter->maximum)
    return asc_fail(error, ASC_INVALID_VALUE, "%s \"%s\": %s=%s lies outside [%g, %g]", form->kind, form->name,
                    parameter->name, word, parameter->minimum, parameter->maximum);
  return ASC_OK;
}

static asc_status unknown_key(const asc_spec_form *form, const char *key, asc_error *error) {
  if (!error) return ASC_UNKNOWN_KEY;
  const char *names[64];
  size_t count = 0;
  for (; count < form->parameter_count && count < 64; count++) names[count] = form->parameters[count].name;
  (void)asc_fail(error, ASC_UNKNOWN_KEY, "%s \"%s\": unknown key \"%s\"", form->kind, form->name, key);
  asc_near_misses(key, names, count, error->text, sizeof error->text);
  return ASC_UNKNOWN_KEY;
}

static asc_status read_pair(char *pair, const asc_spec_form *form, double *values, uint64_t *seen, asc_error *error) {
  char *equals = strchr(pair, '=');
  if (!equals || equals == pair || !equals[1])
    return asc_fail(error, ASC_INVALID_VALUE, "%s \"%s\": \"%s\" is not of the form key=value", form->kind, form->name,
                    pair);
  *equals = '\0';
  for (size_t i = 0; i < form->parameter_count; i++) {
    if (strcmp(form->parameters[i].name, pair) != 0) continue;
    if (*seen >> i & 1u)
      return asc_fail(error, ASC_INVALID_VALUE, "%s \"%s\": the key \"%s\" stands twice", form->kind, form->name, pair);
    *seen |= (uint64_t)1 << i;
    return read_value(form, &form->parameters[i], equals + 1, &values[i], error);
  }
  return unknown_key(form, pair, error);
}

static asc_status read_pairs(const char *spec, const asc_spec_form *form, double *values, asc_error *error) {
  const char *rest = strchr(spec, ':');
  uint64_t seen = 0;
  while (rest) {
    char pair[ASC_SPEC_LENGTH];
    const size_t length = strcspn(++rest, ",");
    memcpy(pair, rest, length);
    pair[length] = '\0';
    asc_status status = read_pair(pair, form, values, &seen, error);
    if (status) return status;
    rest = rest[length] == ',' ? rest + length : NULL;
  }
  return ASC_OK;
}

asc_status asc_spec_values(const char *spec, const asc_spec_form *form, double *values, asc_error *error) {
  for (size_t i = 0; i < form->parameter_count; i++) values[i] = form->parameters[i].fallback;
  locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  if (!plain) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  locale_t before = uselocale(plain);
  asc_status status = read_pairs(spec, form, values, error);
  (void)uselocale(before);
  freelocale(plain);
  return status;
}

/* The shortest decimal that reads back as the same double. */
static void write_number(double value, char *text, size_t capacity) {
  for (int digits = 1; digits <= 17; digits++) {
    (void)snprintf(text, capacity, "%.*g", digits, value);
    if (strtod(text, NULL) == value) return;
  }
}

static void write_value(const asc_parameter *parameter, double value, char *text, size_t capacity) {
  if (parameter->kind == ASC_INTEGER) {
    (void)snprintf(text, capacity, "%.0f", value);
    return;
  }
  if (parameter->kind == ASC_REAL) {
    write_number(value, text, capacity);
    return;
  }
  const char *choice = parameter->choices;
  for (int index = 0; index < (int)value; index++) choice += strcspn(choice, "|") + 1;
  (void)snprintf(text, capacity, "%.*s", (int)strcspn(choice, "|"), choice);
}

static int by_name(const void *a, const void *b) {
  return strcmp((*(const asc_parameter *const *)a)->name, (*(const asc_parameter *const *)b)->name);
}

asc_status asc_spec_canonical(const asc_spec_form *form, const double *values, char canonical[ASC_SPEC_LENGTH]) {
  const asc_parameter *sorted[64];
  for (size_t i = 0; i < form->parameter_count; i++) sorted[i] = &form->parameters[i];
  qsort(sorted, form->parameter_count, sizeof *sorted, by_name);
  locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
  if (!plain) return ASC_OUT_OF_MEMORY;
  locale_t before = uselocale(plain);
  (void)snprintf(canonical, ASC_SPEC_LENGTH, "%s", form->name);
  int shown = 0;
  for (size_t i = 0; i < form->parameter_count; i++) {
    const double value = values[sorted[i] - form->parameters];
    if (value == sorted[i]->fallback) continue;
    char text[64];
    write_value(sorted[i], value, text, sizeof text);
    append(canonical, ASC_SPEC_LENGTH, shown++ ? "," : ":");
    append(canonical, ASC_SPEC_LENGTH, sorted[i]->name);
    append(canonical, ASC_SPEC_LENGTH, "=");
    append(canonical, ASC_SPEC_LENGTH, text);
  }
  (void)uselocale(before);
  freelocale(plain);
  return ASC_OK;
}

/* The parser of specs, as every registry calls it: any text, ended by a NUL or, where it is longer than any spec, not.
 *
 * The first byte says which registry; the others are the text. */
#include "aliascope/discrepancy.h"
#include "aliascope/estimate.h"
#include "aliascope/filter.h"
#include "aliascope/uneven.h"
#include "bytes.h"
#include "spec.h"

/* A message is there, ends, and is one line but for what the text itself has. */
static void check_error(asc_status status, const asc_error *error, const char *text, size_t size) {
  require(asc_status_text(status)[0] != '\0', "status %d has no text", (int)status);
  require(memchr(error->text, '\0', sizeof error->text) != NULL, "a message without an end");
  require(error->text[0] != '\0', "status %d without a message", (int)status);
  if (!memchr(text, '\n', size)) require(!strchr(error->text, '\n'), "a message of two lines");
}

/* Reading the canonical form gives the same. */
typedef asc_status (*canonical_function)(const char *spec, char *canonical, size_t capacity, asc_error *error);

static void check_canonical(canonical_function canonical, const char *text, size_t size) {
  char first[ASC_SPEC_LENGTH], second[ASC_SPEC_LENGTH], little[8];
  asc_error error = {{0}};
  const asc_status status = canonical(text, first, sizeof first, &error);
  require(canonical(text, first, sizeof first, NULL) == status, "another status without a message");
  if (status) {
    check_error(status, &error, text, size);
    return;
  }
  require(canonical(first, second, sizeof second, &error) == ASC_OK, "\"%s\" is refused: %s", first, error.text);
  require(strcmp(first, second) == 0, "\"%s\" became \"%s\"", first, second);
  const asc_status cut = canonical(text, little, sizeof little, &error);
  require(cut == (strlen(first) < sizeof little ? ASC_OK : ASC_INVALID_ARGUMENT), "cut: %d", (int)cut);
}

/* Samplers have no such function: the canonical form is that of one which is made. Three points are quick. */
static asc_status sampler_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error) {
  const asc_sampler_desc desc = {sizeof desc, spec, 4, 2, 1};
  asc_sampler *sampler = NULL;
  asc_status status = asc_sampler_create(&desc, &sampler, error);
  require((status == ASC_OK) == (sampler != NULL), "a sampler with status %d", (int)status);
  if (status) return status;
  asc_sampler_desc resolved;
  require(asc_sampler_resolved(sampler, &resolved) == ASC_OK, "no resolved desc");
  status = strlen(resolved.spec) < capacity ? ASC_OK : ASC_INVALID_ARGUMENT;
  if (status == ASC_OK) (void)strcpy(canonical, resolved.spec); /* NOLINT: its length was looked at */
  asc_sampler_destroy(sampler);
  return status;
}

static asc_status filter_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error) {
  const asc_filter_desc desc = {sizeof desc, spec};
  asc_filter *filter = NULL;
  asc_status status = asc_filter_create(&desc, &filter, error);
  require((status == ASC_OK) == (filter != NULL), "a filter with status %d", (int)status);
  if (status) return status;
  asc_filter_desc resolved;
  require(asc_filter_resolved(filter, &resolved) == ASC_OK, "no resolved desc");
  status = strlen(resolved.spec) < capacity ? ASC_OK : ASC_INVALID_ARGUMENT;
  if (status == ASC_OK) (void)strcpy(canonical, resolved.spec); /* NOLINT: its length was looked at */
  asc_filter_destroy(filter);
  return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const canonical_function registries[] = {sampler_canonical, asc_measure_canonical, filter_canonical,
                                                  asc_estimator_canonical, asc_weighting_canonical};
  if (size == 0) return 0;
  /* In memory of the text's own length, so that a sanitizer sees what is read past it. */
  const size_t length = size - 1, end = length >= ASC_SPEC_LENGTH ? 0 : 1;
  char *text = malloc(length + end);
  if (!text) return 0;
  memcpy(text, data + 1, length);
  if (end) text[length] = '\0';
  check_canonical(registries[data[0] % (sizeof registries / sizeof *registries)], text, length);
  free(text);
  return 0;
}

#include "aliascope/base.h"

#include <stdarg.h>
#include <stdio.h>

const char *asc_status_text(asc_status status) {
  switch (status) {
#define CASE(name, number, text)                                                                                       \
  case ASC_##name: return text;
    ASC_STATUS_LIST(CASE)
#undef CASE
  }
  return "unknown status";
}

const char *asc_version(void) { return ASC_VERSION; }

asc_status asc_fail(asc_error *error, asc_status status, const char *format, ...) {
  if (error) {
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
  }
  return status;
}

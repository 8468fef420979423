/* What every part of the library shares: status codes, messages, export.
 *
 * Every call that can fail returns an asc_status and hands its results out through pointers. Nothing here prints,
 * exits, sets errno or reads the environment.
 */
#ifndef ASC_BASE_H
#define ASC_BASE_H

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__) && !defined(ASC_CDEF) /* ASC_CDEF: the headers are read by cffi */
#define ASC_API __attribute__((visibility("default")))
#define ASC_PRINTF(text, values) __attribute__((format(printf, text, values)))
#else
#define ASC_API
#define ASC_PRINTF(text, values)
#endif

/* Numbers are stable: codes are only ever appended. */
#define ASC_STATUS_LIST(X)                                                                                             \
  X(OK, 0, "success")                                                                                                  \
  X(INVALID_ARGUMENT, 1, "an argument is out of its range")                                                            \
  X(OUT_OF_MEMORY, 2, "out of memory")                                                                                 \
  X(UNKNOWN_NAME, 3, "no such name is registered")                                                                     \
  X(UNKNOWN_KEY, 4, "no such key")                                                                                     \
  X(INVALID_VALUE, 5, "the value of a key is out of its range")                                                        \
  X(UNSUPPORTED, 6, "the pattern does not exist for this count, dimension or index")                                   \
  X(UNAVAILABLE, 7, "a library that this needs is missing or failed to start")                                         \
  X(PLUGIN, 8, "the plugin could not be loaded")                                                                       \
  X(NUMERIC, 9, "a result is not a finite number")                                                                     \
  X(OUT_OF_RANGE, 10, "a sampler gave a value outside [0, 1)")                                                         \
  X(ENDED, 11, "the process of the plugin has ended")

#define ASC_STATUS_ENUM(name, number, text) ASC_##name = number,
typedef enum asc_status { ASC_STATUS_LIST(ASC_STATUS_ENUM) } asc_status;

/* One line of English for a status, in static storage. An unknown code gives "unknown status". */
ASC_API const char *asc_status_text(asc_status status);

/* A longer message about one failed call: what is wrong and what to do, one line, NUL-terminated, cut to fit. Every
 * function that takes an `asc_error *` accepts NULL; on success the text is left alone. */
#define ASC_ERROR_CAPACITY 400
typedef struct asc_error {
  char text[400];
} asc_error;

/* Writes a message as printf does, cut to fit, and returns `status`, for `return asc_fail(error, ...)`. The other
 * libraries of the project use it too. */
ASC_API asc_status asc_fail(asc_error *error, asc_status status, const char *format, ...) ASC_PRINTF(3, 4);

/* Version of the library, "major.minor.patch", in static storage. */
ASC_API const char *asc_version(void);

#endif

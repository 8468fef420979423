/* What the fuzz targets share: a fuzzer's bytes read as numbers, and checks that end the process. */
#ifndef FUZZ_BYTES_H
#define FUZZ_BYTES_H

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aliascope/sampler.h"

/* One input: what is found by it is kept by the fuzzer when the process ends by abort or a sanitizer. Returns 0. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* A finding, with a message, unless `holds`. */
__attribute__((format(printf, 2, 3))) static inline void require(int holds, const char *format, ...) {
  if (holds) return;
  va_list values;
  va_start(values, format);
  (void)vfprintf(stderr, format, values);
  va_end(values);
  (void)fputc('\n', stderr);
  abort();
}

/* What is left of an input. Past its end all is zero. */
typedef struct bytes {
  const uint8_t *at;
  size_t left;
} bytes;

static inline uint64_t take(bytes *from, unsigned count) {
  uint64_t value = 0;
  for (unsigned i = 0; i < count; i++) {
    value |= (uint64_t)(from->left ? *from->at : 0) << 8 * i;
    if (!from->left) continue;
    from->at++;
    from->left--;
  }
  return value;
}

/* From 0 to below n, n at most 2^16. */
static inline uint32_t take_below(bytes *from, uint32_t n) { return (uint32_t)take(from, n > 256 ? 2 : 1) % n; }

/* Small numbers, those about powers of two, and all others. */
static inline uint64_t take_count(bytes *from) {
  const uint32_t kind = take_below(from, 4);
  if (kind == 0) return take(from, 1);
  if (kind == 1) return take(from, 2);
  if (kind == 2) return ((uint64_t)1 << take_below(from, 64)) + take_below(from, 3) - 1;
  return take(from, 8);
}

/* Any double: a few that are known to be hard, even fractions, and any bits. */
static inline double take_double(bytes *from) {
  static const double hard[] = {0.0,
                                -0.0,
                                1.0,
                                -1.0,
                                0.5,
                                0x1p-53,
                                0x1p-1074,
                                0x1p-1022,
                                0x1.fffffffffffffp-1,
                                0x1.0000000000001p0,
                                0x1.fffffffffffffp1023,
                                0x1p511,
                                1e30,
                                -1e30,
                                NAN,
                                INFINITY,
                                -INFINITY,
                                1.0 / 3.0};
  const uint32_t kind = take_below(from, 5);
  if (kind == 0) return hard[take_below(from, sizeof hard / sizeof *hard)];
  if (kind == 1) return (double)take(from, 1) / 16.0 - 8.0;
  if (kind == 2) return (double)take(from, 2) / 65536.0;
  if (kind == 3) return ldexp((double)take(from, 1), (int)take_below(from, 256) - 128);
  const uint64_t bits = take(from, 8);
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* In [0, 1] unless it is any double: one of 32 is. */
static inline double take_coordinate(bytes *from) {
  static const double hard[] = {0.0, 1.0, 0.5, 0x1p-53, 0x1p-1074, 0x1.fffffffffffffp-1, 0.25, 1.0 / 3.0};
  const uint32_t kind = take_below(from, 32);
  if (kind == 0) return take_double(from);
  if (kind < 12) return (double)take(from, 1) / 256.0;
  if (kind < 20) return (double)take(from, 1) / 255.0;
  if (kind < 24) return hard[take_below(from, sizeof hard / sizeof *hard)];
  if (kind < 28) return (double)(take(from, 8) >> 11) * 0x1p-53;
  return ldexp((double)take(from, 1) / 256.0, -(int)take_below(from, 256));
}

/* Appends the keys of some of the parameters to a spec, in any order, once each. Numbers are those within their range,
 * up to `most`. */
static inline void take_keys(bytes *from, const asc_parameter *parameters, size_t count, double most, char *spec,
                             size_t capacity) {
  uint32_t shown = 0;
  for (size_t k = 0; k < count; k++) {
    const asc_parameter *parameter = &parameters[k];
    if (take_below(from, 2) == 0) continue;
    const size_t length = strlen(spec);
    char *to = spec + length;
    const size_t room = capacity - length;
    const char *before = shown++ ? "," : ":";
    if (parameter->kind == ASC_CHOICE) {
      const char *choice = parameter->choices;
      uint32_t choices = 1;
      for (const char *at = choice; *at; at++) choices += *at == '|';
      for (uint32_t index = take_below(from, choices); index > 0; index--) choice += strcspn(choice, "|") + 1;
      (void)snprintf(to, room, "%s%s=%.*s", before, parameter->name, (int)strcspn(choice, "|"), choice);
    } else if (parameter->kind == ASC_INTEGER) {
      const double last = fmin(parameter->maximum, most), steps = fmax(last - parameter->minimum, 0.0) + 1.0;
      const double value = parameter->minimum + fmod((double)take(from, steps > 256.0 ? 4 : 1), steps);
      (void)snprintf(to, room, "%s%s=%.0f", before, parameter->name, value);
    } else {
      const double share = (double)take(from, 2) / 65535.0;
      const double wide = parameter->minimum + share * (parameter->maximum - parameter->minimum);
      const double near = fmin(fmax(share, parameter->minimum), parameter->maximum);
      const double value = take_below(from, 2) && parameter->maximum <= most ? wide : near;
      (void)snprintf(to, room, "%s%s=%.17g", before, parameter->name, value);
    }
  }
}

#endif

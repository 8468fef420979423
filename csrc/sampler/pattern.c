#include "pattern.h"

#include <math.h>

static int power_reaches(uint64_t base, uint32_t power, uint64_t n) {
  uint64_t product = 1;
  for (uint32_t i = 0; i < power; i++) {
    if (product > n / base) return 2; /* past n */
    product *= base;
  }
  return product == n ? 1 : 0;
}

uint64_t asc_exact_root(uint64_t n, uint32_t power) {
  if (n == 0 || power == 0) return 0;
  if (power == 1 || n == 1) return n;
  uint64_t guess = (uint64_t)llround(pow((double)n, 1.0 / power));
  for (uint64_t k = guess > 1 ? guess - 1 : 1; k <= guess + 1; k++)
    if (power_reaches(k, power, n) == 1) return k;
  return 0;
}

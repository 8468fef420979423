#include "galois.h"

#include <stdlib.h>

int asc_is_prime_power(uint32_t s, uint32_t *prime, uint32_t *power) {
  if (s < 2) return 0;
  uint32_t divisor = 2;
  while ((uint64_t)divisor * divisor <= s && s % divisor) divisor++;
  *prime = s % divisor ? s : divisor;
  for (*power = 0; s % *prime == 0; s /= *prime) ++*power;
  return s == 1;
}

static uint32_t add_digits(uint32_t prime, uint32_t a, uint32_t b) {
  uint32_t sum = 0;
  for (uint32_t place = 1; a || b; place *= prime, a /= prime, b /= prime) sum += (a + b) % prime * place;
  return sum;
}

uint32_t asc_galois_add(const asc_galois *field, uint32_t a, uint32_t b) {
  if (field->power == 1) return (a + b) % field->size;
  return field->prime == 2 ? a ^ b : add_digits(field->prime, a, b);
}

uint32_t asc_galois_multiply(const asc_galois *field, uint32_t a, uint32_t b) {
  if (field->power == 1) return (uint32_t)((uint64_t)a * b % field->size);
  return a && b ? field->power_of[field->logarithm[a] + field->logarithm[b]] : 0;
}

/* x times a polynomial, where x^m = `reduced`: the digits move up, the one that leaves comes back as its multiple. */
static uint32_t times_x(const asc_galois *field, uint32_t a, uint32_t reduced) {
  const uint32_t top = field->size / field->prime;
  uint32_t product = a % top * field->prime;
  for (uint32_t leaving = a / top; leaving; leaving--) product = asc_galois_add(field, product, reduced);
  return product;
}

/* Whether x runs through all s - 1 elements but 0 before it comes back to 1: then x^m = `reduced` makes a field, whose
 * generator x is. The tables are filled on the way. */
static int generates(asc_galois *field, uint32_t reduced) {
  uint32_t element = 1;
  for (uint32_t i = 0; i < field->size - 1; i++) {
    if (element == 0 || (i > 0 && element == 1)) return 0;
    field->power_of[i] = (uint16_t)element;
    field->logarithm[element] = (uint16_t)i;
    element = times_x(field, element, reduced);
  }
  return element == 1;
}

asc_status asc_galois_make(asc_galois *made, uint32_t s) {
  *made = (asc_galois){.size = s, .prime = s, .power = 1};
  (void)asc_is_prime_power(s, &made->prime, &made->power);
  if (s < 4 || made->power == 1) return ASC_OK; /* the integers modulo s */
  made->power_of = calloc(3 * (size_t)s, sizeof *made->power_of);
  if (!made->power_of) return ASC_OUT_OF_MEMORY;
  made->logarithm = made->power_of + 2 * (size_t)s;
  uint32_t reduced = 1;
  while (!generates(made, reduced)) reduced++; /* a primitive polynomial of each degree exists */
  for (uint32_t i = 0; i < s - 1; i++) made->power_of[s - 1 + i] = made->power_of[i];
  return ASC_OK;
}

void asc_galois_free(asc_galois *field) { free(field->power_of); }

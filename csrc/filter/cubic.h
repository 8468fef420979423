/* The cubics in two pieces of Mitchell and Netravali, which other filters are cases of. */
#ifndef ASC_CUBIC_H
#define ASC_CUBIC_H

#include <stddef.h>
#include <stdint.h>

/* The knots are at half the radius and the radius: at 1 and 2 pixels where the radius is 2. */
uint32_t asc_cubic_pieces(const double *values);
void asc_cubic_evaluate(double b, double c, double radius, const double *x, size_t n, double *profile);
double asc_cubic_primitive(double b, double c, double radius, double x);

#endif

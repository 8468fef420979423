/* Integrals of a filter's profile, where there is no closed form. */
#ifndef ASC_QUADRATURE_H
#define ASC_QUADRATURE_H

#include "profile.h"

/* The integral of profile(x) cos(2 pi frequency x) from 0 to `end`, at most the radius, for frequency >= 0. */
double asc_profile_integral(const asc_filter_interface *interface, const double *values, double end, double frequency);

#endif

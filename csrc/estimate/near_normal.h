/* Laws whose density, in a well chosen variable w, is exp(-a w^2/2) h(w) with h(0) = 1, h a power series and a large:
 * Student's t and chi-squared with many degrees of freedom. The change of variable is exact, so this is no
 * approximation by the normal law; what is left off is the series after its first terms. */
#ifndef ASC_NEAR_NORMAL_H
#define ASC_NEAR_NORMAL_H

#define ASC_NEAR_NORMAL_TERMS 24

typedef struct asc_near_normal {
  long double a;
  long double series[ASC_NEAR_NORMAL_TERMS]; /* of h, the constant first */
} asc_near_normal;

/* w with the integral from w on = q times the whole, for q in (0, 1/2]. `start` is near it. */
long double asc_near_normal_tail(const asc_near_normal *law, long double q, long double start);

/* For an even h: w with the integral from 0 to w = share times the whole, share in (0, 1/2); it keeps its digits where
 * the share is small. */
long double asc_near_normal_body(const asc_near_normal *law, long double share, long double start);

#endif

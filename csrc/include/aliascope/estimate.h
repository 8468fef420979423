/* Estimates of integrals: moments, confidence, sequential and adaptive sampling.
 *
 * An estimator is immutable once made and may be used from any number of threads. What it gives for a pixel is a
 * function of (spec, sampler, group) and of the integrand's values alone.
 */
#ifndef ASC_ESTIMATE_H
#define ASC_ESTIMATE_H

#include "aliascope/base.h"
#include "aliascope/sampler.h"
#include "aliascope/warp.h"

/* ---- Moments of values that come one after the other ----
 *
 * Count, mean and sum of squared differences from the mean, by Welford's recurrence (Welford 1962) on x - origin, where
 * the origin is the first value: neither a large mean nor a large count cancels. The zero struct is that of no values.
 */
typedef struct asc_moments {
  uint64_t count;
  double origin;  /* the first value */
  double mean;    /* of x - origin */
  double squares; /* the sum of (x - mean)^2 */
} asc_moments;

/* Adds n values; in one call or in several, the bits are the same. ASC_INVALID_ARGUMENT for a null pointer,
 * ASC_NUMERIC (and nothing is added) where a value is not finite or the squares overflow. */
ASC_API asc_status asc_moments_add(asc_moments *to, const double *values, size_t n);

/* Those of both together (Chan, Golub and LeVeque 1979, the pairwise update), `from` after `to`. Statuses as above. */
ASC_API asc_status asc_moments_merge(asc_moments *to, const asc_moments *from);

typedef struct asc_moments_summary {
  uint64_t count;
  double mean;
  double variance;       /* unbiased: squares / (count - 1); NaN for fewer than two values */
  double standard_error; /* of the mean, sqrt(variance / count); NaN for fewer than two */
} asc_moments_summary;

ASC_API asc_status asc_moments_summarise(const asc_moments *of, asc_moments_summary *made);

/* The interval of Student's t about the mean that holds it with probability `confidence`, in (0, 1), where the values
 * are independent and normal. Two values at least, else ASC_INVALID_ARGUMENT. */
ASC_API asc_status asc_moments_interval(const asc_moments *of, double confidence, double *lower, double *upper);

/* ---- Quantiles: x with P(X <= x) = p ----
 *
 * p in (0, 1), degrees of freedom from 1 to 1e12, not whole ones too; within 1e-12 of the exact value, relative.
 * ASC_INVALID_ARGUMENT elsewhere; ASC_NUMERIC where x is beyond the largest double, as Student's may be for p below
 * 1e-307. One below the least double is 0. quantiles.c says how they are worked out.
 *
 * Near 1 a double has few digits left for 1 - p. The first two are symmetric: x of 1 - q is minus that of q. For the
 * third there is the upper form, x with P(X > x) = q. */
ASC_API asc_status asc_normal_quantile(double p, double *x);
ASC_API asc_status asc_student_t_quantile(double p, double degrees, double *x);
ASC_API asc_status asc_chi_squared_quantile(double p, double degrees, double *x);
ASC_API asc_status asc_chi_squared_upper_quantile(double q, double degrees, double *x);

/* ---- Strata: parts of the domain, each with samples of its own ---- */

typedef struct asc_stratum {
  double size; /* area, or what share of the domain it is: positive */
  asc_moments moments;
} asc_stratum;

typedef struct asc_stratified {
  double mean;           /* over the whole domain: the sum of size times mean, over the sum of sizes */
  double standard_error; /* of the mean */
  double degrees; /* of freedom that it has about, for Student's t (Satterthwaite 1946; Cochran 1977, eq. 5.16) */
} asc_stratified;

/* With w_j the share of stratum j, F_j the mean of its n_j independent values and s_j^2 their variance,
 *
 *   F = sum of w_j F_j,   V[F] = sum of w_j^2 V[F_j],   V[F_j] = V_j/n_j, estimated by s_j^2/n_j   (Cochran 1977,
 * eq. 5.7)
 *
 * and where w_j = n_j/N, as on the lecture's page "Stratified Sampling", V[F] = 1/N^2 sum of n_j V_j, V_j being the
 * variance of one value (the page prints 1/N sum of N_j V[F_j] and goes on with 1/N^2 for its edge, which is right).
 *
 * A stratum of one value shows no variance. Such strata are collapsed in pairs, in the order given, the last three
 * together where their number is odd: L of them add L/(L - 1) times the squares of w_j F_j about their mean (Cochran
 * 1977, section 5A.12). That is too much by what the strata themselves differ, so put neighbours next to each other. A
 * single stratum of one value among others leaves the standard error NaN.
 *
 * ASC_INVALID_ARGUMENT for no strata, a size that is not positive and finite, a stratum without values;
 * ASC_OUT_OF_MEMORY; ASC_NUMERIC where a result is too large. */
ASC_API asc_status asc_stratify(const asc_stratum *strata, size_t count, asc_stratified *made);

/* ---- Integrands and estimators ---- */

/* Pixels [x, x + columns) x [y, y + rows), numbered row by row. Each is an integral of its own over the unit cube, of
 * which the first two dimensions are the place in the pixel. */
typedef struct asc_group {
  int32_t x, y;
  uint32_t columns, rows;
} asc_group;

typedef struct asc_pixel {
  int32_t x, y;
} asc_pixel;

/* Writes the integrand's values, [count][channels], at `count` samples: `points` are [count][dimensions] in [0, 1),
 * sample i being one of pixel `pixels[i]`. Anything but ASC_OK ends the estimate and is given on. */
typedef asc_status (*asc_integrand)(void *context, size_t count, const asc_pixel *pixels, const double *points,
                                    double *values);

/* Importance sampling: the integral of f as the mean of f(x)/p(x), x of density p.
 *
 * asc_importance_values is an asc_integrand whose context is an asc_importance; it can be given to every estimator. It
 * turns points u of the sampler into x, asks the inner integrand there, and divides by the density. p must not be 0
 * where f is not, or that part is missing. A sample of density 0, as the edge of a warp's square may give, is one where
 * nothing can be: its value is 0. ASC_NUMERIC for a density that is negative or not finite, ASC_OUT_OF_MEMORY, and what
 * the callbacks give. */
typedef asc_status (*asc_warping)(const void *context, size_t count, const double *u, double *points, double *pdf);

typedef struct asc_importance {
  uint32_t point_dimensions; /* of x: 3 for a direction */
  uint32_t channels;
  asc_warping warp; /* writes points [count][point_dimensions] and their densities [count] */
  const void *warp_context;
  asc_integrand integrand; /* gets x */
  void *context;
} asc_importance;

ASC_API asc_status asc_importance_values(void *importance, size_t count, const asc_pixel *pixels, const double *u,
                                         double *values);

/* An asc_warping whose context is an asc_density. */
ASC_API asc_status asc_density_warping(const void *density, size_t count, const double *u, double *points, double *pdf);

typedef struct asc_estimator asc_estimator;

typedef struct asc_estimator_desc {
  size_t struct_size;         /* sizeof(asc_estimator_desc) */
  const char *spec;           /* "student-t:tolerance=0.01" */
  const asc_sampler *sampler; /* its N is the most samples of a pixel; not owned, must live as long */
  uint32_t channels;          /* of the integrand, 1 to ASC_CHANNELS_MOST */
} asc_estimator_desc;
#define ASC_CHANNELS_MOST 16

/* ASC_UNKNOWN_NAME, ASC_UNKNOWN_KEY (the message lists near misses), ASC_INVALID_VALUE; ASC_UNSUPPORTED for a sampler
 * that is no sequence or is weighted, unless the estimator takes it whole, as `fixed` does, or that has fewer
 * dimensions than the estimator needs. */
ASC_API asc_status asc_estimator_create(const asc_estimator_desc *desc, asc_estimator **made, asc_error *error);
ASC_API void asc_estimator_destroy(asc_estimator *made);

/* The resolved desc: `spec` in canonical form (keys sorted, defaults left out), which lives as long as the estimator.
 */
ASC_API asc_status asc_estimator_resolved(const asc_estimator *of, asc_estimator_desc *desc);

/* How far, in pixels, it looks at neighbours: the integrand is asked for pixels up to so far outside the group. */
ASC_API uint32_t asc_estimator_reach(const asc_estimator *of);

/* What came out for each pixel of a group. Any pointer but `means` may be NULL. */
typedef struct asc_estimates {
  size_t struct_size;      /* sizeof(asc_estimates) */
  double *means;           /* [pixel][channel] */
  double *standard_errors; /* [pixel][channel], as the estimator itself states them; NaN where it states none */
  double *degrees;         /* [pixel], of freedom that the standard errors have, for Student's t; NaN where none */
  uint64_t *counts;        /* [pixel], samples that its estimate needed; those that pixels share count in each */
  uint64_t spent;          /* written: all samples, those outside the group too */
} asc_estimates;

/* Estimates all pixels of a group, `made` being theirs, numbered row by row. Decisions are taken on completed samples
 * only, and a pixel's outcome does not depend on which group it is in. ASC_NUMERIC where the integrand gives a value
 * that is not finite. */
ASC_API asc_status asc_estimate(const asc_estimator *with, const asc_group *group, asc_integrand integrand,
                                void *context, asc_estimates *made, asc_error *error);

/* What is registered, for lists and help. Strings live as long as the library. */
typedef struct asc_estimator_info {
  const char *name, *title, *source;
  const asc_parameter *parameters;
  size_t parameter_count;
} asc_estimator_info;

ASC_API size_t asc_estimator_count(void);
ASC_API asc_status asc_estimator_describe(size_t index, asc_estimator_info *info);

/* The canonical form of a spec. `capacity` bytes with the NUL. */
ASC_API asc_status asc_estimator_canonical(const char *spec, char *canonical, size_t capacity, asc_error *error);

#endif

/* Sampling patterns.
 *
 * A sampler is immutable once made and may be used from any number of threads. asc_sampler_fill is pure: a value
 * depends on (spec, samples, seed, pixel, sample index, dimension) alone, so any range can be asked for in any order
 * and gives the same bits as all at once. Patterns that are not randomised ignore seed and pixel.
 *
 * Points are double, row-major [sample][dimension], in [0, 1). So that they stay below 1 as float, values in
 * [1 - 2^-25, 1) become 1 - 2^-24.
 */
#ifndef ASC_SAMPLER_H
#define ASC_SAMPLER_H

#include "aliascope/base.h"

typedef struct asc_sampler asc_sampler;

/* What to make. Zero means default, except for `spec`. */
typedef struct asc_sampler_desc {
  size_t struct_size;  /* sizeof(asc_sampler_desc) */
  const char *spec;    /* "name" or "name:key=value,key=value", such as "sobol:scramble=owen" */
  uint64_t samples;    /* N, the points of one pixel; 0: 1. A sequence's points do not depend on it. */
  uint32_t dimensions; /* 0: 2 */
  uint64_t seed;
} asc_sampler_desc;

/* Which part of a sampler's points: samples [first_sample, first_sample + sample_count) of one pixel, dimensions
 * [first_dimension, first_dimension + dimension_count). */
typedef struct asc_range {
  int32_t pixel_x, pixel_y;
  uint64_t first_sample;
  size_t sample_count;
  uint32_t first_dimension;
  uint32_t dimension_count;
} asc_range;

/* Makes a sampler. ASC_UNKNOWN_NAME, ASC_UNKNOWN_KEY (the message lists near misses), ASC_INVALID_VALUE,
 * ASC_UNSUPPORTED (a count or dimension that the pattern cannot have; it is never adjusted). */
ASC_API asc_status asc_sampler_create(const asc_sampler_desc *desc, asc_sampler **sampler, asc_error *error);
ASC_API void asc_sampler_destroy(asc_sampler *sampler);

/* The resolved desc: defaults filled in, `spec` in canonical form (keys sorted, defaults left out). The string lives
 * as long as the sampler. */
ASC_API asc_status asc_sampler_resolved(const asc_sampler *sampler, asc_sampler_desc *desc);

/* Writes sample_count x dimension_count values to `points`. ASC_UNSUPPORTED past the last index of a net (2^32) or
 * sequence (2^53), or past the N of a pattern that is not a sequence; ASC_INVALID_ARGUMENT past the sampler's
 * dimensions; ASC_OUT_OF_RANGE where a plugin's pattern leaves [0, 1): its values are there, as it gave
 * them. */
ASC_API asc_status asc_sampler_fill(const asc_sampler *sampler, const asc_range *range, double *points);

/* The same of `pixels` pixels in a row, from the range's to the right, one after the other: quicker than one by one
 * where each has few samples. */
ASC_API asc_status asc_sampler_fill_pixels(const asc_sampler *sampler, const asc_range *range, size_t pixels,
                                           double *points);

/* The same of pixels [first, first + pixels) of an area that is so many columns wide, numbered row by row from the
 * range's pixel on. Of a plugin in another process, ASC_TRAIT_DISTANT, the less often it is asked the better. */
ASC_API asc_status asc_sampler_fill_area(const asc_sampler *sampler, const asc_range *range, uint32_t columns,
                                         size_t first, size_t pixels, double *points);

/* Writes the weights of samples [first, first + count): those of a quadrature rule, else 1/N. ASC_NUMERIC where a
 * plugin's are not finite. */
ASC_API asc_status asc_sampler_weights(const asc_sampler *sampler, uint64_t first, size_t count, double *weights);

/* How the dimensions of a sample go together where they come in groups: the place in the pixel, the time, the point of
 * the lens.
 *
 *   joint         one pattern of the sampler in all dimensions, as it lays them out itself.
 *   padded        each group has a pattern of its own, and its samples are shuffled against the first group's: what a
 *                 group has of stratification is kept, and no two groups have any together.
 *   decorrelated  each group has a pattern of its own, given out so that samples near each other in the first group are
 *                 far apart in the others: with k the rank of a sample along a Hilbert curve of the first group's
 *                 plane, it has that point of the further group whose rank along such a curve is the radical inverse of
 *                 k, the digits permuted and both ranks rotated at random. The g-th further group takes the g-th prime
 *                 as its base, so that the place along the curve and all ranks are a Hammersley set; from the 25th on,
 *                 groups are shuffled. N up to 2^14: the whole pattern of the pixel is needed.
 *
 * Shuffles and rotations depend on seed and pixel, also where the patterns do not. Where the patterns are unbiased, so
 * is the arrangement: each point of a further group is as likely for each sample. */
typedef enum asc_arrangement {
  ASC_ARRANGEMENT_JOINT = 0,
  ASC_ARRANGEMENT_PADDED = 1,
  ASC_ARRANGEMENT_DECORRELATED = 2
} asc_arrangement;

/* What to make of a sampler. Zero means default, except for `spec` and `groups`. */
typedef struct asc_arrangement_desc {
  size_t struct_size; /* sizeof(asc_arrangement_desc) */
  const char *spec;
  uint64_t samples; /* N; 0: 1 */
  uint64_t seed;
  const uint32_t *groups; /* the dimensions of each group, positive; read during the call */
  size_t group_count;     /* at least 1 */
  asc_arrangement arrangement;
  /* 1: a sampler that is a sequence stays one when it is padded, as estimators need that decide on the way. It is then
   * shuffled within its samples 2^m to 2^(m+1) - 1, for each m, by nested scrambling of the index (Owen 1995; Burley
   * 2020, "Practical hash-based Owen scrambling"), which keeps blocks of 2^j samples together, and it ends at 2^32. 0:
   * all N samples are shuffled, each permutation alike. */
  uint32_t sequential;
} asc_arrangement_desc;

/* Makes a sampler whose dimensions are those of all groups in their order. Its first group has the points that the
 * sampler alone has with this seed, the others those of seeds that are made of it. A group of one dimension has the
 * sampler's one-dimensional pattern, or the first dimension of its planar one where it has none.
 *
 * A sampler that has no pattern for the first group but one in the three dimensions of the first two together, as
 * patterns of space and time do, drives these two as one. Where it has none for a further group that group is
 * `jittered`, as those patterns are in each of their own.
 *
 * ASC_UNSUPPORTED where the sampler lacks a pattern that is needed (in a joint arrangement the message says so where
 * padding would do), and to arrange a quadrature rule, whose weights are those of all its dimensions; otherwise as
 * asc_sampler_create. */
ASC_API asc_status asc_sampler_arrange(const asc_arrangement_desc *desc, asc_sampler **sampler, asc_error *error);

/* The resolved desc of an arranged sampler, its strings and arrays living as long as the sampler. One that is joint, or
 * has but one group, or was not arranged at all, says so: joint, one group, `groups` NULL. */
ASC_API asc_status asc_sampler_arranged(const asc_sampler *sampler, asc_arrangement_desc *desc);

typedef enum asc_parameter_kind { ASC_INTEGER = 0, ASC_REAL = 1, ASC_CHOICE = 2 } asc_parameter_kind;

/* One key of a spec. Values are passed to `create` as double: a choice as the index of its word. */
typedef struct asc_parameter {
  const char *name;
  asc_parameter_kind kind;
  const char *choices; /* "none|owen" for ASC_CHOICE, else NULL */
  double minimum, maximum, fallback;
  const char *text; /* one line of help */
} asc_parameter;

/* Traits of a sampler, or-ed. */
typedef enum asc_trait {
  ASC_TRAIT_RANDOMISED = 1, /* the points depend on seed and pixel */
  ASC_TRAIT_SEQUENCE = 2,   /* the first n points do not depend on N */
  ASC_TRAIT_WEIGHTED = 4,   /* weights other than 1/N */
  ASC_TRAIT_DISTANT = 8     /* each call takes some 10 us, however little is asked for */
} asc_trait;

/* What is registered, for lists and help. Strings live as long as the library. */
typedef struct asc_sampler_info {
  const char *name, *title, *source;
  const asc_parameter *parameters;
  size_t parameter_count;
  uint32_t plugged_in; /* 1: from a plugin */
} asc_sampler_info;

ASC_API size_t asc_sampler_count(void);
ASC_API asc_status asc_sampler_describe(size_t index, asc_sampler_info *info);

/* The traits of one sampler as configured: sobol is randomised only where it is scrambled. */
ASC_API uint32_t asc_sampler_traits(const asc_sampler *sampler);

#endif

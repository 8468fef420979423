/* Arrangements of groups of dimensions: making them, and the padded one. decorrelated.c has the other. */
#include "arrangement.h"

#include <stdlib.h>
#include <string.h>

#include "owen.h"
#include "permutation.h"

/* --- padded ---------------------------------------------------------------------------------------------------------
 */

asc_columns asc_columns_of(const asc_arranged_group *group, const asc_range *range) {
  const uint32_t end = range->first_dimension + range->dimension_count, group_end = group->first + group->size;
  const uint32_t from = range->first_dimension > group->first ? range->first_dimension : group->first;
  const uint32_t to = end < group_end ? end : group_end;
  if (from >= to) return (asc_columns){0, 0, 0};
  return (asc_columns){from - group->first, to - from, from - range->first_dimension};
}

/* Which sample of a group's pattern each sample has. */
typedef struct shuffle {
  int sequential;
  uint32_t group;
  asc_key key;
  asc_permutation whole;
} shuffle;

static uint64_t shuffled(const shuffle *by, uint64_t sample) {
  if (!by->sequential) return asc_permutation_at(&by->whole, sample);
  if (sample < 2) return sample;
  const uint32_t octave = 31 - (uint32_t)__builtin_clz((uint32_t)sample);
  const uint32_t within = (uint32_t)sample << (32 - octave); /* the leading digit on top */
  const uint64_t bits = asc_draw(by->key, 32 * by->group + octave, ASC_PURPOSE_SCRAMBLE);
  return ((uint64_t)1 << octave) + (asc_owen_hash(asc_reverse_bits(within), bits) >> (32 - octave));
}

static void scatter(const double *from, size_t count, const asc_columns *columns, uint32_t stride, double *points) {
  for (size_t i = 0; i < count; i++)
    memcpy(points + i * stride + columns->column, from + i * columns->count, columns->count * sizeof *from);
}

/* The first group, in its own order. */
static asc_status fill_in_order(const asc_sampler *pattern, const asc_range *range, const asc_columns *columns,
                                double *points) {
  asc_range own = *range;
  own.first_dimension = columns->first;
  own.dimension_count = columns->count;
  if (columns->count == range->dimension_count) return asc_sampler_fill(pattern, &own, points);
  double *made = malloc(range->sample_count * columns->count * sizeof *made);
  if (!made) return ASC_OUT_OF_MEMORY;
  const asc_status status = asc_sampler_fill(pattern, &own, made);
  if (status == ASC_OK) scatter(made, range->sample_count, columns, range->dimension_count, points);
  free(made);
  return status;
}

static asc_status fill_one_by_one(const asc_sampler *pattern, const shuffle *by, const asc_range *range,
                                  const asc_columns *columns, double *points) {
  asc_range own = *range;
  own.sample_count = 1;
  own.first_dimension = columns->first;
  own.dimension_count = columns->count;
  for (size_t i = 0; i < range->sample_count; i++) {
    own.first_sample = shuffled(by, range->first_sample + i);
    const asc_status status = asc_sampler_fill(pattern, &own, points + i * range->dimension_count + columns->column);
    if (status) return status;
  }
  return ASC_OK;
}

/* All N points of a group are made, and those taken that are asked for. */
static asc_status fill_from_whole(const asc_sampler *pattern, uint64_t samples, const shuffle *by,
                                  const asc_range *range, const asc_columns *columns, double *points) {
  double *made = malloc((size_t)samples * columns->count * sizeof *made);
  if (!made) return ASC_OUT_OF_MEMORY;
  const asc_range own = {range->pixel_x, range->pixel_y, 0, (size_t)samples, columns->first, columns->count};
  const asc_status status = asc_sampler_fill(pattern, &own, made);
  for (size_t i = 0; i < range->sample_count && status == ASC_OK; i++)
    memcpy(points + i * range->dimension_count + columns->column,
           made + shuffled(by, range->first_sample + i) * columns->count, columns->count * sizeof *made);
  free(made);
  return status;
}

/* Patterns that are made whole take as long for one sample as for all, the others about as long for each. */
#define WHOLE_PER_SAMPLE 64

static asc_status padded_fill(const void *opaque, const asc_range *range, double *points) {
  const asc_arranged *self = opaque;
  asc_status status = ASC_OK;
  for (size_t g = 0; g < self->count && status == ASC_OK; g++) {
    const asc_arranged_group *group = &self->groups[g];
    const asc_columns columns = asc_columns_of(group, range);
    if (columns.count == 0) continue;
    if (g == 0) {
      status = fill_in_order(group->pattern, range, &columns, points);
      continue;
    }
    shuffle by = {self->desc.sequential != 0, (uint32_t)g, asc_arranged_key(self, range), {0}};
    if (!by.sequential) asc_permutation_make(&by.whole, self->desc.samples, by.key, by.group);
    if (!by.sequential && self->desc.samples / WHOLE_PER_SAMPLE <= range->sample_count)
      status = fill_from_whole(group->pattern, self->desc.samples, &by, range, &columns, points);
    else
      status = fill_one_by_one(group->pattern, &by, range, &columns, points);
  }
  return status;
}

/* --- making ---------------------------------------------------------------------------------------------------------
 */

static void arranged_destroy(void *state) {
  asc_arranged *self = state;
  if (!self) return;
  for (size_t g = 0; g < self->count; g++) asc_sampler_destroy(self->groups[g].pattern);
  free(self->sizes);
  free(self);
}

static const asc_sampler_interface padded = {.struct_size = sizeof(asc_sampler_interface),
                                             .name = "padded",
                                             .title = "groups of dimensions, shuffled against each other",
                                             .source = "",
                                             .destroy = arranged_destroy,
                                             .fill = padded_fill};
static const asc_sampler_interface decorrelated = {.struct_size = sizeof(asc_sampler_interface),
                                                   .name = "decorrelated",
                                                   .title = "groups of dimensions, nearby in one, far in the others",
                                                   .source = "after Hanrahan 2000, CS348B",
                                                   .destroy = arranged_destroy,
                                                   .fill = asc_decorrelated_fill};

static int is_arranged(const asc_sampler *sampler) {
  return sampler->interface == &padded || sampler->interface == &decorrelated;
}

/* The seed of the pattern of a further group, and, as number 0, that of all that is drawn for the arrangement. */
static uint64_t seed_of(uint64_t seed, size_t number) {
  return asc_mix64(asc_mix64(seed ^ 0x6172726e67656400u) + number * ASC_GOLDEN);
}

static asc_status pattern_of(const asc_arrangement_desc *desc, const char *spec, uint32_t dimensions, size_t number,
                             asc_sampler **made, asc_error *error) {
  const uint64_t seed = number ? seed_of(desc->seed, number) : desc->seed;
  const asc_sampler_desc pattern = {sizeof pattern, spec, desc->samples, dimensions, seed};
  return asc_sampler_create(&pattern, made, error);
}

/* The first group, or the first two together where the sampler has three dimensions alone. */
static asc_status make_first(asc_arranged *self, asc_error *error) {
  const asc_arrangement_desc *desc = &self->desc;
  asc_arranged_group *group = &self->groups[0];
  group->size = desc->groups[0];
  const asc_status status = pattern_of(desc, desc->spec, group->size, 0, &group->pattern, error);
  if (status != ASC_UNSUPPORTED || desc->group_count < 2 || desc->groups[0] + desc->groups[1] != 3) return status;
  group->size = 3;
  return pattern_of(desc, desc->spec, 3, 0, &group->pattern, NULL) ? status : ASC_OK;
}

static asc_status make_further(asc_arranged *self, uint32_t size, asc_error *error) {
  const size_t number = self->count;
  asc_arranged_group *group = &self->groups[number];
  const asc_arranged_group *before = &self->groups[number - 1];
  *group = (asc_arranged_group){NULL, before->first + before->size, size};
  const char *spec = self->desc.spec;
  asc_status status = pattern_of(&self->desc, spec, size, number, &group->pattern, error);
  if (status == ASC_UNSUPPORTED && size == 1)
    status = pattern_of(&self->desc, spec, 2, number, &group->pattern, NULL) ? status : ASC_OK;
  if (status == ASC_UNSUPPORTED && self->groups[0].size == 3 && self->sizes[0] != 3)
    status = pattern_of(&self->desc, "jittered", size, number, &group->pattern, NULL) ? status : ASC_OK;
  if (status == ASC_OK) self->count++;
  return status;
}

static asc_status make_groups(asc_arranged *self, asc_error *error) {
  asc_status status = make_first(self, error);
  if (status) return status;
  self->count = 1;
  if (asc_sampler_traits(self->groups[0].pattern) & ASC_TRAIT_WEIGHTED)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "%s: the weights of a quadrature rule are those of all its dimensions; "
                    "choose dimensions=joint",
                    self->desc.spec);
  for (size_t i = self->groups[0].size == self->sizes[0] ? 1 : 2; i < self->desc.group_count; i++) {
    status = make_further(self, self->sizes[i], error);
    if (status) return status;
  }
  return ASC_OK;
}

static asc_sampler_state state_of(asc_arranged *self) {
  uint32_t traits = self->count > 1 ? ASC_TRAIT_RANDOMISED : 0, common = ASC_TRAIT_SEQUENCE;
  for (size_t g = 0; g < self->count; g++) {
    const uint32_t own = asc_sampler_traits(self->groups[g].pattern);
    traits |= own & ASC_TRAIT_RANDOMISED;
    common &= own;
  }
  const int sequential = self->desc.sequential && self->desc.arrangement == ASC_ARRANGEMENT_PADDED && common;
  self->desc.sequential = sequential ? 1 : 0;
  if (sequential) traits |= ASC_TRAIT_SEQUENCE;
  return (asc_sampler_state){self, traits, sequential ? ASC_NET_END : self->desc.samples};
}

/* `dimensions`: of all groups. */
static asc_status make_arranged(asc_sampler *sampler, const asc_arrangement_desc *desc, uint32_t dimensions,
                                asc_error *error) {
  asc_arranged *self = calloc(1, sizeof *self + desc->group_count * sizeof *self->groups);
  if (!self) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  self->sizes = malloc(desc->group_count * sizeof *self->sizes);
  asc_status status = ASC_OUT_OF_MEMORY;
  if (!self->sizes) {
    (void)asc_fail(error, status, "out of memory");
  } else {
    memcpy(self->sizes, desc->groups, desc->group_count * sizeof *self->sizes);
    self->desc = *desc;
    self->desc.groups = self->sizes;
    self->shuffling_mix = asc_seed_mix(seed_of(desc->seed, 0));
    status = make_groups(self, error);
  }
  if (status) {
    arranged_destroy(self);
    return status;
  }
  asc_sampler_desc first;
  (void)asc_sampler_resolved(self->groups[0].pattern, &first);
  memcpy(sampler->spec, first.spec, strlen(first.spec) + 1);
  self->desc.spec = sampler->spec;
  sampler->interface = desc->arrangement == ASC_ARRANGEMENT_PADDED ? &padded : &decorrelated;
  sampler->made = state_of(self);
  sampler->resolved = (asc_sampler_desc){sizeof first, sampler->spec, desc->samples, dimensions, desc->seed};
  return ASC_OK;
}

static asc_status arrange(const asc_arrangement_desc *desc, uint32_t dimensions, asc_sampler **sampler,
                          asc_error *error) {
  if (desc->arrangement == ASC_ARRANGEMENT_DECORRELATED && desc->samples > ASC_DECORRELATED_MOST)
    return asc_fail(error, ASC_UNSUPPORTED,
                    "dimensions=decorrelated sorts the samples of a pixel, at most %llu of them; %llu were asked for",
                    (unsigned long long)ASC_DECORRELATED_MOST, (unsigned long long)desc->samples);
  asc_sampler *made = calloc(1, sizeof *made);
  if (!made) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  const asc_status status = make_arranged(made, desc, dimensions, error);
  if (status) {
    free(made);
    return status;
  }
  *sampler = made;
  return ASC_OK;
}

/* One pattern in all dimensions; where there is none, whether padding would do. */
static asc_status join(const asc_arrangement_desc *desc, uint32_t dimensions, asc_sampler **sampler, asc_error *error) {
  asc_error reason = {""};
  const asc_status status = pattern_of(desc, desc->spec, dimensions, 0, sampler, &reason);
  if (status == ASC_OK) return ASC_OK;
  asc_arrangement_desc other = *desc;
  other.arrangement = ASC_ARRANGEMENT_PADDED;
  asc_sampler *tried = NULL;
  if (status != ASC_UNSUPPORTED || desc->group_count < 2 || arrange(&other, dimensions, &tried, NULL))
    return asc_fail(error, status, "%s", reason.text);
  asc_sampler_destroy(tried);
  return asc_fail(error, status, "%s; dimensions=padded gives each group of dimensions a pattern of its own",
                  reason.text);
}

asc_status asc_sampler_arrange(const asc_arrangement_desc *desc, asc_sampler **sampler, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->spec || !sampler || !desc->groups || desc->group_count == 0)
    return asc_fail(error, ASC_INVALID_ARGUMENT,
                    "asc_sampler_arrange: desc needs its struct_size, a spec and a group of dimensions");
  *sampler = NULL;
  uint32_t dimensions = 0;
  for (size_t g = 0; g < desc->group_count; g++) {
    if (desc->groups[g] == 0 || desc->groups[g] > UINT32_MAX - dimensions)
      return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_sampler_arrange: group %zu has %u dimensions", g,
                      desc->groups[g]);
    dimensions += desc->groups[g];
  }
  asc_arrangement_desc resolved = *desc;
  if (resolved.samples == 0) resolved.samples = 1;
  if (desc->group_count == 1) resolved.arrangement = ASC_ARRANGEMENT_JOINT;
  switch (resolved.arrangement) {
  case ASC_ARRANGEMENT_JOINT: return join(&resolved, dimensions, sampler, error);
  case ASC_ARRANGEMENT_PADDED:
  case ASC_ARRANGEMENT_DECORRELATED: return arrange(&resolved, dimensions, sampler, error);
  }
  return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_sampler_arrange: there is no arrangement %d",
                  (int)desc->arrangement);
}

asc_status asc_sampler_arranged(const asc_sampler *sampler, asc_arrangement_desc *desc) {
  if (!sampler || !desc) return ASC_INVALID_ARGUMENT;
  if (is_arranged(sampler))
    *desc = ((const asc_arranged *)sampler->made.state)->desc;
  else
    *desc = (asc_arrangement_desc){.struct_size = sizeof *desc,
                                   .spec = sampler->spec,
                                   .samples = sampler->resolved.samples,
                                   .seed = sampler->resolved.seed,
                                   .group_count = 1,
                                   .sequential = asc_sampler_traits(sampler) & ASC_TRAIT_SEQUENCE ? 1 : 0};
  return ASC_OK;
}

asc_status asc_sampler_reseed(const asc_sampler *sampler, uint64_t seed, asc_sampler **made, asc_error *error) {
  if (!is_arranged(sampler)) {
    asc_sampler_desc desc = sampler->resolved;
    desc.seed = seed;
    return asc_sampler_create(&desc, made, error);
  }
  asc_arrangement_desc desc = ((const asc_arranged *)sampler->made.state)->desc;
  desc.seed = seed;
  return asc_sampler_arrange(&desc, made, error);
}

/* Points made ASC_LANES at a time, at aligned runs of indices, where all but the lowest bits of an index are the same.
 */
#ifndef ASC_LANES_H
#define ASC_LANES_H

#include "bits.h"
#include "pattern.h"

/* The part [from, to) of the run of indices begin ... begin + ASC_LANES - 1 that a range asks for; the sample at `from`
 * is the range's sample number `row`. */
typedef struct asc_run {
  uint64_t begin;
  uint32_t from, to;
  size_t row;
} asc_run;

/* The first run of a range; its `begin` is a multiple of ASC_LANES. */
static inline uint64_t asc_first_run(const asc_range *range) {
  return range->first_sample & ~(uint64_t)(ASC_LANES - 1);
}

static inline asc_run asc_run_at(const asc_range *range, uint64_t begin) {
  const uint64_t first = range->first_sample, end = first + range->sample_count;
  const uint32_t from = begin < first ? (uint32_t)(first - begin) : 0;
  const uint32_t to = end - begin < ASC_LANES ? (uint32_t)(end - begin) : ASC_LANES;
  return (asc_run){begin, from, to, (size_t)(begin + from - first)};
}

/* Writes a run's values to the column of one dimension. */
static inline void asc_write_run(const asc_range *range, asc_run run, uint32_t dimension,
                                 const double values[ASC_LANES], double *points) {
  const size_t stride = range->dimension_count;
  double *column = points + run.row * stride + (dimension - range->first_dimension);
  for (uint32_t i = run.from; i < run.to; i++) column[(i - run.from) * stride] = values[i];
}

#endif

#include "planar.h"

#include <stdlib.h>

#include "permutation.h"

asc_status asc_planar_fill(const void *state, uint64_t samples, uint64_t seed, asc_plane_function plane,
                           const asc_range *range, double *points) {
  if (samples > SIZE_MAX / sizeof(double[2])) return ASC_OUT_OF_MEMORY;
  double(*whole)[2] = malloc((size_t)samples * sizeof *whole);
  if (!whole) return ASC_OUT_OF_MEMORY;
  const asc_key key = asc_stream_key(seed, range->pixel_x, range->pixel_y);
  const uint32_t begin = range->first_dimension, end = begin + range->dimension_count;
  asc_status status = ASC_OK;
  for (uint32_t pair = begin / 2; pair <= (end - 1) / 2 && status == ASC_OK; pair++) {
    status = plane(state, key, pair, whole);
    if (status) break;
    asc_permutation shuffle;
    if (pair > 0) asc_permutation_make(&shuffle, samples, key, pair);
    for (size_t i = 0; i < range->sample_count; i++) {
      const uint64_t sample = range->first_sample + i;
      const double *point = whole[pair > 0 ? asc_permutation_at(&shuffle, sample) : sample];
      for (uint32_t half = 0; half < 2; half++) {
        const uint32_t dimension = 2 * pair + half;
        if (dimension >= begin && dimension < end)
          points[i * range->dimension_count + (dimension - begin)] = point[half];
      }
    }
  }
  free(whole);
  return status;
}

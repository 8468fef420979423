/* What is wrong with a picture that could not be made: where, and whose fault. */
#ifndef TRACER_COMPLAINT_H
#define TRACER_COMPLAINT_H

#include "tracer.h"

/* The pixels of a picture, and `border` more of them each way that were sampled. */
typedef struct complaint_area {
  uint32_t width, height, border;
} complaint_area;

/* Looks again at what the sampler gives, row by row, for the first value that is not in [0, 1) or the first weight that
 * is not finite, and names it. `status` is what the sampler failed with; returned as it is. */
asc_status complain_of_sampler(const asc_sampler *sampler, complaint_area area, asc_status status, asc_error *error);

/* ASC_NUMERIC with the first pixel that has a channel which is no finite number; ASC_OK where there is none. */
asc_status complain_of_pixels(const float *pixels, complaint_area area, asc_error *error);

#endif

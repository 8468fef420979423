/* Cook's pattern of prototype times: 16 points, one in each cell of a 4 x 4 grid and one in each sixteenth of time.
 *
 * Source: Cook 1986, "Stochastic sampling in computer graphics", where a prototype pattern pairs the sub-pixels with
 * slices of time; the table is that of Hanrahan 2000, CS348B, "Space-time patterns", the upper row first. How pixels
 * differ, what is jittered and centred=1: space_time.h. */
#include <stdlib.h>

#include "space_time.h"

#define SIDE 4
#define SAMPLES 16

static const uint8_t slots[SIDE][SIDE] = {{6, 10, 2, 13}, {3, 14, 12, 8}, {15, 0, 7, 11}, {5, 9, 4, 1}};

static uint64_t cook_slot(const asc_space_time *pattern, uint64_t column, uint64_t row) {
  (void)pattern;
  return slots[row][column];
}

static asc_status cook_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  const asc_status status = asc_space_time_check("cook", config, error);
  if (status) return status;
  if (config->samples != SAMPLES)
    return asc_fail(error, ASC_UNSUPPORTED, "cook has 16 points, not %llu", (unsigned long long)config->samples);
  asc_space_time *pattern = asc_space_time_new(config, SIDE, cook_slot, 0);
  if (!pattern) return asc_fail(error, ASC_OUT_OF_MEMORY, "cook: out of memory");
  *made = asc_space_time_state(pattern);
  return ASC_OK;
}

const asc_sampler_interface asc_sampler_cook = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "cook",
    .title = "Cook's 4 x 4 prototype times, in x, y and t",
    .source = "Cook 1986; Hanrahan 2000, CS348B",
    .parameters = &asc_space_time_centred,
    .parameter_count = 1,
    .create = cook_create,
    .destroy = free,
    .fill = asc_space_time_fill,
};

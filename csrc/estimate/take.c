/* Asking the integrand about many samples at once, and what is written of independent samples. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "estimator.h"
#include "made.h"

#define MOST_AT_ONCE 8192 /* samples of one call of the integrand */

typedef struct batch {
  size_t capacity;
  asc_pixel *pixels;
  double *points, *values;
} batch;

/* Which sample of which draw is next. */
typedef struct place {
  size_t draw;
  uint64_t done;
} place;

static void batch_free(batch *made) {
  free(made->pixels);
  free(made->points);
  free(made->values);
}

static asc_status batch_make(batch *made, const asc_estimator *self, const asc_draw *draws, size_t count) {
  size_t capacity = 0;
  for (size_t i = 0; i < count && capacity < MOST_AT_ONCE; i++)
    capacity = draws[i].count < MOST_AT_ONCE ? capacity + (size_t)draws[i].count : MOST_AT_ONCE;
  if (capacity > MOST_AT_ONCE) capacity = MOST_AT_ONCE;
  if (capacity == 0) capacity = 1;
  *made = (batch){capacity, malloc(capacity * sizeof *made->pixels),
                  malloc(capacity * self->dimensions * sizeof *made->points),
                  malloc(capacity * self->channels * sizeof *made->values)};
  if (made->pixels && made->points && made->values) return ASC_OK;
  batch_free(made);
  return ASC_OUT_OF_MEMORY;
}

/* How many samples of the draw at `at` go into what is left of the batch; moves on. */
static size_t advance(place *at, const asc_draw *draws, size_t left) {
  const uint64_t rest = draws[at->draw].count - at->done;
  const size_t taken = rest < left ? (size_t)rest : left;
  at->done += taken;
  if (at->done == draws[at->draw].count) *at = (place){at->draw + 1, 0};
  return taken;
}

/* Moves the points to the draw's part, and those over the pixel's left or upper border to the pixel there. */
static void move(const asc_draw *draw, uint32_t dimensions, size_t count, asc_pixel *pixels, double *points) {
  for (size_t i = 0; i < count; i++) {
    double *point = points + i * dimensions;
    point[0] = draw->x + draw->width * point[0];
    if (point[0] < 0.0) {
      pixels[i].x--;
      point[0] = fmin(point[0] + 1.0, 1.0 - 0x1p-24); /* which rounding could make 1 */
    }
    if (dimensions < 2) continue;
    point[1] = draw->y + draw->height * point[1];
    if (point[1] < 0.0) {
      pixels[i].y--;
      point[1] = fmin(point[1] + 1.0, 1.0 - 0x1p-24);
    }
  }
}

/* The next `count` samples of a draw, of which `done` are there. */
static asc_status fill(const asc_estimator *self, const asc_group *group, const asc_draw *draw, uint64_t done,
                       size_t count, asc_pixel *pixels, double *points, asc_error *error) {
  const uint32_t dimensions = self->dimensions;
  const asc_range range = {draw->pixel.x, draw->pixel.y, draw->first + done, count, 0, dimensions};
  const asc_sampler *sampler = draw->sampler ? draw->sampler : self->sampler;
  const asc_status status = asc_sampler_fill(sampler, &range, points);
  if (status) return asc_fail_samples(sampler, group, &range, points, status, error);
  for (size_t i = 0; i < count; i++) pixels[i] = draw->pixel;
  if (draw->width > 0.0) move(draw, dimensions, count, pixels, points);
  return ASC_OK;
}

static asc_status all_finite(const double *values, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (!isfinite(values[i])) return ASC_NUMERIC;
  return ASC_OK;
}

static asc_status add(const asc_draw *draw, uint32_t channels, const double *values, size_t count) {
  return draw->to ? asc_tally_add(draw->to, channels, values, count) : all_finite(values, count * channels);
}

/* Which of these samples cannot be added, as not all of them can. */
static size_t first_bad(const asc_draw *draw, uint32_t channels, const double *values, size_t count) {
  size_t i = 0;
  while (i + 1 < count && add(draw, channels, values + i * channels, 1) == ASC_OK) i++;
  return i;
}

/* Adds the values of the samples from `at` on, `filled` of them. */
static asc_status hand_out(const asc_estimator *self, const asc_group *group, const asc_draw *draws, place at,
                           const batch *of, size_t filled, asc_error *error) {
  for (size_t i = 0; i < filled;) {
    const asc_draw *draw = &draws[at.draw];
    const uint64_t done = at.done;
    const size_t taken = advance(&at, draws, filled - i);
    const double *values = of->values + i * self->channels;
    if (draw->values) memcpy(draw->values + done * self->channels, values, taken * self->channels * sizeof *values);
    const asc_status status = add(draw, self->channels, values, taken);
    if (status) {
      const size_t bad = i + first_bad(draw, self->channels, values, taken);
      return asc_fail_value(self, group, of->pixels[bad], of->points + bad * self->dimensions,
                            of->values + bad * self->channels, status, error);
    }
    i += taken;
  }
  return ASC_OK;
}

asc_status asc_take(const asc_estimator *self, const asc_group *group, const asc_draw *draws, size_t count,
                    asc_integrand integrand, void *context, asc_error *error) {
  batch work;
  asc_status status = batch_make(&work, self, draws, count);
  if (status) return asc_fail(error, status, "out of memory");
  for (place at = {0, 0}; at.draw < count && status == ASC_OK;) {
    const place start = at;
    size_t filled = 0;
    while (at.draw < count && filled < work.capacity && status == ASC_OK) {
      const place here = at;
      const asc_draw *draw = &draws[here.draw];
      const size_t taken = advance(&at, draws, work.capacity - filled);
      status = fill(self, group, draw, here.done, taken, work.pixels + filled, work.points + filled * self->dimensions,
                    error);
      filled += taken;
    }
    if (status || filled == 0) break;
    status = integrand(context, filled, work.pixels, work.points, work.values);
    if (status)
      (void)asc_fail(error, status, "the integrand failed");
    else
      status = hand_out(self, group, draws, start, &work, filled, error);
  }
  batch_free(&work);
  return status;
}

asc_pixel asc_pixel_of(const asc_group *group, size_t number) {
  return (asc_pixel){group->x + (int32_t)(number % group->columns), group->y + (int32_t)(number / group->columns)};
}

void asc_write_tallies(asc_estimates *made, size_t pixel, uint32_t channels, const asc_tally *tallies, uint64_t spent) {
  for (uint32_t c = 0; c < channels; c++) {
    asc_moments_summary summary;
    (void)asc_moments_summarise(&tallies[c].moments, &summary);
    made->means[pixel * channels + c] = summary.mean;
    if (made->standard_errors) made->standard_errors[pixel * channels + c] = summary.standard_error;
  }
  if (made->degrees && tallies[0].moments.count > 1) made->degrees[pixel] = (double)tallies[0].moments.count - 1.0;
  if (made->counts) made->counts[pixel] = spent;
  made->spent += spent;
}

asc_status asc_prepare_fresh(asc_estimator *self, asc_error *error) {
  asc_sampler_desc desc;
  const asc_status status = asc_sampler_resolved(self->sampler, &desc);
  if (status) return status;
  if (!(asc_sampler_traits(self->sampler) & ASC_TRAIT_RANDOMISED))
    return asc_fail(error, ASC_UNSUPPORTED,
                    "%s: unbiased=1 needs a sampler that is randomised; %s has the same points for every seed",
                    self->interface->name, desc.spec);
  const uint64_t other = desc.seed ^ 0x9e3779b97f4a7c15u; /* samplers mix the seed's bits: any other will do */
  return asc_sampler_reseed(self->sampler, other, &self->fresh, error);
}

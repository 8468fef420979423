/* Corners of squares: a pixel is divided where the values at its corners differ, and so are its quarters.
 *
 * Whitted 1980, "An improved illumination model for shaded display", Communications of the ACM 23(6), section "Finding
 * the edges": the corners of a pixel are traced, which its neighbours share, so that a plain picture costs one sample a
 * pixel; where they differ the pixel is divided into four, whose corners are looked at in turn, down to `depth`. The
 * estimate is the sum over the squares of area times the mean of the four corners.
 *
 * Of a straight edge that crosses a pixel the corners always know: it has some of them on either side. What lies
 * between the corners they never see, a bright spot or the tip of a wedge. So every pixel begins as quarters here
 * (start=1), and a quarter is divided too where points of the quarters around it differ, those within `margin` times
 * its side. start=0, margin=0 is Whitted's own.
 *
 * Where samples lie: the corners of the smallest squares are a lattice, and each point of it is displaced within its
 * cell, half a step either way, by the sampler. Without it the lattice would alias, as Whitted's does, the seed would
 * mean nothing, and the sampler's further dimensions would have no point that they belong to. On average over the
 * displacements the estimate of a pixel that is divided all over is the integral with borders that are soft by half a
 * step. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "criterion_parameters.h"
#include "squares.h"

enum { UNBIASED = ASC_KEYS_OF_CRITERION, DEPTH, START, MARGIN };

static const asc_parameter parameters[] = {
    ASC_PARAMETERS_OF_CRITERION(ASC_BY_CONTRAST, 0.02),
    {"unbiased", ASC_INTEGER, NULL, 0, 1, 0,
     "1: the corners decide only, one fresh sample in each square is the estimate"},
    {"depth", ASC_INTEGER, NULL, 0, ASC_SQUARES_DEPTH_MOST, 4, "how often a pixel may be divided"},
    {"start", ASC_INTEGER, NULL, 0, ASC_SQUARES_DEPTH_MOST, 1, "how often every pixel is divided"},
    {"margin", ASC_REAL, NULL, 0, 1, 1,
     "how far around a first square the others' points count, in its sides; 0: not"}};

static uint64_t points_of(uint32_t level) { return ((1ull << level) + 1) * ((1ull << level) + 1); }

static uint32_t ring_of(const double *values) { return values[MARGIN] > 0.0 ? 1 : 0; }

/* Corners lie on the border, and a displaced one past it. */
static uint32_t reach(const double *values) { return 1 + ring_of(values); }

static asc_status prepare(asc_estimator *self, asc_error *error) {
  const uint32_t depth = (uint32_t)self->values[DEPTH], start = (uint32_t)self->values[START];
  const int unbiased = self->values[UNBIASED] > 0.0;
  const uint64_t most = unbiased ? self->samples / 2 : self->samples;
  if (start > depth) return asc_fail(error, ASC_INVALID_VALUE, "whitted: start=%u is more than depth=%u", start, depth);
  if (points_of(start) > most)
    return asc_fail(
        error, ASC_INVALID_VALUE, "whitted: start=%u takes %llu samples, more than the %llu that a pixel has%s", start,
        (unsigned long long)points_of(start), (unsigned long long)most, unbiased ? " for the decision" : "");
  self->criterion = asc_criterion_of(self->values);
  const asc_status status = asc_criterion_make(&self->criterion, 4);
  if (status) return asc_fail(error, status, "whitted: %s", asc_status_text(status));
  return unbiased ? asc_prepare_fresh(self, error) : ASC_OK;
}

static void add(const asc_squares *of, asc_tally *to, const double *values) {
  if (asc_criterion_has_moments(&of->self->criterion))
    asc_tally_add_known(to, of->self->channels, values);
  else
    asc_tally_add_extent(to, of->self->channels, values);
}

/* Adds the points of the first lattice within the margin of a square. */
static void gather(const asc_squares *of, const asc_square *square, double margin, asc_tally *to) {
  const int64_t side = (int64_t)1 << (of->depth - square->level);
  const int64_t step = (int64_t)1 << (of->depth - (uint32_t)of->self->values[START]);
  const int64_t far = (int64_t)(margin * (double)side);
  /* The first multiples of the step that are not before the frame; it begins at most a pixel before the pixel. */
  const int64_t past = (int64_t)1 << of->depth;
  const int64_t left = (square->x - far + past + step - 1) / step * step - past;
  const int64_t top = (square->y - far + past + step - 1) / step * step - past;
  for (int64_t y = top; y <= square->y + side + far; y += step)
    for (int64_t x = left; x <= square->x + side + far; x += step)
      add(of, to, asc_squares_around(of, square->pixel, x, y));
}

/* Whether the four corners are alike, and those around them. */
static int ask(const asc_squares *of, const asc_square *square) {
  const uint32_t channels = of->self->channels;
  const double margin = of->self->values[MARGIN];
  asc_tally tallies[ASC_CHANNELS_MOST];
  memset(tallies, 0, channels * sizeof *tallies);
  for (int corner = 0; corner < 4; corner++) add(of, tallies, asc_squares_corner(of, square, corner));
  if (!asc_criterion_satisfied(&of->self->criterion, channels, tallies)) return 0;
  /* Later squares are smaller than these points are apart. */
  if (margin == 0.0 || square->level > (uint32_t)of->self->values[START]) return 1;
  gather(of, square, margin, tallies);
  return asc_criterion_satisfied(&of->self->criterion, channels, tallies);
}

/* One decision of every square that was new; those that are made by it are asked in the next round. */
static asc_status decide(asc_squares *of, uint32_t first, uint32_t past, uint64_t most) {
  for (uint32_t i = first; i < past; i++) {
    if (of->squares[i].level == of->depth || ask(of, &of->squares[i])) continue;
    const asc_status status = asc_squares_divide(of, i, most);
    if (status) return status;
  }
  return ASC_OK;
}

/* The number of a pixel of the group in the larger area. */
static uint32_t place_of(const asc_squares *of, uint32_t number) {
  const uint32_t columns = of->area.columns - 2 * of->ring;
  return (number / columns + of->ring) * of->area.columns + number % columns + of->ring;
}

static uint32_t pixels_of(const asc_squares *of) {
  return (of->area.columns - 2 * of->ring) * (of->area.rows - 2 * of->ring);
}

/* The pixels as squares, divided `start` times, and as many points in those around. */
static asc_status begin(asc_squares *of, uint32_t start) {
  asc_status status = ASC_OK;
  for (uint32_t i = 0; i < pixels_of(of) && status == ASC_OK; i++) status = asc_squares_add_pixel(of, place_of(of, i));
  uint32_t first = 0;
  for (uint32_t level = 0; level < start && status == ASC_OK; level++) {
    const uint32_t past = of->count;
    for (uint32_t i = first; i < past && status == ASC_OK; i++) status = asc_squares_divide(of, i, UINT64_MAX);
    first = past;
  }
  for (uint32_t i = 0; of->ring && i < of->area.columns * of->area.rows && status == ASC_OK; i++)
    status = asc_squares_add_points(of, i, start);
  return status;
}

/* Adds a square's part of its pixel: its area times its values' distance from the pixel's first corner. */
static void add_square(const asc_squares *of, const asc_square *square, const double *fresh, double *mean) {
  const double *origin = asc_squares_origin(of, square->pixel);
  const double area = ldexp(1.0, -2 * (int)square->level);
  for (uint32_t c = 0; c < of->self->channels; c++) {
    double value = 0.0;
    if (fresh)
      value = fresh[c] - origin[c];
    else
      for (int corner = 0; corner < 4; corner++)
        value += 0.25 * (asc_squares_corner(of, square, corner)[c] - origin[c]);
    mean[c] += area * value;
  }
}

static void write(const asc_squares *of, const double *fresh, asc_estimates *made) {
  const uint32_t channels = of->self->channels, columns = of->area.columns - 2 * of->ring;
  for (uint32_t i = 0; i < pixels_of(of); i++) {
    memcpy(made->means + (size_t)i * channels, asc_squares_origin(of, place_of(of, i)), channels * sizeof(double));
    if (made->counts) made->counts[i] = of->spent[place_of(of, i)];
  }
  size_t leaf = 0;
  for (uint32_t i = 0; i < of->count; i++) {
    const asc_square *square = &of->squares[i];
    if (square->divided) continue;
    const uint32_t x = square->pixel % of->area.columns - of->ring, y = square->pixel / of->area.columns - of->ring;
    add_square(of, square, fresh ? fresh + channels * leaf++ : NULL,
               made->means + ((size_t)y * columns + x) * channels);
  }
}

/* One fresh sample in each square. */
static asc_status start_afresh(asc_squares *of, asc_integrand integrand, void *context, double **fresh, uint64_t *spent,
                               asc_error *error) {
  const size_t most = of->count;
  asc_draw *draws = calloc(most, sizeof *draws);
  *fresh = malloc(most * of->self->channels * sizeof **fresh);
  size_t count = 0;
  for (uint32_t i = 0; i < of->count && draws && *fresh; i++) {
    const asc_square *square = &of->squares[i];
    if (square->divided) continue;
    const double side = ldexp(1.0, -(int)square->level), step = ldexp(1.0, -(int)of->depth);
    draws[count] = (asc_draw){.pixel = asc_pixel_of(&of->area, square->pixel),
                              .first = asc_squares_index(of, square->x, square->y),
                              .count = 1,
                              .x = square->x * step,
                              .y = square->y * step,
                              .width = side,
                              .height = side,
                              .sampler = of->self->fresh,
                              .values = *fresh + of->self->channels * count};
    count++;
    of->spent[square->pixel]++;
  }
  *spent += count;
  const asc_status status = draws && *fresh ? asc_take(of->self, &of->group, draws, count, integrand, context, error)
                                            : asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  free(draws);
  return status;
}

static asc_status decide_all(asc_squares *of, asc_integrand integrand, void *context, uint64_t *spent,
                             asc_error *error) {
  const double *values = of->self->values;
  const uint64_t most = values[UNBIASED] > 0.0 ? of->self->samples / 2 : of->self->samples;
  asc_status status = begin(of, (uint32_t)values[START]);
  for (uint32_t first = 0; status == ASC_OK;) {
    status = asc_squares_take(of, integrand, context, spent, error);
    if (status) return status;
    const uint32_t past = of->count;
    if (first == past) return ASC_OK;
    while (first < past && of->squares[first].divided) first++; /* at the start */
    status = decide(of, first, past, most);
    first = past;
  }
  return asc_fail(error, status, "%s", asc_status_text(status));
}

static asc_status run(const asc_estimator *self, const asc_group *group, asc_integrand integrand, void *context,
                      asc_estimates *made, asc_error *error) {
  asc_squares squares;
  double *fresh = NULL;
  uint64_t spent = 0;
  asc_status status = asc_squares_make(&squares, self, group, ring_of(self->values), (uint32_t)self->values[DEPTH]);
  if (status)
    (void)asc_fail(error, status, "out of memory");
  else
    status = decide_all(&squares, integrand, context, &spent, error);
  if (status == ASC_OK && self->values[UNBIASED] > 0.0)
    status = start_afresh(&squares, integrand, context, &fresh, &spent, error);
  if (status == ASC_OK) {
    write(&squares, fresh, made);
    made->spent = spent;
  }
  free(fresh);
  asc_squares_free(&squares);
  return status;
}

const asc_estimator_interface asc_estimator_whitted = {
    .name = "whitted",
    .title = "pixels that are divided where their corners differ",
    .source = "Whitted 1980, An improved illumination model for shaded display",
    .parameters = parameters,
    .parameter_count = sizeof parameters / sizeof *parameters,
    .least_dimensions = 2,
    .reach = reach,
    .prepare = prepare,
    .run = run};

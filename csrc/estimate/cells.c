/* Deciding cell by cell. Each round decides on completed samples, all cells of the group side by side. */
#include "cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"

static uint64_t squared(uint32_t side) { return (uint64_t)side * side; }

/* How many samples may decide. As many fresh ones follow, and one for each cell in which none had fallen. */
static uint64_t deciding(const asc_estimator *self, const asc_cells *how) {
  if (!how->unbiased) return self->samples;
  const uint64_t kept = how->side > 1 ? squared(how->side) : 0;
  return self->samples > kept ? (self->samples - kept) / 2 : 0;
}

asc_status asc_cells_prepare(asc_estimator *self, const asc_cells *how, asc_error *error) {
  const char *name = self->interface->name;
  const uint64_t most = deciding(self, how);
  if (how->minimum > most)
    return asc_fail(error, ASC_INVALID_VALUE, "%s: minimum=%llu is more than the %llu samples that a pixel has%s", name,
                    (unsigned long long)how->minimum, (unsigned long long)most,
                    how->unbiased ? " for the decision" : "");
  if ((how->side > 1 || how->margin > 0.0 || how->refinement == ASC_BY_SPLITTING) && self->dimensions < 2)
    return asc_fail(error, ASC_UNSUPPORTED, "%s: cells and margins need the two dimensions of a pixel", name);
  const asc_status status = asc_criterion_make(&self->criterion, most);
  if (status) return asc_fail(error, status, "%s: %s", name, asc_status_text(status));
  return how->unbiased ? asc_prepare_fresh(self, error) : ASC_OK;
}

/* ---- The question ---- */

/* A cell grown by its margin, seen from the pixel (across, down) pixels away from its own. */
typedef struct frame {
  double left, right, top, bottom;
} frame;

static frame frame_of(const asc_cell *cell, double margin, int across, int down) {
  return (frame){cell->x - margin - across, cell->x + cell->side + margin - across, cell->y - margin - down,
                 cell->y + cell->side + margin - down};
}

/* Without a branch a comparison: which way each goes is chance. */
static int holds(const frame *within, const asc_field_sample *sample) {
  return (sample->x >= within->left) & (sample->x < within->right) & (sample->y >= within->top) &
         (sample->y < within->bottom);
}

/* What the samples around a cell came to. */
typedef struct around {
  const asc_field *of;
  const double *first; /* the first one's values; NULL: there is none */
  uint64_t count;
  int differ, moments;
  asc_tally tallies[ASC_CHANNELS_MOST]; /* from when they differ on */
} around;

static void add_one(around *to, const double *values) {
  if (to->moments)
    asc_tally_add_known(to->tallies, to->of->self->channels, values);
  else
    asc_tally_add_extent(to->tallies, to->of->self->channels, values);
}

static void add_around(around *to, const double *values) {
  const uint32_t channels = to->of->self->channels;
  to->count++;
  if (!to->first) to->first = values;
  if (!to->differ) {
    for (uint32_t c = 0; c < channels; c++) to->differ |= values[c] != to->first[c];
    if (!to->differ) return; /* most cells end so, and need no tally */
    memset(to->tallies, 0, channels * sizeof *to->tallies);
    for (uint64_t i = 1; i < to->count; i++) add_one(to, to->first);
  }
  add_one(to, values);
}

/* Adds those samples of a pixel that lie in the frame, of its first `most`. */
static void gather(around *to, uint32_t pixel, const frame *within, uint32_t most) {
  const asc_field *of = to->of;
  uint32_t i = of->pixels[pixel].first_sample;
  for (uint32_t seen = 0; seen < most && i != ASC_FIELD_NONE; seen++, i = of->samples[i].next)
    if (holds(within, &of->samples[i])) add_around(to, of->values + (size_t)i * of->self->channels);
}

static void gather_around(around *to, const asc_cell *cell) {
  const asc_field *of = to->of;
  const uint32_t columns = of->area.columns;
  /* In cells that are open, the samples lie as densely as in the sequence so far. */
  const double margin = fmin(1.0, of->how->margin / sqrt((double)of->pixels[cell->pixel].index));
  for (int down = -1; down <= 1; down++)
    for (int across = -1; across <= 1; across++) {
      const int own = across == 0 && down == 0;
      const frame within = frame_of(cell, margin, across, down);
      if (within.left >= 1.0 || within.right <= 0.0 || within.top >= 1.0 || within.bottom <= 0.0) continue;
      const uint32_t pixel = (uint32_t)((int64_t)cell->pixel + down * (int64_t)columns + across);
      gather(to, pixel, &within, own ? UINT32_MAX : (uint32_t)of->how->minimum);
    }
}

/* Whether the criterion is satisfied by the cell's samples and those around it. Where it is, these stand for a cell
 * that has none of its own. */
static int ask_around(const asc_field *of, uint32_t number) {
  const asc_cell *cell = &of->cells[number];
  const uint32_t channels = of->self->channels;
  around found;
  found.of = of;
  found.first = NULL;
  found.count = 0;
  found.differ = 0;
  found.moments = cell->count == 0 || asc_criterion_has_moments(&of->self->criterion);
  gather_around(&found, cell);
  if (!found.first) return 0;
  if (!found.differ) {
    memset(found.tallies, 0, channels * sizeof *found.tallies);
    for (uint64_t i = 0; i < (found.count < 2 ? 1 : 2); i++) asc_tally_add_known(found.tallies, channels, found.first);
  }
  const int enough = asc_criterion_satisfied(&of->self->criterion, channels, found.tallies);
  if (enough && cell->count == 0)
    memcpy(of->tallies + (size_t)number * channels, found.tallies, channels * sizeof *found.tallies);
  return enough;
}

static int ask(const asc_field *of, uint32_t number) {
  const asc_cell *cell = &of->cells[number];
  const int alone = of->reach == 0;
  /* One sample says nothing of its cell's variance; with those around it, it does. */
  if ((alone || cell->count > 1) && !asc_criterion_satisfied(&of->self->criterion, of->self->channels,
                                                             of->tallies + (size_t)number * of->self->channels))
    return 0;
  return alone || ask_around(of, number);
}

/* ---- The rounds ---- */

/* The first samples of all pixels, those around the group too, each as one cell. */
static asc_status begin(asc_field *of) {
  for (uint32_t pixel = 0; pixel < of->area.columns * of->area.rows; pixel++) {
    asc_status status = asc_field_add_cell(of, pixel, 0.0, 0.0, 1.0, 0);
    if (status == ASC_OK) status = asc_field_wish(of, pixel, of->how->minimum, UINT64_MAX);
    if (status) return status;
  }
  return ASC_OK;
}

/* Whether all first samples of two pixels are the same value. */
static int are_alike(const asc_field *of, uint32_t pixel, uint32_t other) {
  const uint32_t channels = of->self->channels;
  const asc_tally *own = of->tallies + (size_t)pixel * channels, *its = of->tallies + (size_t)other * channels;
  for (uint32_t c = 0; c < channels; c++)
    if (own[c].least != its[c].least || its[c].least != its[c].greatest) return 0;
  return 1;
}

/* A pixel in whose neighbourhood nothing differs needs no further question, and most of a picture are such; of any
 * other the cells are made. */
static asc_status make_cells(asc_field *of, uint32_t pixel) {
  const uint32_t columns = of->area.columns;
  int flat = of->reach > 0;
  for (uint32_t i = 0; i < 9 && flat; i++) flat = are_alike(of, pixel, pixel + (i / 3) * columns + i % 3 - columns - 1);
  if (!flat) return of->how->side > 1 ? asc_field_divide(of, pixel, of->how->side) : ASC_OK;
  of->cells[pixel].decided = 1;
  return ASC_OK;
}

/* What becomes of an open cell: decided, split, or left as it is for more samples. */
static asc_status look_at(asc_field *of, uint32_t number) {
  const int enough = ask(of, number);
  asc_cell *cell = &of->cells[number];
  if (enough) cell->decided = 1;
  const int splits = of->how->refinement == ASC_BY_SPLITTING && cell->level <= of->how->depth;
  if (enough || !splits || cell->count < of->how->node || !asc_field_all_meet(of, number, 2)) return ASC_OK;
  return asc_field_divide(of, number, 2);
}

/* Samples of a pixel's sequence, those that are skipped too: where a sampler never meets an open cell. */
#define INDEX_MOST(samples) (1024 * (samples))

/* Where the pixel's sequence stops next. */
static uint64_t next_stop(const asc_field *of, uint32_t pixel, uint64_t most) {
  const asc_cells *how = of->how;
  const uint64_t index = of->pixels[pixel].index, end = INDEX_MOST(most);
  uint64_t step = how->batch * squared(how->side);
  if (how->refinement == ASC_BY_SPLITTING) step = index;
  if (how->refinement == ASC_ALL_AT_ONCE) return most;
  return end - index < step ? end : index + step;
}

/* A round of one pixel. */
static asc_status go_on(asc_field *of, uint32_t pixel, uint64_t most) {
  const asc_field_pixel *from = &of->pixels[pixel];
  if (from->spent >= most || from->index >= INDEX_MOST(most)) return ASC_OK;
  if (of->how->refinement == ASC_ALL_AT_ONCE && from->index > of->how->minimum) return ASC_OK;
  int open = 0;
  /* Cells that are made here are looked at in this round too. */
  for (uint32_t i = from->first_cell; i != ASC_FIELD_NONE; i = of->cells[i].next) {
    if (of->cells[i].decided) continue;
    const asc_status status = look_at(of, i);
    if (status) return status;
    open |= !of->cells[i].decided;
  }
  if (!open) return ASC_OK;
  return asc_field_wish(of, pixel, next_stop(of, pixel, most), most);
}

/* The number of a pixel of the group in the larger area. */
static uint32_t place_of(const asc_field *of, const asc_group *group, uint32_t number) {
  return (number / group->columns + of->reach) * of->area.columns + number % group->columns + of->reach;
}

static asc_status make_all_cells(asc_field *of, const asc_group *group) {
  asc_status status = ASC_OK;
  for (uint32_t i = 0; i < group->columns * group->rows && status == ASC_OK; i++)
    status = make_cells(of, place_of(of, group, i));
  return status;
}

/* One round of every pixel of the group. */
static asc_status decide(asc_field *of, const asc_group *group, uint64_t most) {
  asc_status status = ASC_OK;
  for (uint32_t i = 0; i < group->columns * group->rows && status == ASC_OK; i++)
    status = go_on(of, place_of(of, group, i), most);
  return status;
}

static uint64_t power_of_two(uint64_t least) {
  uint64_t power = 1;
  while (power < least) power *= 2;
  return power;
}

/* As many fresh samples in every cell, in place of those that decided. */
static asc_status start_afresh(asc_field *of, const asc_group *group, asc_integrand integrand, void *context,
                               uint64_t *spent, asc_error *error) {
  const uint32_t channels = of->self->channels;
  asc_draw *draws = calloc(of->cell_count, sizeof *draws);
  if (!draws) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  size_t count = 0;
  for (uint32_t i = 0; i < of->area.columns * of->area.rows; i++) of->pixels[i].index = 0;
  for (uint32_t i = 0; i < of->cell_count; i++) {
    asc_cell *cell = &of->cells[i];
    const asc_pixel at = asc_pixel_of(&of->area, cell->pixel);
    if (cell->parts || at.x < group->x || at.y < group->y || at.x - group->x >= (int64_t)group->columns ||
        at.y - group->y >= (int64_t)group->rows)
      continue;
    for (uint32_t c = 0; c < channels; c++) of->tallies[(size_t)i * channels + c] = (asc_tally){.least = 0.0};
    asc_field_pixel *owner = &of->pixels[cell->pixel];
    if (cell->count == 0) cell->count = 1;
    const uint64_t fresh = cell->count;
    draws[count++] = (asc_draw){.pixel = at,
                                .first = owner->index,
                                .count = fresh,
                                .x = cell->x,
                                .y = cell->y,
                                .width = cell->side < 1.0 ? cell->side : 0.0,
                                .height = cell->side,
                                .sampler = of->self->fresh,
                                .to = of->tallies + (size_t)i * channels};
    owner->index += power_of_two(fresh); /* so that of a net each cell has a net */
    owner->spent += fresh;
    *spent += fresh;
  }
  const asc_status status = asc_take(of->self, group, draws, count, integrand, context, error);
  free(draws);
  return status;
}

/* ---- The outcome ---- */

/* Each cell's mean by its area; a cell without any, in or around it, counts for nothing. The standard error is that of
 * a stratified estimate with independent samples in the cells, sum of area^2 variance / count; none where a cell has
 * one sample. */
static void write_pixel(const asc_field *of, uint32_t pixel, size_t number, asc_estimates *made) {
  const uint32_t channels = of->self->channels;
  const asc_field_pixel *from = &of->pixels[pixel];
  if (from->first_cell == from->last_cell) {
    asc_write_tallies(made, number, channels, of->tallies + (size_t)from->first_cell * channels, from->spent);
    return;
  }
  for (uint32_t c = 0; c < channels; c++) {
    double origin = 0.0, sum = 0.0, areas = 0.0, variance = 0.0;
    for (uint32_t i = from->first_cell; i != ASC_FIELD_NONE; i = of->cells[i].next) {
      const asc_cell *cell = &of->cells[i];
      if (cell->parts) continue;
      asc_moments_summary own;
      (void)asc_moments_summarise(&of->tallies[(size_t)i * channels + c].moments, &own);
      if (own.count == 0) continue;
      const double area = cell->side * cell->side;
      if (areas == 0.0) origin = own.mean; /* from which differences are summed: a plain pixel has its value exactly */
      sum += area * (own.mean - origin);
      areas += area;
      variance += area * area * own.standard_error * own.standard_error;
    }
    made->means[number * channels + c] = origin + sum / areas;
    if (made->standard_errors) made->standard_errors[number * channels + c] = sqrt(variance) / areas;
  }
  if (made->counts) made->counts[number] = from->spent;
}

static asc_status fail(const asc_field *of, asc_status status, asc_error *error) {
  return asc_fail(error, status, "%s", of->failure.text[0] ? of->failure.text : asc_status_text(status));
}

static asc_status run(asc_field *of, const asc_group *group, asc_integrand integrand, void *context,
                      asc_estimates *made, asc_error *error) {
  const uint64_t most = deciding(of->self, of->how);
  uint64_t spent = 0;
  asc_status status = begin(of);
  if (status) return fail(of, status, error);
  for (int first = 1; of->asked; first = 0) {
    status = asc_field_take(of, integrand, context, &spent, error);
    if (status) return status;
    status = first ? make_all_cells(of, group) : ASC_OK;
    if (status == ASC_OK) status = decide(of, group, most);
    if (status) return fail(of, status, error);
  }
  if (of->how->unbiased) status = start_afresh(of, group, integrand, context, &spent, error);
  if (status) return status;
  for (uint32_t i = 0; i < group->columns * group->rows; i++) write_pixel(of, place_of(of, group, i), i, made);
  made->spent = spent;
  return ASC_OK;
}

asc_status asc_cells_run(const asc_estimator *self, const asc_cells *how, const asc_group *group,
                         asc_integrand integrand, void *context, asc_estimates *made, asc_error *error) {
  asc_field field;
  asc_status status = asc_field_make(&field, self, how, group);
  if (status)
    (void)asc_fail(error, status, "out of memory");
  else
    status = run(&field, group, integrand, context, made, error);
  asc_field_free(&field);
  return status;
}

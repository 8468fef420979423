/* Keeping the samples and cells of a group. */
#include "field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

asc_status asc_field_make(asc_field *made, const asc_estimator *self, const asc_cells *how, const asc_group *group) {
  const uint32_t reach = asc_cells_reach(how->margin);
  const int32_t out = (int32_t)reach;
  *made = (asc_field){.self = self, .how = how, .group = *group, .reach = reach};
  made->area = (asc_group){group->x - out, group->y - out, group->columns + 2 * reach, group->rows + 2 * reach};
  made->keeps = reach > 0 || how->side > 1 || how->refinement == ASC_BY_SPLITTING;
  const size_t pixels = (size_t)made->area.columns * made->area.rows;
  made->pixels = calloc(pixels, sizeof *made->pixels);
  if (!made->pixels) return ASC_OUT_OF_MEMORY;
  for (size_t i = 0; i < pixels; i++)
    made->pixels[i].first_cell = made->pixels[i].last_cell = made->pixels[i].first_sample =
        made->pixels[i].last_sample = ASC_FIELD_NONE;
  return ASC_OK;
}

void asc_field_free(asc_field *made) {
  free(made->pixels);
  free(made->cells);
  free(made->tallies);
  free(made->samples);
  free(made->values);
  free(made->wished_pixels);
  free(made->wished_points);
  free(made->wished_cells);
}

/* Room for `count` entries of `size` bytes: twice as many as before. */
static int grow(void **array, uint32_t capacity, size_t size) {
  void *larger = realloc(*array, (size_t)capacity * size);
  if (larger) *array = larger;
  return larger != NULL;
}

static uint32_t larger_than(uint32_t capacity, uint64_t wanted) {
  uint64_t larger = capacity ? capacity : 256;
  while (larger < wanted) larger *= 2;
  return larger < ASC_FIELD_NONE ? (uint32_t)larger : 0;
}

asc_status asc_field_add_cell(asc_field *to, uint32_t pixel, double x, double y, double side, uint32_t level) {
  if (to->cell_count == to->cell_capacity) {
    const uint32_t capacity = larger_than(to->cell_capacity, (uint64_t)to->cell_count + 1);
    if (!capacity || !grow((void **)&to->cells, capacity, sizeof *to->cells) ||
        !grow((void **)&to->tallies, capacity, to->self->channels * sizeof *to->tallies))
      return ASC_OUT_OF_MEMORY;
    to->cell_capacity = capacity;
  }
  asc_field_pixel *owner = &to->pixels[pixel];
  const uint32_t number = to->cell_count++;
  to->cells[number] = (asc_cell){.x = x, .y = y, .side = side, .pixel = pixel, .next = ASC_FIELD_NONE, .level = level};
  memset(to->tallies + (size_t)number * to->self->channels, 0, to->self->channels * sizeof *to->tallies);
  if (owner->last_cell == ASC_FIELD_NONE)
    owner->first_cell = number;
  else
    to->cells[owner->last_cell].next = number;
  owner->last_cell = number;
  return ASC_OK;
}

/* ---- Asking for samples ---- */

static asc_status room_for_wishes(asc_field *of, uint64_t more) {
  const uint64_t wanted = of->wish_count + more;
  if (wanted <= of->wish_capacity) return ASC_OK;
  const uint32_t capacity = larger_than(of->wish_capacity, wanted);
  if (!capacity || !grow((void **)&of->wished_pixels, capacity, sizeof *of->wished_pixels) ||
      !grow((void **)&of->wished_points, capacity, of->self->dimensions * sizeof *of->wished_points) ||
      !grow((void **)&of->wished_cells, capacity, sizeof *of->wished_cells))
    return ASC_OUT_OF_MEMORY;
  of->wish_capacity = capacity;
  return ASC_OK;
}

/* Which part of a cell holds a point. */
static uint32_t part_at(const asc_cell *whole, uint32_t parts, double x, double y) {
  const double scale = parts / whole->side;
  const uint32_t column = (uint32_t)((x - whole->x) * scale), row = (uint32_t)((y - whole->y) * scale);
  /* Rounding may lift a point at the border by one. */
  return (column < parts ? column : parts - 1) + parts * (row < parts ? row : parts - 1);
}

/* The number of the cell that holds a point. */
static uint32_t cell_at(const asc_field *of, uint32_t pixel, const double *point) {
  uint32_t cell = of->pixels[pixel].first_cell;
  while (of->cells[cell].parts) {
    const asc_cell *whole = &of->cells[cell];
    cell = whole->first_part + part_at(whole, whole->parts, point[0], point[1]);
  }
  return cell;
}

asc_status asc_field_wish(asc_field *of, uint32_t pixel, uint64_t end, uint64_t most) {
  enum { CHUNK = 256 }; /* as most of them may be skipped */
  asc_field_pixel *from = &of->pixels[pixel];
  const asc_pixel at = asc_pixel_of(&of->area, pixel);
  const uint32_t dimensions = of->self->dimensions;
  of->asked = 1;
  while (from->index < end && from->spent < most) {
    const uint64_t left = end - from->index;
    const asc_range range = {at.x, at.y, from->index, left < CHUNK ? (size_t)left : CHUNK, 0, dimensions};
    asc_status status = room_for_wishes(of, range.sample_count);
    if (status) return status;
    double *points = of->wished_points + (size_t)of->wish_count * dimensions;
    status = asc_sampler_fill(of->self->sampler, &range, points);
    if (status) return asc_fail_samples(of->self->sampler, &of->group, &range, points, status, &of->failure);
    for (size_t i = 0; i < range.sample_count && from->spent < most; i++) {
      const double *point = points + i * dimensions;
      const uint32_t cell = cell_at(of, pixel, point);
      if (of->cells[cell].decided) continue;
      memmove(of->wished_points + (size_t)of->wish_count * dimensions, point, dimensions * sizeof *point);
      of->wished_cells[of->wish_count] = cell;
      of->wished_pixels[of->wish_count++] = at;
      from->spent++;
    }
    from->index += range.sample_count;
  }
  return ASC_OK;
}

static asc_status room_for_samples(asc_field *of, uint64_t more) {
  const uint64_t wanted = of->sample_count + more;
  if (wanted <= of->sample_capacity) return ASC_OK;
  const uint32_t capacity = larger_than(of->sample_capacity, wanted);
  if (!capacity || !grow((void **)&of->samples, capacity, sizeof *of->samples) ||
      !grow((void **)&of->values, capacity, of->self->channels * sizeof *of->values))
    return ASC_OUT_OF_MEMORY;
  of->sample_capacity = capacity;
  return ASC_OK;
}

/* Keeps a sample in its pixel's list. */
static void keep(asc_field *of, uint32_t wished, const double *values) {
  const uint32_t cell = of->wished_cells[wished], number = of->sample_count++, channels = of->self->channels;
  const double *point = of->wished_points + (size_t)wished * of->self->dimensions;
  asc_field_pixel *owner = &of->pixels[of->cells[cell].pixel];
  of->samples[number] = (asc_field_sample){point[0], point[1], cell, ASC_FIELD_NONE};
  memcpy(of->values + (size_t)number * channels, values, channels * sizeof *values);
  if (owner->last_sample == ASC_FIELD_NONE)
    owner->first_sample = number;
  else
    of->samples[owner->last_sample].next = number;
  owner->last_sample = number;
}

/* Asks the integrand about wishes [first, first + count), and adds what it says. */
static asc_status take_some(asc_field *of, uint32_t first, uint32_t count, asc_integrand integrand, void *context,
                            double *values, asc_error *error) {
  const uint32_t channels = of->self->channels;
  const asc_status status = integrand(context, count, of->wished_pixels + first,
                                      of->wished_points + (size_t)first * of->self->dimensions, values);
  if (status) return asc_fail(error, status, "the integrand failed");
  for (uint32_t i = 0; i < count; i++) {
    const uint32_t cell = of->wished_cells[first + i];
    const double *value = values + (size_t)i * channels;
    asc_tally *tally = of->tallies + (size_t)cell * channels;
    asc_tally_add_known(tally, channels, value);
    for (uint32_t c = 0; c < channels; c++)
      if (!isfinite(tally[c].moments.squares))
        return asc_fail_value(of->self, &of->group, of->wished_pixels[first + i],
                              of->wished_points + (size_t)(first + i) * of->self->dimensions, value, ASC_NUMERIC,
                              error);
    of->cells[cell].count++;
    if (of->keeps) keep(of, first + i, value);
  }
  return ASC_OK;
}

#define AT_ONCE 8192u /* samples of one call of the integrand: whole packets of a tracer */

asc_status asc_field_take(asc_field *of, asc_integrand integrand, void *context, uint64_t *spent, asc_error *error) {
  const uint32_t all = of->wish_count;
  double *values = malloc((size_t)(all < AT_ONCE ? all + 1 : AT_ONCE) * of->self->channels * sizeof *values);
  asc_status status = values ? ASC_OK : ASC_OUT_OF_MEMORY;
  if (status == ASC_OK && of->keeps) status = room_for_samples(of, all);
  if (status) (void)asc_fail(error, status, "out of memory");
  for (uint32_t done = 0; done < all && status == ASC_OK; done += AT_ONCE)
    status = take_some(of, done, all - done < AT_ONCE ? all - done : AT_ONCE, integrand, context, values, error);
  free(values);
  of->wish_count = 0;
  of->asked = 0;
  *spent += all;
  return status;
}

int asc_field_all_meet(const asc_field *of, uint32_t cell, uint32_t parts) {
  const asc_cell *whole = &of->cells[cell];
  unsigned met = 0;
  for (uint32_t i = of->pixels[whole->pixel].first_sample; i != ASC_FIELD_NONE; i = of->samples[i].next)
    if (of->samples[i].cell == cell) met |= 1u << part_at(whole, parts, of->samples[i].x, of->samples[i].y);
  return met == (1u << (parts * parts)) - 1;
}

asc_status asc_field_divide(asc_field *of, uint32_t cell, uint32_t parts) {
  const asc_cell whole = of->cells[cell];
  const uint32_t channels = of->self->channels, first = of->cell_count;
  const double side = whole.side / parts;
  for (uint32_t i = 0; i < parts * parts; i++) {
    const uint32_t column = i % parts, row = i / parts;
    if (asc_field_add_cell(of, whole.pixel, whole.x + column * side, whole.y + row * side, side, whole.level + 1))
      return ASC_OUT_OF_MEMORY;
  }
  of->cells[cell].parts = parts;
  of->cells[cell].first_part = first;
  of->cells[cell].decided = 1;
  for (uint32_t i = of->pixels[whole.pixel].first_sample; i != ASC_FIELD_NONE; i = of->samples[i].next) {
    asc_field_sample *sample = &of->samples[i];
    if (sample->cell != cell) continue;
    sample->cell = first + part_at(&whole, parts, sample->x, sample->y);
    of->cells[sample->cell].count++;
    asc_tally_add_known(of->tallies + (size_t)sample->cell * channels, channels, of->values + (size_t)i * channels);
  }
  return ASC_OK;
}

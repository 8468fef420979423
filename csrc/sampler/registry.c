/* The samplers there are: the built-in ones and those of plugins, through the same tables. */
#include <dlfcn.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "made.h"
#include "pattern.h"
#include "remote.h"
#include "vectorise.h"

/* One line a pattern. */
/* clang-format off */
#define BUILT_IN_SAMPLERS(X) \
  X(random) \
  X(regular) \
  X(jittered) \
  X(halton) \
  X(sobol) \
  X(sgi_8x8) \
  X(standard_msaa) \
  X(gauss_legendre) \
  X(clenshaw_curtis) \
  X(cook) \
  X(pan_diagonal) \
  X(mitchell_spacetime) \
  X(zaremba) \
  X(larcher_pillichshammer) \
  X(pmj02) \
  X(r2) \
  X(lattice) \
  X(latin_square) \
  X(n_queens) \
  X(multi_jittered) \
  X(correlated_multi_jittered) \
  X(orthogonal_array) \
  X(hammersley) \
  X(n_rooks) \
  X(poisson_disk) \
  X(best_candidate) \
  X(blue_noise) \
  /* end of the list */
/* clang-format on */

#define DECLARE(name) extern const asc_sampler_interface asc_sampler_##name;
BUILT_IN_SAMPLERS(DECLARE)

#define MOST_PARAMETERS ASC_REMOTE_PARAMETERS
#define MOST_PLUGINS 64

#define ADDRESS(name) &asc_sampler_##name,
static const asc_sampler_interface *const built_in[] = {BUILT_IN_SAMPLERS(ADDRESS)};
#define BUILT_IN_COUNT (sizeof built_in / sizeof *built_in)

static const asc_sampler_interface *plugged_in[MOST_PLUGINS];
static size_t plugged_in_count;

size_t asc_sampler_count(void) { return BUILT_IN_COUNT + plugged_in_count; }

static const asc_sampler_interface *interface_at(size_t index) {
  return index < BUILT_IN_COUNT ? built_in[index] : plugged_in[index - BUILT_IN_COUNT];
}

asc_status asc_sampler_describe(size_t index, asc_sampler_info *info) {
  if (!info || index >= asc_sampler_count()) return ASC_INVALID_ARGUMENT;
  const asc_sampler_interface *interface = interface_at(index);
  *info = (asc_sampler_info){interface->name,       interface->title,           interface->source,
                             interface->parameters, interface->parameter_count, index >= BUILT_IN_COUNT};
  return ASC_OK;
}

static const asc_sampler_interface *find(const char *name) {
  for (size_t i = 0; i < asc_sampler_count(); i++)
    if (strcmp(interface_at(i)->name, name) == 0) return interface_at(i);
  return NULL;
}

static asc_status unknown_name(const char *name, asc_error *error) {
  const char *names[BUILT_IN_COUNT + MOST_PLUGINS];
  for (size_t i = 0; i < asc_sampler_count(); i++) names[i] = interface_at(i)->name;
  return asc_spec_unknown("sampler", name, names, asc_sampler_count(), error);
}

/* Fills in interface, spec and the resolved numbers; `values` gets the spec's. */
static asc_status resolve(asc_sampler *sampler, const asc_sampler_desc *desc, double values[MOST_PARAMETERS],
                          asc_error *error) {
  char name[ASC_SPEC_LENGTH];
  asc_status status = asc_spec_name(desc->spec, "sampler", name, error);
  if (status) return status;
  sampler->interface = find(name);
  if (!sampler->interface) return unknown_name(name, error);
  const asc_spec_form form = {"sampler", name, sampler->interface->parameters, sampler->interface->parameter_count};
  status = asc_spec_values(desc->spec, &form, values, error);
  if (status) return status;
  status = asc_spec_canonical(&form, values, sampler->spec);
  if (status) return asc_fail(error, status, "out of memory");
  sampler->resolved = (asc_sampler_desc){sizeof sampler->resolved, sampler->spec, desc->samples ? desc->samples : 1,
                                         desc->dimensions ? desc->dimensions : 2, desc->seed};
  if (sampler->resolved.samples > ASC_SEQUENCE_END)
    return asc_fail(error, ASC_UNSUPPORTED, "%s: at most 2^53 points", name);
  return ASC_OK;
}

asc_status asc_sampler_create(const asc_sampler_desc *desc, asc_sampler **sampler, asc_error *error) {
  if (!desc || desc->struct_size != sizeof *desc || !desc->spec || !sampler)
    return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_sampler_create: desc needs its struct_size and a spec");
  *sampler = NULL;
  asc_sampler *made = calloc(1, sizeof *made);
  if (!made) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  double values[MOST_PARAMETERS];
  asc_status status = resolve(made, desc, values, error);
  if (status == ASC_OK) {
    const asc_sampler_config config = {sizeof config, made->resolved.samples, made->resolved.dimensions,
                                       made->resolved.seed, values};
    const int remote = asc_is_remote(made->interface);
    status = remote ? asc_remote_create(made->interface, &config, &made->made, error)
                    : made->interface->create(&config, &made->made, error);
    made->made.traits &= ~(uint32_t)ASC_TRAIT_DISTANT;
    if (remote) made->made.traits |= ASC_TRAIT_DISTANT;
  }
  if (status) {
    free(made);
    return status;
  }
  *sampler = made;
  return ASC_OK;
}

void asc_sampler_destroy(asc_sampler *sampler) {
  if (!sampler) return;
  sampler->interface->destroy(sampler->made.state);
  free(sampler);
}

asc_status asc_sampler_resolved(const asc_sampler *sampler, asc_sampler_desc *desc) {
  if (!sampler || !desc) return ASC_INVALID_ARGUMENT;
  *desc = sampler->resolved;
  return ASC_OK;
}

uint32_t asc_sampler_traits(const asc_sampler *sampler) { return sampler ? sampler->made.traits : 0; }

/* Within the sampler's end, without overflow. */
static int holds(const asc_sampler *sampler, uint64_t first, size_t count) {
  return first <= sampler->made.index_end && count <= sampler->made.index_end - first;
}

#define LAST_BELOW 0x3fefffffefffffffu /* the bits of the double before 1 - 2^-25 */

/* Moves what would round to 1 as float. What is outside stays as it is, to be told. */
static asc_status move_below_one(double *points, size_t count) {
  int outside = 0;
  for (size_t i = 0; i < count; i++) {
    outside |= !(points[i] >= 0.0 && points[i] < 1.0);
    points[i] = points[i] >= 1.0 - 0x1p-25 && points[i] < 1.0 ? 1.0 - 0x1p-24 : points[i];
  }
  return outside ? ASC_OUT_OF_RANGE : ASC_OK;
}

/* Nearly no value needs to be looked at closely: the bits of doubles in [0, 1 - 2^-25) are, as integers, those from 0
 * to below the bits of 1 - 2^-25, so that one of `bits` and `last - bits` is negative for every other double. */
ASC_VECTORISE
static int all_are_below(const double *points, size_t count) {
  int64_t signs = 0;
  for (size_t i = 0; i < count; i++) {
    int64_t bits;
    memcpy(&bits, &points[i], sizeof bits);
    signs |= bits | (int64_t)(LAST_BELOW - (uint64_t)bits);
  }
  return signs >= 0;
}

/* A few values were written a moment ago, one by one: read back as vectors, they would wait for the memory. */
static int few_are_below(const double *points, size_t count) {
  for (size_t i = 0; i < count; i++) {
    uint64_t bits;
    memcpy(&bits, &points[i], sizeof bits);
    if (bits > LAST_BELOW) return 0;
  }
  return 1;
}

static asc_status settle(double *points, size_t count) {
  const int below = count < 32 ? few_are_below(points, count) : all_are_below(points, count);
  return below ? ASC_OK : move_below_one(points, count);
}

#define LEAST_TABLE offsetof(asc_sampler_interface, fill_pixels) /* what every table has */

static asc_status fill_pixels(const asc_sampler_interface *interface, const void *state, const asc_range *range,
                              size_t pixels, double *points) {
  if (interface->struct_size > LEAST_TABLE && interface->fill_pixels)
    return interface->fill_pixels(state, range, pixels, points);
  asc_range one = *range;
  for (size_t i = 0; i < pixels; i++) {
    one.pixel_x = range->pixel_x + (int32_t)i;
    const asc_status status = interface->fill(state, &one, points + i * range->sample_count * range->dimension_count);
    if (status) return status;
  }
  return ASC_OK;
}

asc_status asc_fill_area_of(const asc_sampler_interface *interface, const void *state, const asc_range *range,
                            uint32_t columns, size_t first, size_t pixels, double *points) {
  asc_range part = *range;
  for (size_t done = 0, count; done < pixels; done += count) {
    const size_t column = (first + done) % columns;
    count = columns - column < pixels - done ? columns - column : pixels - done;
    part.pixel_x = range->pixel_x + (int32_t)column;
    part.pixel_y = range->pixel_y + (int32_t)((first + done) / columns);
    double *into = points + done * range->sample_count * range->dimension_count;
    const asc_status status = fill_pixels(interface, state, &part, count, into);
    if (status) return status;
  }
  return ASC_OK;
}

/* ASC_OK where the range is valid and there is something to fill. */
static asc_status check_range(const asc_sampler *sampler, const asc_range *range) {
  const uint32_t dimensions = sampler->resolved.dimensions;
  if (range->first_dimension > dimensions || range->dimension_count > dimensions - range->first_dimension)
    return ASC_INVALID_ARGUMENT;
  return holds(sampler, range->first_sample, range->sample_count) ? ASC_OK : ASC_UNSUPPORTED;
}

asc_status asc_sampler_fill(const asc_sampler *sampler, const asc_range *range, double *points) {
  if (!sampler || !range || !points) return ASC_INVALID_ARGUMENT;
  asc_status status = check_range(sampler, range);
  if (status || range->sample_count == 0 || range->dimension_count == 0) return status;
  status = sampler->interface->fill(sampler->made.state, range, points);
  if (status) return status;
  return settle(points, range->sample_count * range->dimension_count);
}

asc_status asc_sampler_fill_pixels(const asc_sampler *sampler, const asc_range *range, size_t pixels, double *points) {
  if (!sampler || !range || !points || (pixels > 0 && pixels - 1 > (size_t)(INT32_MAX - (int64_t)range->pixel_x)))
    return ASC_INVALID_ARGUMENT;
  asc_status status = check_range(sampler, range);
  if (status || pixels == 0 || range->sample_count == 0 || range->dimension_count == 0) return status;
  status = fill_pixels(sampler->interface, sampler->made.state, range, pixels, points);
  if (status) return status;
  return settle(points, pixels * range->sample_count * range->dimension_count);
}

/* Whether the pixels of an area have places. */
static int has_places(const asc_range *range, uint32_t columns, size_t first, size_t pixels) {
  const uint64_t right = (uint64_t)((int64_t)INT32_MAX - range->pixel_x);
  const uint64_t below = (uint64_t)((int64_t)INT32_MAX - range->pixel_y);
  return columns > 0 && columns - 1 <= right && first <= SIZE_MAX - pixels &&
         (pixels == 0 || (first + pixels - 1) / columns <= below);
}

asc_status asc_sampler_fill_area(const asc_sampler *sampler, const asc_range *range, uint32_t columns, size_t first,
                                 size_t pixels, double *points) {
  if (!sampler || !range || !points || !has_places(range, columns, first, pixels)) return ASC_INVALID_ARGUMENT;
  asc_status status = check_range(sampler, range);
  if (status || pixels == 0 || range->sample_count == 0 || range->dimension_count == 0) return status;
  const void *state = sampler->made.state;
  status = sampler->made.traits & ASC_TRAIT_DISTANT
               ? asc_remote_fill_area(state, range, columns, first, pixels, points)
               : asc_fill_area_of(sampler->interface, state, range, columns, first, pixels, points);
  if (status) return status;
  return settle(points, pixels * range->sample_count * range->dimension_count);
}

asc_status asc_sampler_weights(const asc_sampler *sampler, uint64_t first, size_t count, double *weights) {
  if (!sampler || !weights) return ASC_INVALID_ARGUMENT;
  if (!holds(sampler, first, count)) return ASC_UNSUPPORTED;
  if (sampler->interface->weights) {
    const asc_status status = sampler->interface->weights(sampler->made.state, first, count, weights);
    int finite = 1;
    for (size_t i = 0; status == ASC_OK && i < count; i++) finite &= isfinite(weights[i]) != 0;
    return finite ? status : ASC_NUMERIC;
  }
  for (size_t i = 0; i < count; i++) weights[i] = 1.0 / (double)sampler->resolved.samples;
  return ASC_OK;
}

static int is_kebab_case(const char *name) {
  const size_t length = strlen(name);
  return length > 0 && strspn(name, "abcdefghijklmnopqrstuvwxyz0123456789-") == length && name[0] != '-' &&
         name[length - 1] != '-';
}

static int is_in_range(const asc_parameter *parameter) {
  if (parameter->kind == ASC_CHOICE) {
    double words = 1.0;
    for (const char *each = parameter->choices; *each; each++) words += *each == '|';
    return parameter->fallback >= 0.0 && parameter->fallback < words &&
           floor(parameter->fallback) == parameter->fallback;
  }
  return isfinite(parameter->minimum) && isfinite(parameter->maximum) && parameter->minimum <= parameter->fallback &&
         parameter->fallback <= parameter->maximum;
}

static asc_status check_parameters(const asc_sampler_interface *table, const char *path, asc_error *error) {
  if (table->parameter_count > MOST_PARAMETERS || (table->parameter_count && !table->parameters))
    return asc_fail(error, ASC_PLUGIN, "%s: a sampler has at most %d parameters", path, MOST_PARAMETERS);
  for (size_t i = 0; i < table->parameter_count; i++) {
    const asc_parameter *parameter = &table->parameters[i];
    if (!parameter->name || !parameter->text || (parameter->kind == ASC_CHOICE) != (parameter->choices != NULL))
      return asc_fail(error, ASC_PLUGIN, "%s: parameter %zu lacks its name, text or choices", path, i);
    if (!is_kebab_case(parameter->name) || parameter->kind > ASC_CHOICE)
      return asc_fail(error, ASC_PLUGIN, "%s: the name of parameter %zu is not kebab-case, or its kind unknown", path,
                      i);
    if (!is_in_range(parameter))
      return asc_fail(error, ASC_PLUGIN, "%s: the default of parameter \"%s\" is not within its range", path,
                      parameter->name);
  }
  return ASC_OK;
}

static asc_status check_table(const asc_sampler_interface *table, const char *path, asc_error *error) {
  if (!table) {
    (void)asc_fail(error, ASC_PLUGIN, "%s: has no \"%s\" for ABI version %u: build it against this version's headers",
                   path, ASC_SAMPLER_INTERFACE_ID, ASC_ABI_VERSION);
    return ASC_PLUGIN;
  }
  if (table->struct_size < LEAST_TABLE || !table->name || !table->title || !table->source || !table->create ||
      !table->destroy || !table->fill)
    return asc_fail(error, ASC_PLUGIN, "%s: its table of functions is too short or has gaps", path);
  if (!is_kebab_case(table->name))
    return asc_fail(error, ASC_PLUGIN, "%s: the name of its sampler is not kebab-case", path);
  return check_parameters(table, path, error);
}

asc_status asc_register(const asc_sampler_interface *table, const char *path, asc_error *error) {
  asc_status status = check_table(table, path, error);
  if (status) return status;
  if (find(table->name))
    return asc_fail(error, ASC_PLUGIN, "%s: a sampler named \"%s\" is there already", path, table->name);
  if (plugged_in_count == MOST_PLUGINS)
    return asc_fail(error, ASC_PLUGIN, "%s: at most %d plugins can be loaded", path, MOST_PLUGINS);
  plugged_in[plugged_in_count++] = table;
  return ASC_OK;
}

static asc_status open_plugin(const char *path, void **library, const asc_sampler_interface **table, asc_error *error) {
  if (!path) return asc_fail(error, ASC_INVALID_ARGUMENT, "no path of a plugin");
  *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  /* NOLINTNEXTLINE(concurrency-mt-unsafe): plugins are loaded before threads, as plugin.h says */
  if (!*library) return asc_fail(error, ASC_PLUGIN, "%s: cannot be loaded: %s", path, dlerror());
  asc_plugin_interface_function function = NULL;
  void *symbol = dlsym(*library, "asc_plugin_interface");
  memcpy(&function, &symbol, sizeof function); /* ISO C has no cast from object to function pointer */
  if (!function) return asc_fail(error, ASC_PLUGIN, "%s: exports no asc_plugin_interface", path);
  *table = function(ASC_ABI_VERSION, ASC_SAMPLER_INTERFACE_ID);
  return check_table(*table, path, error);
}

asc_status asc_plugin_open(const char *path, const asc_sampler_interface **table, asc_error *error) {
  void *library = NULL;
  return open_plugin(path, &library, table, error);
}

asc_status asc_plugin_load(const char *path, asc_error *error) {
  void *library = NULL;
  const asc_sampler_interface *table = NULL;
  asc_status status = open_plugin(path, &library, &table, error);
  if (status == ASC_OK) status = asc_register(table, path, error);
  if (status && library) (void)dlclose(library);
  return status;
}

/* The interface between the library and a sampler, built-in or plugged in.
 *
 * A plugin is a shared object with one exported function, asc_plugin_interface, which gives a table for an id or NULL.
 * Fields are only ever appended to the tables; struct_size says which of them a table has. All strings and tables live
 * in static storage. Every function may be called from any thread, `fill` and `weights` from many at once.
 */
#ifndef ASC_PLUGIN_H
#define ASC_PLUGIN_H

#include "aliascope/base.h"
#include "aliascope/sampler.h"

#define ASC_ABI_VERSION 1u
#define ASC_SAMPLER_INTERFACE_ID "asc.sampler/1"

/* What `create` is given: everything resolved and within the ranges that the parameter table states. `values` has one
 * entry a parameter, in the table's order, and lives only during the call. */
typedef struct asc_sampler_config {
  size_t struct_size;
  uint64_t samples;
  uint32_t dimensions;
  uint64_t seed;
  const double *values;
} asc_sampler_config;

/* What `create` gives back. */
typedef struct asc_sampler_state {
  void *state;
  uint32_t traits;
  uint64_t index_end; /* one past the last index that `fill` answers; for a pattern that is no sequence, N */
} asc_sampler_state;

typedef struct asc_sampler_interface {
  size_t struct_size;
  const char *name;   /* kebab-case */
  const char *title;  /* a few words */
  const char *source; /* the publication */
  const asc_parameter *parameters;
  size_t parameter_count;
  /* ASC_UNSUPPORTED for a count or dimension that the pattern cannot have, the reason in `error`. */
  asc_status (*create)(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error);
  void (*destroy)(void *state);
  /* Pure. The range is valid (below index_end, within the dimensions). Writes range->sample_count rows of
   * range->dimension_count values in [0, 1). */
  asc_status (*fill)(const void *state, const asc_range *range, double *points);
  asc_status (*weights)(const void *state, uint64_t first, size_t count, double *weights); /* NULL: 1/N */
  /* `fill` of pixels in a row, from the range's to the right, one after the other. NULL, or not in the table: `fill` of
   * each. */
  asc_status (*fill_pixels)(const void *state, const asc_range *range, size_t pixels, double *points);
} asc_sampler_interface;

#if defined(__GNUC__) && !defined(ASC_CDEF)
#define ASC_PLUGIN_EXPORT __attribute__((visibility("default")))
#else
#define ASC_PLUGIN_EXPORT
#endif

/* The one function that a plugin exports, with ASC_PLUGIN_EXPORT: `const void *asc_plugin_interface(uint32_t
 * abi_version, const char *id)`. */
typedef const void *(*asc_plugin_interface_function)(uint32_t abi_version, const char *id);

/* Loads a plugin and registers its sampler. ASC_PLUGIN where the file, its function, its ABI version or its table is
 * not usable, or the name is taken. Not thread-safe against other calls of the library: load first, then render. */
ASC_API asc_status asc_plugin_load(const char *path, asc_error *error);

/* The same of a plugin that runs in another process, its host, which the caller starts and confines: what the plugin
 * does there, a crash too, ends that process and no other. Its points are the same bits; each call costs a switch of
 * processes and back.
 *
 * memory: a file descriptor of asc_plugin_memory(channels) zero bytes, which the host has too, as memfd_create gives
 * it, sealed against another size (a host that shrank it would crash its client); it may be closed afterwards.
 * channels: 1 to 64, the threads that the plugin answers at a time. alive: a stream socket whose other end is open as
 * long as the host lives, and whose end tells the host to end; it is duplicated. time_limit: seconds that an answer may
 * take.
 *
 * Waits until the host has called asc_plugin_serve. Statuses as of asc_plugin_load. From then on the sampler's
 * functions give ASC_ENDED where the host has ended, or has not answered in time. To connect again with the same path
 * replaces a host that has ended, for samplers that are made from then on. Linux. */
ASC_API asc_status asc_plugin_connect(int memory, int alive, const char *path, double time_limit, asc_error *error);
ASC_API size_t asc_plugin_memory(size_t channels);

/* CPU seconds that hosts have worked so far on what this thread asked of them: no clock of this process has them. */
ASC_API double asc_plugin_seconds(void);

/* Of the host: loads a plugin and answers by threads of its own, one a channel, until the process ends. Returns at
 * once; the client is told what is returned, too. */
ASC_API asc_status asc_plugin_serve(int memory, const char *path, asc_error *error);

#endif

#define _GNU_SOURCE /* strdup, sched_getcpu */
#include "remote.h"

#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#define LOOK_EVERY 0.05  /* s between looks at whether the host lives, while it has not answered */
#define YIELDS 64        /* before it sleeps: the host's thread runs on the same processor (host.c, follow) */
#define MOST_CHANNELS 64 /* as `taken` has bits */

/* One host. Its states hold it, and the plugin while it is the plugin's newest. */
typedef struct connection {
  void *memory;
  size_t bytes;
  int alive; /* a socket whose other end the host's process has */
  double time_limit;
  size_t channels;
  pthread_mutex_t lock;
  pthread_cond_t freed;
  uint64_t taken; /* of the channels, a bit each; one that was never answered stays taken */
  atomic_int ended;
  atomic_size_t holders;
} connection;

/* `interface` comes first: registry.c knows it alone. */
typedef struct remote {
  asc_sampler_interface interface;
  asc_remote_table table; /* a copy, which the host cannot write */
  asc_parameter parameters[ASC_REMOTE_PARAMETERS];
  char *path;
  connection *newest;
  struct remote *next;
} remote;

typedef struct state {
  connection *host;
  uint64_t handle;
} state;

static remote *remotes; /* plugins are loaded before threads, as plugin.h says; they are never unloaded */

/* --- connections ----------------------------------------------------------------------------------------------------
 */

size_t asc_plugin_memory(size_t channels) {
  return (sizeof(asc_remote_table) + 63) / 64 * 64 + channels * sizeof(asc_remote_channel);
}

static void release(connection *host) {
  if (!host || atomic_fetch_sub(&host->holders, 1) != 1) return;
  (void)munmap(host->memory, host->bytes);
  (void)close(host->alive);
  (void)pthread_mutex_destroy(&host->lock);
  (void)pthread_cond_destroy(&host->freed);
  free(host);
}

static connection *connect_to(int memory, int alive, double time_limit) {
  connection *host = calloc(1, sizeof *host);
  if (!host) return NULL;
  *host = (connection){.alive = fcntl(alive, F_DUPFD_CLOEXEC, 0), .time_limit = time_limit};
  host->memory = host->alive < 0 ? NULL : asc_remote_map(memory, &host->bytes);
  if (!host->memory) {
    if (host->alive >= 0) (void)close(host->alive);
    free(host);
    return NULL;
  }
  host->channels = (host->bytes - asc_plugin_memory(0)) / sizeof(asc_remote_channel);
  if (host->channels > MOST_CHANNELS) host->channels = MOST_CHANNELS;
  (void)pthread_mutex_init(&host->lock, NULL);
  (void)pthread_cond_init(&host->freed, NULL);
  atomic_init(&host->ended, 0);
  atomic_init(&host->holders, 1);
  return host;
}

static int lives(const connection *host) {
  struct pollfd of = {host->alive, 0, 0};
  return poll(&of, 1, 0) == 0;
}

/* Of no use any more, for all threads: what is on its way is not waited for. */
static asc_status end(connection *host) {
  (void)shutdown(host->alive, SHUT_RDWR); /* at which the host's process ends the plugin */
  (void)pthread_mutex_lock(&host->lock);
  atomic_store(&host->ended, 1);
  (void)pthread_cond_broadcast(&host->freed);
  (void)pthread_mutex_unlock(&host->lock);
  return ASC_ENDED;
}

/* ASC_OK once it is the client's turn; ASC_ENDED where the host is gone, or takes longer than it may. */
static asc_status wait_for(connection *host, _Atomic uint32_t *turn) {
  uint32_t seen = atomic_load(turn);
  for (int i = 0; i < YIELDS && seen != ASC_REMOTE_ANSWERED; i++) {
    (void)sched_yield();
    seen = atomic_load(turn);
  }
  if (seen == ASC_REMOTE_ANSWERED) return ASC_OK;
  const double limit = asc_remote_now() + host->time_limit;
  while ((seen = atomic_load(turn)) != ASC_REMOTE_ANSWERED) {
    if (atomic_load(&host->ended)) return ASC_ENDED;
    asc_remote_sleep(turn, seen, LOOK_EVERY);
    if (atomic_load(turn) != ASC_REMOTE_ANSWERED && (asc_remote_now() > limit || !lives(host))) return end(host);
  }
  return ASC_OK;
}

/* --- questions ------------------------------------------------------------------------------------------------------
 */

/* A channel of this thread's alone, or NULL where the host has ended. */
static asc_remote_channel *take(connection *host) {
  const uint64_t all = host->channels == MOST_CHANNELS ? UINT64_MAX : ((uint64_t)1 << host->channels) - 1;
  asc_remote_channel *channel = NULL;
  (void)pthread_mutex_lock(&host->lock);
  while (host->taken == all && !atomic_load(&host->ended)) (void)pthread_cond_wait(&host->freed, &host->lock);
  for (size_t i = 0; i < host->channels && !channel && !atomic_load(&host->ended); i++)
    if (!(host->taken >> i & 1)) {
      host->taken |= (uint64_t)1 << i;
      channel = &asc_remote_channels(host->memory)[i];
    }
  (void)pthread_mutex_unlock(&host->lock);
  return channel;
}

static void give_back(connection *host, const asc_remote_channel *channel) {
  const size_t index = (size_t)(channel - asc_remote_channels(host->memory));
  (void)pthread_mutex_lock(&host->lock);
  host->taken &= ~((uint64_t)1 << index);
  (void)pthread_cond_signal(&host->freed);
  (void)pthread_mutex_unlock(&host->lock);
}

static _Thread_local double charged;

double asc_plugin_seconds(void) { return charged; }

/* A status that a sampler may give; a code that none has is that of a host that cannot be believed. */
static asc_status ask(connection *host, asc_remote_channel *channel, asc_remote_question question) {
  const double begun = asc_remote_now();
  channel->question = (uint32_t)question;
  channel->processor = sched_getcpu();
  asc_remote_say(&channel->turn, ASC_REMOTE_ASKED);
  const asc_status status = wait_for(host, &channel->turn);
  if (status) return status;
  /* No more than it took on the wall, whatever a host says. */
  const double wall = asc_remote_now() - begun, said = channel->seconds;
  if (said > 0.0) charged += said < wall ? said : wall;
  const uint32_t answer = channel->status;
  return answer <= ASC_OUT_OF_RANGE ? (asc_status)answer : end(host);
}

int asc_is_remote(const asc_sampler_interface *interface) {
  for (const remote *each = remotes; each; each = each->next)
    if (&each->interface == interface) return 1;
  return 0;
}

static asc_status refuse(const asc_error *said, asc_status status, const char *name, asc_error *error) {
  asc_error text; /* as the host may write another end meanwhile */
  memcpy(&text, said, sizeof text);
  text.text[sizeof text.text - 1] = 0;
  return asc_fail(error, status, "%s", *text.text ? text.text : name);
}

asc_status asc_remote_create(const asc_sampler_interface *interface, const asc_sampler_config *config,
                             asc_sampler_state *made, asc_error *error) {
  const remote *plugin = (const remote *)interface;
  connection *host = plugin->newest;
  state *held = malloc(sizeof *held);
  if (!held) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  asc_remote_channel *channel = take(host);
  if (!channel) {
    free(held);
    return asc_fail(error, ASC_ENDED, "%s: %s", plugin->path, asc_status_text(ASC_ENDED));
  }
  channel->samples = config->samples;
  channel->dimensions = config->dimensions;
  channel->seed = config->seed;
  memset(&channel->error, 0, sizeof channel->error);
  memcpy(channel->data, config->values, interface->parameter_count * sizeof *config->values);
  asc_status status = ask(host, channel, ASC_REMOTE_CREATE);
  if (status == ASC_ENDED) {
    free(held);
    return asc_fail(error, status, "%s: %s", plugin->path, asc_status_text(status));
  }
  *held = (state){host, channel->state};
  *made = (asc_sampler_state){held, channel->traits, channel->index_end};
  if (status) {
    status = refuse(&channel->error, status, asc_status_text(status), error);
    free(held);
  } else
    (void)atomic_fetch_add(&host->holders, 1);
  give_back(host, channel);
  return status;
}

static void destroy(void *opaque) {
  state *held = opaque;
  asc_remote_channel *channel = take(held->host);
  if (channel) {
    channel->state = held->handle;
    if (ask(held->host, channel, ASC_REMOTE_DESTROY) != ASC_ENDED) give_back(held->host, channel);
  }
  release(held->host);
  free(held);
}

/* Has a range of pixels filled that fits into a channel. */
static asc_status fill_part(const state *held, const asc_range *range, uint32_t columns, size_t first, size_t pixels,
                            double *points) {
  asc_remote_channel *channel = take(held->host);
  if (!channel) return ASC_ENDED;
  channel->state = held->handle;
  channel->range = *range;
  channel->columns = columns;
  channel->first = first;
  channel->pixels = pixels;
  const asc_status status = ask(held->host, channel, ASC_REMOTE_FILL);
  if (status == ASC_ENDED) return status;
  memcpy(points, channel->data, pixels * range->sample_count * range->dimension_count * sizeof *points);
  give_back(held->host, channel);
  return status;
}

/* One pixel, in as many parts as it takes: of whole samples, or of one sample each where that has too many numbers. */
static asc_status fill(const void *opaque, const asc_range *range, double *points) {
  const uint32_t all = range->dimension_count, width = all < ASC_REMOTE_DOUBLES ? all : ASC_REMOTE_DOUBLES;
  const size_t rows = width < all ? 1 : ASC_REMOTE_DOUBLES / width;
  for (size_t row = 0; row < range->sample_count; row += rows)
    for (uint32_t column = 0; column < all; column += width) {
      asc_range part = *range;
      part.first_sample += row;
      part.sample_count = range->sample_count - row < rows ? range->sample_count - row : rows;
      part.first_dimension += column;
      part.dimension_count = all - column < width ? all - column : width;
      const asc_status status = fill_part(opaque, &part, 1, 0, 1, points + row * all + column);
      if (status) return status;
    }
  return ASC_OK;
}

asc_status asc_remote_fill_area(const void *opaque, const asc_range *range, uint32_t columns, size_t first,
                                size_t pixels, double *points) {
  const size_t most = ASC_REMOTE_DOUBLES / range->dimension_count / range->sample_count;
  const size_t each = range->sample_count * range->dimension_count;
  asc_status status = ASC_OK;
  for (size_t done = 0; done < pixels && most > 0 && !status; done += most) {
    const size_t part = pixels - done < most ? pixels - done : most;
    status = fill_part(opaque, range, columns, first + done, part, points + done * each);
  }
  for (size_t done = 0; done < pixels && most == 0 && !status; done++) {
    asc_range one = *range;
    one.pixel_x += (int32_t)((first + done) % columns);
    one.pixel_y += (int32_t)((first + done) / columns);
    status = fill(opaque, &one, points + done * each);
  }
  return status;
}

static asc_status fill_pixels(const void *opaque, const asc_range *range, size_t pixels, double *points) {
  return asc_remote_fill_area(opaque, range, (uint32_t)pixels, 0, pixels, points);
}

static asc_status weights(const void *opaque, uint64_t first, size_t count, double *made) {
  const state *held = opaque;
  for (size_t done = 0; done < count;) {
    const size_t part = count - done < ASC_REMOTE_DOUBLES ? count - done : ASC_REMOTE_DOUBLES;
    asc_remote_channel *channel = take(held->host);
    if (!channel) return ASC_ENDED;
    channel->state = held->handle;
    channel->range = (asc_range){.first_sample = first + done, .sample_count = part};
    const asc_status status = ask(held->host, channel, ASC_REMOTE_WEIGHTS);
    if (status == ASC_ENDED) return status;
    memcpy(made + done, channel->data, part * sizeof *made);
    give_back(held->host, channel);
    if (status) return status;
    done += part;
  }
  return ASC_OK;
}

/* --- the plugin -----------------------------------------------------------------------------------------------------
 */

/* Never called: registry.c calls asc_remote_create, which is told the plugin too. */
static asc_status create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  (void)config, (void)made;
  return asc_fail(error, ASC_PLUGIN, "a plugin in another process is made by asc_remote_create");
}

#define CLOSE(text) ((text)[sizeof(text) - 1] = 0)

/* The table as it is registered, from a copy of the host's. */
static void adopt(remote *plugin) {
  asc_remote_table *table = &plugin->table;
  CLOSE(table->name), CLOSE(table->title), CLOSE(table->source);
  for (size_t i = 0; i < table->parameter_count && i < ASC_REMOTE_PARAMETERS; i++) {
    asc_remote_parameter *from = &table->parameters[i];
    CLOSE(from->name), CLOSE(from->choices), CLOSE(from->text);
    plugin->parameters[i] = (asc_parameter){from->name,
                                            (asc_parameter_kind)from->kind,
                                            *from->choices ? from->choices : NULL,
                                            from->minimum,
                                            from->maximum,
                                            from->fallback,
                                            from->text};
  }
  plugin->interface = (asc_sampler_interface){sizeof plugin->interface,
                                              table->name,
                                              table->title,
                                              table->source,
                                              plugin->parameters,
                                              table->parameter_count,
                                              create,
                                              destroy,
                                              fill,
                                              table->has_weights ? weights : NULL,
                                              fill_pixels};
}

static remote *find(const char *path) {
  for (remote *each = remotes; each; each = each->next)
    if (strcmp(each->path, path) == 0) return each;
  return NULL;
}

static asc_status join(connection *host, const char *path, asc_error *error) {
  const asc_remote_table *table = host->memory;
  asc_status status = wait_for(host, &((asc_remote_table *)host->memory)->turn);
  if (status) return asc_fail(error, ASC_PLUGIN, "%s: %s", path, asc_status_text(ASC_ENDED));
  if (table->status) return refuse(&table->error, ASC_PLUGIN, path, error);
  remote *old = find(path), *plugin = calloc(1, sizeof *plugin);
  if (!plugin) return asc_fail(error, ASC_OUT_OF_MEMORY, "out of memory");
  memcpy(&plugin->table, table, sizeof plugin->table);
  adopt(plugin);
  plugin->newest = host;
  plugin->next = remotes;
  if (old) {
    /* But for the first word, the turn. */
    status = memcmp(&plugin->table.status, &old->table.status, sizeof *table - sizeof table->turn)
                 ? asc_fail(error, ASC_PLUGIN, "%s: has another table than when it was loaded; begin anew", path)
                 : ASC_OK;
    if (!status) {
      release(old->newest);
      old->newest = host;
    }
    free(plugin);
    return status;
  }
  plugin->path = strdup(path);
  status = plugin->path ? asc_register(&plugin->interface, path, error) : ASC_OUT_OF_MEMORY;
  if (status) {
    free(plugin->path);
    free(plugin);
    return status;
  }
  remotes = plugin;
  return ASC_OK;
}

asc_status asc_plugin_connect(int memory, int alive, const char *path, double time_limit, asc_error *error) {
  if (!path || !(time_limit > 0.0)) return asc_fail(error, ASC_INVALID_ARGUMENT, "asc_plugin_connect: no path or time");
  connection *host = connect_to(memory, alive, time_limit);
  if (!host) return asc_fail(error, ASC_PLUGIN, "%s: the memory to be shared cannot be mapped", path);
  const asc_status status = join(host, path, error);
  if (status) release(host);
  return status;
}

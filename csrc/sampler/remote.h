/* A plugin in a process of its own: what its host and the library, its client, share. remote.c is the client's side,
 * host.c the plugin's.
 *
 * The memory that they share is a table, which the host fills once, and channels. A thread that wants something takes a
 * channel, writes its question, and waits until a thread of the host has answered. What the host writes is read once,
 * and believed no more than what a plugin in the own process gives. */
#ifndef ASC_REMOTE_H
#define ASC_REMOTE_H

#include <stdatomic.h>

#include "made.h"

#define ASC_REMOTE_PARAMETERS 64
#define ASC_REMOTE_DOUBLES 32768 /* that go through a channel at a time: 256 KiB */

typedef enum asc_remote_turn { ASC_REMOTE_IDLE = 0, ASC_REMOTE_ASKED = 1, ASC_REMOTE_ANSWERED = 2 } asc_remote_turn;

typedef enum asc_remote_question {
  ASC_REMOTE_CREATE,  /* of samples, dimensions and seed, with the values in `data` */
  ASC_REMOTE_DESTROY, /* the state */
  ASC_REMOTE_FILL,    /* the range, of `pixels` from `first` on in rows of `columns`, into `data` */
  ASC_REMOTE_WEIGHTS  /* of the range's samples, into `data` */
} asc_remote_question;

typedef struct asc_remote_channel {
  _Atomic uint32_t turn; /* an asc_remote_turn; both sides sleep on it */
  uint32_t question;
  int32_t processor; /* that the client runs on */
  uint64_t state;    /* as `create` gave it; of no meaning to the client */
  uint64_t samples, seed, first, pixels;
  uint32_t dimensions, columns;
  asc_range range;
  /* The answer. */
  uint32_t status, traits;
  uint64_t index_end;
  double seconds; /* of CPU time that it took */
  asc_error error;
  double data[ASC_REMOTE_DOUBLES];
} asc_remote_channel;

typedef struct asc_remote_parameter {
  char name[64], choices[512], text[256];
  uint32_t kind;
  double minimum, maximum, fallback;
} asc_remote_parameter;

typedef struct asc_remote_table {
  _Atomic uint32_t turn; /* ASC_REMOTE_ANSWERED once the plugin is loaded, or is known to be none */
  uint32_t status;
  asc_error error;
  char name[128], title[256], source[512];
  uint32_t parameter_count, has_weights;
  asc_remote_parameter parameters[ASC_REMOTE_PARAMETERS];
} asc_remote_table;

/* The memory: the table, and behind it the channels. */
static inline asc_remote_channel *asc_remote_channels(void *memory) {
  return (asc_remote_channel *)((char *)memory + (sizeof(asc_remote_table) + 63) / 64 * 64);
}

/* Sleeps until the turn is another than `old`, at most so long; also wakes for nothing. */
void asc_remote_sleep(_Atomic uint32_t *turn, uint32_t old, double longest); /* s */
void asc_remote_say(_Atomic uint32_t *turn, uint32_t now);

double asc_remote_now(void); /* s of the monotonic clock */

/* Maps the memory of a file descriptor; its size. NULL where that cannot be. */
void *asc_remote_map(int memory, size_t *bytes);

/* Whether this is the table of a plugin that has a process of its own; `create` of such a table is this one. */
int asc_is_remote(const asc_sampler_interface *interface);
asc_status asc_remote_create(const asc_sampler_interface *interface, const asc_sampler_config *config,
                             asc_sampler_state *made, asc_error *error);
asc_status asc_remote_fill_area(const void *opaque, const asc_range *range, uint32_t columns, size_t first,
                                size_t pixels, double *points);

#endif

/* Preloaded into POV-Ray: shortens the short waits by which its threads look whether there is something to do.
 *
 * POV-Ray 3.7 hands its messages from thread to thread by looking into a queue every 10, 50 or 100 milliseconds, so
 * that a run of a small picture sleeps for 0.67 of its 0.7 seconds, and a frame for 0.22 of 0.23 (measured with
 * strace). Looking SHARE times as often changes nothing of what it computes, nor the CPU time that it states, which is
 * that of the threads that trace. Longer waits are left alone: they are time limits. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <dlfcn.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#define SHARE 50
#define LONGEST 110000000LL /* nanoseconds */
#define SECOND 1000000000LL
#define FINER 1000

static long long nanoseconds(const struct timespec *time) { return (long long)time->tv_sec * SECOND + time->tv_nsec; }

static struct timespec of_nanoseconds(long long time) {
  return (struct timespec){.tv_sec = (time_t)(time / SECOND), .tv_nsec = (long)(time % SECOND)};
}

static struct timespec shorter(const struct timespec *wait) {
  const long long length = nanoseconds(wait);
  return length > 0 && length <= LONGEST ? of_nanoseconds(length / SHARE) : *wait;
}

/* The function that stands behind ours. The version is that of the GNU C library's present condition variables, where a
 * name without one means those of 2001. */
static void next(void *function, const char *name, const char *version) {
  void *found = version ? dlvsym(RTLD_NEXT, name, version) : NULL;
  if (!found) found = dlsym(RTLD_NEXT, name);
  memcpy(function, &found, sizeof found); /* C has no conversion from void * to a function */
}

static int (*next_clock_gettime)(clockid_t, struct timespec *);
static int (*next_nanosleep)(const struct timespec *, struct timespec *);
static int (*next_clock_nanosleep)(clockid_t, int, const struct timespec *, struct timespec *);
static int (*next_timedwait)(pthread_cond_t *, pthread_mutex_t *, const struct timespec *);
static int (*next_clockwait)(pthread_cond_t *, pthread_mutex_t *, clockid_t, const struct timespec *);

/* Before the program's threads begin. */
__attribute__((constructor)) static void find(void) {
  next(&next_clock_gettime, "clock_gettime", NULL);
  next(&next_nanosleep, "nanosleep", NULL);
  next(&next_clock_nanosleep, "clock_nanosleep", NULL);
  next(&next_timedwait, "pthread_cond_timedwait", "GLIBC_2.3.2");
  next(&next_clockwait, "pthread_cond_clockwait", NULL);
}

/* The deadline of a short wait, sooner; returns whether it is one by this clock. */
static int sooner(clockid_t clock, const struct timespec *deadline, struct timespec *found) {
  struct timespec now;
  *found = *deadline;
  if (next_clock_gettime(clock, &now) != 0) return 0;
  const long long left = nanoseconds(deadline) - nanoseconds(&now);
  if (left <= 0 || left > LONGEST) return 0;
  *found = of_nanoseconds(nanoseconds(&now) + left / SHARE);
  return 1;
}

/* At the end, of which readers keep more than of the beginning. */
__attribute__((destructor)) static void tell(void) { fputs("aliascope: CPU seconds are milliseconds\n", stderr); }

#define EXPORT __attribute__((visibility("default")))

/* NOLINTBEGIN(readability-inconsistent-declaration-parameter-name): the GNU C library keeps its names to itself */
EXPORT int clock_gettime(clockid_t clock, struct timespec *now) {
  if (!next_clock_gettime) next(&next_clock_gettime, "clock_gettime", NULL); /* others have constructors too */
  const int status = next_clock_gettime(clock, now);
  if (status == 0 && clock == CLOCK_THREAD_CPUTIME_ID) *now = of_nanoseconds(FINER * nanoseconds(now));
  return status;
}

EXPORT int nanosleep(const struct timespec *wait, struct timespec *left) {
  const struct timespec chosen = shorter(wait);
  return next_nanosleep(&chosen, left);
}

EXPORT int clock_nanosleep(clockid_t clock, int flags, const struct timespec *wait, struct timespec *left) {
  const struct timespec chosen = flags & TIMER_ABSTIME ? *wait : shorter(wait);
  return next_clock_nanosleep(clock, flags, &chosen, left);
}

EXPORT int pthread_cond_timedwait(pthread_cond_t *condition, pthread_mutex_t *mutex, const struct timespec *deadline) {
  struct timespec chosen;
  if (!sooner(CLOCK_MONOTONIC, deadline, &chosen)) sooner(CLOCK_REALTIME, deadline, &chosen);
  return next_timedwait(condition, mutex, &chosen);
}

EXPORT int pthread_cond_clockwait(pthread_cond_t *condition, pthread_mutex_t *mutex, clockid_t clock,
                                  const struct timespec *deadline) {
  struct timespec chosen;
  sooner(clock, deadline, &chosen);
  return next_clockwait(condition, mutex, clock, &chosen);
}
/* NOLINTEND(readability-inconsistent-declaration-parameter-name) */

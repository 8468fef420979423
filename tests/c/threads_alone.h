/* Under the thread sanitizer, which is slow, tests run that start threads, and no others: those whose names say so. */
#ifndef THREADS_ALONE_H
#define THREADS_ALONE_H

static inline void take_threads_alone(void) {
#ifdef __SANITIZE_THREAD__
  cmocka_set_test_filter("*threads*");
#endif
}

#endif

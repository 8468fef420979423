/* Two threads add to one number, and nothing is between them: that the thread sanitizer is on, this is to fail. */
#include <pthread.h>
#include <stddef.h>

static void *add(void *to) {
  for (int i = 0; i < 1000; i++) ++*(volatile int *)to;
  return NULL;
}

int main(void) {
  int sum = 0;
  pthread_t other;
  if (pthread_create(&other, NULL, add, &sum) != 0) return 0;
  (void)add(&sum);
  (void)pthread_join(other, NULL);
  return 0;
}

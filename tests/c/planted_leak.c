/* Loses 123 bytes: that the leak sanitizer is on and does not let ours go, this is to fail. */
#include <stdlib.h>
#include <string.h>

int main(void) {
  char *volatile kept = malloc(123);
  if (!kept) return 0;
  memset(kept, 1, 123);
  kept = NULL;
  return 0;
}

/* Runs a fuzz target on the files that are named: the kept inputs, as a test, without libFuzzer. */
#include "bytes.h"

/* In memory of the file's own length, so that a sanitizer sees what is read past it. */
static int replay(const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file || fseek(file, 0, SEEK_END)) return 1;
  const long size = ftell(file);
  uint8_t *data = size < 0 ? NULL : malloc(size ? (size_t)size : 1);
  rewind(file);
  const int failed = !data || fread(data, 1, (size_t)size, file) != (size_t)size;
  (void)fclose(file);
  if (!failed) (void)LLVMFuzzerTestOneInput(data, (size_t)size);
  free(data);
  return failed;
}

int main(int count, char **names) {
  for (int i = 1; i < count; i++) {
    if (!replay(names[i])) continue;
    (void)fprintf(stderr, "%s: cannot be read\n", names[i]);
    return 1;
  }
  if (count < 2) (void)fprintf(stderr, "%s: no inputs: tests/fuzz/corpus has a folder for each target\n", names[0]);
  return count < 2;
}

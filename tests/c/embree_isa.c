/* Stands between the tracer and Embree, by LD_PRELOAD: Embree then uses the instruction set that the environment names
 * in EMBREE_ISA ("sse2", "sse4.2", "avx", ...), and not the widest that the machine has. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

__attribute__((visibility("default"))) RTCDevice rtcNewDevice(const char *config) {
  RTCDevice (*made)(const char *) = NULL;
  void *found = dlsym(RTLD_NEXT, "rtcNewDevice");
  if (!found) return NULL;
  memcpy(&made, &found, sizeof made); /* C has no conversion from void * to a function */
  const char *isa = getenv("EMBREE_ISA");
  char text[256];
  const int length = snprintf(text, sizeof text, "%s%s%s", config ? config : "", isa ? ",isa=" : "", isa ? isa : "");
  return length > 0 && (size_t)length < sizeof text ? made(text) : NULL;
}

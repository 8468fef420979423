#define _GNU_SOURCE /* RTLD_NEXT */
#include "kept_rays.h"

#include <dlfcn.h>
#include <embree3/rtcore.h>
#include <stdalign.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now(void) {
  struct timespec time;
  (void)clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

typedef void intersect_function(const int *, RTCScene, struct RTCIntersectContext *, struct RTCRayHit16 *);
typedef void occluded_function(const int *, RTCScene, struct RTCIntersectContext *, struct RTCRay16 *);

static intersect_function *embree_intersect;
static occluded_function *embree_occluded;

/* Origins, directions, tnear, tfar and time, in the order of `fields`. */
#define FIELDS 9

/* What all lanes share is one number, or reading what was kept would cost more than making it did. */
typedef struct kept_packet {
  float shared[FIELDS];
  uint16_t varies, valid; /* bits: fields, lanes */
  uint8_t shadows, coherent;
  size_t values; /* where those of the fields that vary begin, 16 each */
} kept_packet;

static struct {
  int keeping;
  RTCScene scene;
  kept_packet *packets;
  size_t count, room;
  float *values;
  size_t value_count, value_room;
  kept_counts counts;
} kept;

static void fields(struct RTCRay16 *ray, float *found[FIELDS]) {
  float *const all[FIELDS] = {ray->org_x, ray->org_y, ray->org_z, ray->dir_x, ray->dir_y,
                              ray->dir_z, ray->tnear, ray->tfar,  ray->time};
  memcpy(found, all, sizeof all);
}

static void *grown(void *from, size_t *room, size_t count, size_t size) {
  if (count <= *room) return from;
  *room = 2 * count;
  void *made = realloc(from, *room * size);
  if (!made) abort();
  return made;
}

static void keep(const int *valid, RTCScene scene, const struct RTCIntersectContext *context, struct RTCRay16 *ray,
                 uint8_t shadows) {
  float *from[FIELDS];
  fields(ray, from);
  kept.packets = grown(kept.packets, &kept.room, kept.count + 1, sizeof *kept.packets);
  kept.values = grown(kept.values, &kept.value_room, kept.value_count + FIELDS * 16u, sizeof *kept.values);
  kept_packet *into = &kept.packets[kept.count++];
  kept.scene = scene;
  *into = (kept_packet){.shadows = shadows, .values = kept.value_count};
  into->coherent = (context->flags & RTC_INTERSECT_CONTEXT_FLAG_COHERENT) != 0;
  int first = 15;
  for (int i = 15; i >= 0; i--) {
    if (!valid[i]) continue;
    into->valid |= (uint16_t)(1u << i);
    first = i;
  }
  *(shadows ? &kept.counts.occluded : &kept.counts.intersected) += (uint64_t)__builtin_popcount(into->valid);
  for (int k = 0; k < FIELDS; k++) {
    into->shared[k] = from[k][first];
    for (int i = 0; i < 16; i++)
      if (valid[i] && from[k][i] != from[k][first]) into->varies |= (uint16_t)(1u << k);
    if (!((into->varies >> k) & 1)) continue;
    memcpy(kept.values + kept.value_count, from[k], 16 * sizeof(float));
    kept.value_count += 16;
  }
}

/* Not hidden: as a library, calls from others are to end here. */
ASC_API void rtcIntersect16(const int *valid, RTCScene scene, struct RTCIntersectContext *context,
                            struct RTCRayHit16 *rays) {
  if (kept.keeping) keep(valid, scene, context, &rays->ray, 0);
  embree_intersect(valid, scene, context, rays);
}

ASC_API void rtcOccluded16(const int *valid, RTCScene scene, struct RTCIntersectContext *context,
                           struct RTCRay16 *rays) {
  if (kept.keeping) keep(valid, scene, context, rays, 1);
  embree_occluded(valid, scene, context, rays);
}

static int find_embree(void) {
  void *intersect = dlsym(RTLD_NEXT, "rtcIntersect16"), *occluded = dlsym(RTLD_NEXT, "rtcOccluded16");
  memcpy(&embree_intersect, &intersect, sizeof intersect);
  memcpy(&embree_occluded, &occluded, sizeof occluded);
  return intersect && occluded;
}

int kept_begin(void) {
  if (!find_embree()) return 0;
  kept.keeping = 1;
  kept.count = kept.value_count = 0;
  kept.counts = (kept_counts){0};
  return 1;
}

void kept_end(void) { kept.keeping = 0; }

void kept_free(void) {
  free(kept.packets);
  free(kept.values);
  memset(&kept, 0, sizeof kept);
}

static void take(const kept_packet *from, struct RTCRay16 *ray, int *valid) {
  const float *values = kept.values + from->values;
  float *to[FIELDS];
  fields(ray, to);
  for (int i = 0; i < 16; i++) valid[i] = -((from->valid >> i) & 1);
  for (int k = 0; k < FIELDS; k++) {
    if ((from->varies >> k) & 1) {
      memcpy(to[k], values, 16 * sizeof(float));
      values += 16;
    } else
      for (int i = 0; i < 16; i++) to[k][i] = from->shared[k];
  }
}

/* Lights are as far as they were: tfar goes in again for each packet. */
double kept_loop(kept_counts *counts) {
  alignas(64) static struct RTCRayHit16 rays;
  alignas(64) static struct RTCRay16 shadows;
  alignas(64) static int valid[16];
  struct RTCIntersectContext contexts[2];
  for (int i = 0; i < 2; i++) rtcInitIntersectContext(&contexts[i]);
  contexts[1].flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (int i = 0; i < 16; i++) {
    rays.ray.mask[i] = shadows.mask[i] = UINT32_MAX;
    rays.ray.flags[i] = shadows.flags[i] = 0;
  }
  kept.counts.hits = 0;
  const double begun = now();
  for (size_t i = 0; i < kept.count; i++) {
    const kept_packet *from = &kept.packets[i];
    if (from->shadows) {
      take(from, &shadows, valid);
      embree_occluded(valid, kept.scene, &contexts[from->coherent], &shadows);
      continue;
    }
    take(from, &rays.ray, valid);
    for (int k = 0; k < 16; k++) rays.hit.geomID[k] = rays.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    embree_intersect(valid, kept.scene, &contexts[from->coherent], &rays);
    for (int k = 0; k < 16; k++) kept.counts.hits += valid[k] && rays.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
  }
  const double spent = now() - begun;
  *counts = kept.counts;
  return spent;
}

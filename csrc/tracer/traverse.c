#include "traverse.h"

#include <float.h>
#include <string.h>

#include "vectorise.h"

/* All of Embree's packets are tables of four bytes: a row for each of the 12 fields of rays, and for the 8 of hits, as
 * wide as the packet. */
#define WORD ((size_t)4)
#define RAY_FIELDS ((size_t)12)
#define FIELDS (RAY_FIELDS + 8)
#define TFAR ((size_t)8)

typedef union few_rays {
  struct RTCRayHit one;
  struct RTCRayHit4 four;
  struct RTCRayHit8 eight;
  char words[FIELDS * 8 * WORD];
} few_rays;

_Static_assert(sizeof(struct RTCRayHit) == FIELDS * WORD && sizeof(struct RTCRayHit4) == FIELDS * 4 * WORD &&
                   sizeof(struct RTCRayHit8) == FIELDS * 8 * WORD && sizeof(struct RTCRayHit16) == FIELDS * 16 * WORD,
               "rays and hits have other fields");
_Static_assert(sizeof(struct RTCRay16) == RAY_FIELDS * 16 * WORD && offsetof(struct RTCRay16, tfar) == TFAR * 16 * WORD,
               "rays have other fields");

/* The lanes from `first` on of some fields of a packet to few that are `width` wide. */
ASC_INLINE void take(const void *all, size_t first, size_t width, size_t fields, few_rays *taken) {
  for (size_t i = 0; i < fields; i++)
    memcpy(taken->words + i * width * WORD, (const char *)all + (i * PACKET + first) * WORD, width * WORD);
}

/* And back, from field `from` on. */
ASC_INLINE void put(const few_rays *taken, size_t first, size_t width, size_t from, size_t fields, void *all) {
  for (size_t i = from; i < fields; i++)
    memcpy((char *)all + (i * PACKET + first) * WORD, taken->words + i * width * WORD, width * WORD);
}

ASC_INLINE int any_of(const int *valid, size_t width) {
  int any = 0;
  for (size_t i = 0; i < width; i++) any |= valid[i];
  return any;
}

ASC_INLINE void find_closest(const tracer *made, const int *valid, struct RTCIntersectContext *context, size_t width,
                             void *rays) {
  for (size_t first = 0; first < PACKET; first += width) {
    few_rays some;
    if (!any_of(valid + first, width)) continue;
    take(rays, first, width, FIELDS, &some);
    switch (width) {
    case 1: rtcIntersect1(made->scene, context, &some.one); break;
    case 4: rtcIntersect4(valid + first, made->scene, context, &some.four); break;
    default: rtcIntersect8(valid + first, made->scene, context, &some.eight); break;
    }
    put(&some, first, width, TFAR, FIELDS, rays);
  }
}

ASC_INLINE void find_any(const tracer *made, const int *valid, struct RTCIntersectContext *context, size_t width,
                         void *rays) {
  for (size_t first = 0; first < PACKET; first += width) {
    few_rays some;
    if (!any_of(valid + first, width)) continue;
    take(rays, first, width, RAY_FIELDS, &some);
    switch (width) {
    case 1: rtcOccluded1(made->scene, context, &some.one.ray); break;
    case 4: rtcOccluded4(valid + first, made->scene, context, &some.four.ray); break;
    default: rtcOccluded8(valid + first, made->scene, context, &some.eight.ray); break;
    }
    put(&some, first, width, TFAR, TFAR + 1, rays);
  }
}

void traverse_closest_by_parts(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                               struct RTCRayHit16 *rays) {
  switch (made->options.packet) {
  case 1: find_closest(made, valid, context, 1, rays); break;
  case 4: find_closest(made, valid, context, 4, rays); break;
  default: find_closest(made, valid, context, 8, rays); break;
  }
}

void traverse_any_by_parts(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                           struct RTCRay16 *rays) {
  switch (made->options.packet) {
  case 1: find_any(made, valid, context, 1, rays); break;
  case 4: find_any(made, valid, context, 4, rays); break;
  default: find_any(made, valid, context, 8, rays); break;
  }
}

/* The share of its length by which a direction is turned aside: some times what Embree's test of an edge is off by near
 * its ends, which is some roundings of the distance. */
#define ASIDE (32.0f * FLT_EPSILON)

static void turn_aside(float by, struct RTCRayHit16 *rays) {
  struct RTCRay16 *ray = &rays->ray;
  for (int i = 0; i < PACKET; i++) {
    const float length = fmaxf(fmaxf(fabsf(ray->dir_x[i]), fabsf(ray->dir_y[i])), fabsf(ray->dir_z[i]));
    ray->dir_x[i] += by * length;
    ray->dir_y[i] += 0.625f * by * length; /* along no axis and no diagonal, where edges are */
  }
}

/* Whether some lanes hit and some, which are marked, miss. */
ASC_VECTORISE static int find_missing(const int valid[PACKET], const struct RTCHit16 *hit, int missing[PACKET]) {
  int hits = 0, misses = 0;
  for (int i = 0; i < PACKET; i++) {
    const int misses_here = -(hit->geomID[i] == RTC_INVALID_GEOMETRY_ID) & valid[i];
    missing[i] = misses_here;
    misses |= misses_here;
    hits |= valid[i] & ~misses_here;
  }
  return hits & misses;
}

void traverse_look_again(const tracer *made, const int valid[PACKET], struct RTCIntersectContext *context,
                         struct RTCRayHit16 *rays) {
  alignas(64) int missing[PACKET], met[PACKET];
  if (!find_missing(valid, &rays->hit, missing)) return;
  struct RTCRayHit16 one = *rays, other;
  turn_aside(ASIDE, &one);
  traverse_closest(made, missing, context, &one);
  int any = 0;
  for (int i = 0; i < PACKET; i++) any |= met[i] = missing[i] & -(one.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID);
  if (!any) return;
  other = *rays;
  turn_aside(-ASIDE, &other);
  traverse_closest(made, met, context, &other);
  for (size_t i = 0; i < PACKET; i++) {
    if (!met[i] || other.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
    rays->ray.tfar[i] = one.ray.tfar[i];
    for (size_t field = RAY_FIELDS; field < FIELDS; field++)
      memcpy((char *)rays + (field * PACKET + i) * WORD, (const char *)&one + (field * PACKET + i) * WORD, WORD);
  }
}

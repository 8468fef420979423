#include "packet.h"

#include <string.h>

#include "eye.h"
#include "path.h"
#include "traverse.h"
#include "vectorise.h"

void packet_begin(packet *rays) {
  rtcInitIntersectContext(&rays->context);
  rays->context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcInitIntersectContext(&rays->scattered);
  for (uint32_t i = 0; i < PACKET; i++) rays->shadows.mask[i] = UINT32_MAX;
}

/* Rays through the lanes' samples. Perspective: from the eye, t is the depth; orthographic: from the eye's plane. */
ASC_VECTORISE static void make_rays(const asc_view *view, packet *rays) {
  struct RTCRay16 *ray = &rays->rays.ray;
  struct RTCHit16 *hit = &rays->rays.hit;
  const double step_x = 2.0 * view->half_width / view->width, step_y = 2.0 * view->half_height / view->height;
  float u[PACKET], v[PACKET];
  for (int i = 0; i < PACKET; i++) {
    u[i] = (float)(step_x * (rays->sample_x[i] - view->shift[0]) - view->half_width);
    v[i] = (float)(view->half_height - step_y * (rays->sample_y[i] - view->shift[1]));
  }
  const int perspective = view->projection == ASC_PERSPECTIVE;
  for (int i = 0; i < PACKET; i++) {
    ray->org_x[i] = perspective ? 0.0f : u[i];
    ray->org_y[i] = perspective ? 0.0f : v[i];
    ray->org_z[i] = 0.0f;
    ray->dir_x[i] = perspective ? u[i] : 0.0f;
    ray->dir_y[i] = perspective ? v[i] : 0.0f;
    ray->dir_z[i] = 1.0f;
    ray->tnear[i] = 0.0f;
    ray->tfar[i] = INFINITY;
    ray->time[i] = 0.0f;
    ray->mask[i] = UINT32_MAX;
    ray->flags[i] = 0;
    hit->geomID[i] = RTC_INVALID_GEOMETRY_ID;
    hit->instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
}

/* From the lens: to where the ray through its middle meets the plane of focus. */
ASC_VECTORISE static void move_to_lens(const asc_view *view, packet *rays) {
  struct RTCRay16 *ray = &rays->rays.ray;
  const double(*from)[2] = rays->lens, nearness = 1.0 / view->focus_distance;
  for (int i = 0; i < PACKET; i++) {
    ray->org_x[i] = (float)from[i][0];
    ray->org_y[i] = (float)from[i][1];
    ray->dir_x[i] -= (float)(from[i][0] * nearness);
    ray->dir_y[i] -= (float)(from[i][1] * nearness);
  }
}

/* On to where the frame has its origin. */
ASC_VECTORISE static void move_ahead(const tracer *made, packet *rays) {
  struct RTCRay16 *ray = &rays->rays.ray;
  const asc_view *view = &made->view;
  const double ahead = made->ahead;
  const int through = view->lens_radius > 0.0;
  for (int i = 0; i < PACKET; i++) {
    double u = eye_right(view, rays->sample_x[i]), v = eye_up(view, rays->sample_y[i]), x = 0.0, y = 0.0;
    if (through) {
      x = rays->lens[i][0];
      y = rays->lens[i][1];
      u -= eye_turn(view, x);
      v -= eye_turn(view, y);
    }
    ray->org_x[i] = (float)(x + ahead * u);
    ray->org_y[i] = (float)(y + ahead * v);
  }
}

static void set_times(const tracer *made, packet *rays) {
  const asc_view *view = &made->view;
  for (int i = 0; i < PACKET; i++) {
    const double moment = shutter_moment(view->response, rays->further[i][made->further.time]);
    rays->rays.ray.time[i] = (float)moment;
    rays->time[i] = view->shutter_open + (view->shutter_close - view->shutter_open) * moment;
  }
}

static void take_emission(const tracer *made, packet *rays) {
  const struct RTCHit16 *hit = &rays->rays.hit;
  for (uint32_t i = 0; i < rays->lanes; i++) {
    const double *from = made->view.background;
    if (hit->geomID[i] != RTC_INVALID_GEOMETRY_ID) {
      const surface met = tracer_surface(made, hit->geomID[i], hit->primID[i]);
      from = made->materials[made->material_of[met.kind][met.number]].emission;
    }
    for (int channel = 0; channel < 3; channel++) rays->radiance[i][channel] = from[channel];
  }
}

void packet_cast(const tracer *made, packet *rays) {
  for (uint32_t i = 0; i < PACKET; i++) rays->valid[i] = i < rays->lanes ? -1 : 0;
  make_rays(&made->view, rays);
  if (made->view.lens_radius > 0.0) move_to_lens(&made->view, rays);
  if (made->ahead > 0.0 && made->view.projection == ASC_PERSPECTIVE) move_ahead(made, rays);
  if (made->motion_count > 0) set_times(made, rays);
  traverse_closest(made, rays->valid, &rays->context, &rays->rays);
  if (made->looks_again) traverse_look_again(made, rays->valid, &rays->context, &rays->rays);
}

void packet_shade(const tracer *made, packet *rays) {
  if (made->plain)
    take_emission(made, rays);
  else
    path_follow(made, rays);
}

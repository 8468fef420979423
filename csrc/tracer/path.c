#include "path.h"

#include <string.h>

#include "bounce.h"
#include "direct.h"
#include "emitted.h"
#include "emitter.h"
#include "eye.h"
#include "vectorise.h"

/* The rays from the eye, again in double. */
ASC_VECTORISE static void set_eye_rays(const asc_view *restrict view, packet *restrict rays) {
  const int perspective = view->projection == ASC_PERSPECTIVE;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double u = eye_right(view, rays->sample_x[i]), v = eye_up(view, rays->sample_y[i]);
    rays->origin.row[0][i] = perspective ? 0.0 : u;
    rays->origin.row[1][i] = perspective ? 0.0 : v;
    rays->origin.row[2][i] = 0.0;
    rays->direction.row[0][i] = perspective ? u : 0.0;
    rays->direction.row[1][i] = perspective ? v : 0.0;
    rays->direction.row[2][i] = 1.0;
  }
}

ASC_VECTORISE static void move_to_lens(const asc_view *restrict view, packet *restrict rays) {
  for (uint32_t i = 0; i < PACKET; i++) {
    for (int axis = 0; axis < 2; axis++) {
      rays->origin.row[axis][i] = rays->lens[i][axis];
      rays->direction.row[axis][i] -= eye_turn(view, rays->lens[i][axis]);
    }
  }
}

/* On to where the frame has its origin. */
ASC_VECTORISE static void move_ahead(double ahead, packet *restrict rays) {
  for (int axis = 0; axis < 2; axis++)
    for (uint32_t i = 0; i < PACKET; i++) rays->origin.row[axis][i] += ahead * rays->direction.row[axis][i];
}

static void begin(const tracer *made, packet *rays) {
  set_eye_rays(&made->view, rays);
  if (made->view.lens_radius > 0.0) move_to_lens(&made->view, rays);
  if (made->ahead > 0.0) move_ahead(made->ahead, rays);
  if (made->motion_count > 0) memcpy(rays->shadows.time, rays->rays.ray.time, sizeof rays->shadows.time);
  for (int channel = 0; channel < 3; channel++) {
    for (uint32_t i = 0; i < PACKET; i++) {
      rays->throughput.row[channel][i] = 1.0;
      rays->gathered.row[channel][i] = 0.0;
    }
  }
  if (made->transport.bounces == 0) return;
  for (uint32_t i = 0; i < PACKET; i++) {
    rays->mirrors_left.of[i] = made->transport.mirror_bounces;
    rays->scatters_left.of[i] = made->transport.diffuse_bounces;
    rays->density.of[i] = -1.0;
  }
}

/* How much of the light that shines where a lane's ray ends counts there; the rest does where the ray came from. */
static double share_of_emission(const tracer *made, const packet *rays, const meetings *met, uint32_t lane) {
  double origin[3], direction[3];
  if (rays->density.of[lane] < 0.0) return 1.0;
  const meeting here = meeting_of(met, lane);
  get_lane(&rays->origin, lane, origin);
  get_lane(&rays->direction, lane, direction);
  const double density = emitter_density(made, rays->time[lane], &here, origin, direction);
  return emitted_share_of_rays(made->transport.emission_from, rays->density.of[lane], density);
}

/* `counting`: how much of the light that shines where the lanes' rays end counts. */
ASC_VECTORISE static void add_shining(const meetings *restrict met, const scalars *restrict counting,
                                      packet *restrict rays) {
  for (uint32_t i = 0; i < PACKET; i++) {
    for (int channel = 0; channel < 3; channel++) {
      const double shines = counting->of[i] * (met->colour.row[channel][i] * met->emission.row[channel][i]);
      const double sum = rays->gathered.row[channel][i] + rays->throughput.row[channel][i] * shines;
      rays->gathered.row[channel][i] = rays->valid[i] ? sum : rays->gathered.row[channel][i];
    }
  }
}

/* Where no ray ends on a surface. */
static void add_background(const tracer *made, packet *rays) {
  for (int channel = 0; channel < 3; channel++)
    for (uint32_t i = 0; i < PACKET; i++)
      rays->gathered.row[channel][i] +=
          rays->valid[i] ? rays->throughput.row[channel][i] * made->view.background[channel] : 0.0;
}

/* Finds where the lanes' rays end, and adds what shines there by itself. Gives whether any ends on a surface. */
static int arrive(const tracer *made, packet *rays, uint32_t bounce, meetings *met) {
  scalars counting;
  if (!meeting_find(made, rays, met)) {
    add_background(made, rays);
    return 0;
  }
  for (uint32_t i = 0; i < PACKET; i++) counting.of[i] = 1.0;
  for (uint32_t i = 0; i < PACKET && bounce > 0 && made->emitter_count > 0; i++)
    if (met->material[i]) counting.of[i] = share_of_emission(made, rays, met, i);
  add_shining(met, &counting, rays);
  return 1;
}

static void follow(const tracer *made, packet *rays) {
  meetings met;
  for (uint32_t bounce = 0;; bounce++) {
    struct RTCIntersectContext *context = bounce == 0 ? &rays->context : &rays->scattered;
    if (!arrive(made, rays, bounce, &met)) return;
    direct_add_lights(made, rays, &met, context);
    if (bounce == made->transport.bounces) return;
    if (!bounce_set_chances(&made->transport, rays, &met, bounce)) return;
    emitted_add(made, rays, &met, context);
    if (!bounce_go_on(made, rays, &met, bounce)) return;
  }
}

/* With the fourth, stores leave no gaps. */
ASC_VECTORISE static void set_radiance(packet *restrict rays) {
  double(*restrict to)[4] = rays->radiance;
  for (uint32_t i = 0; i < PACKET; i++) {
    for (int channel = 0; channel < 3; channel++) to[i][channel] = rays->gathered.row[channel][i];
    to[i][3] = 0.0;
  }
}

void path_follow(const tracer *made, packet *rays) {
  begin(made, rays);
  follow(made, rays);
  set_radiance(rays);
}

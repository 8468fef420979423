#include "path.h"

#include <string.h>

#include "direct.h"
#include "lobe.h"
#include "rows.h"
#include "vectorise.h"

/* The rays from the eye, again in double. */
ASC_VECTORISE static void set_eye_rays(const asc_view *view, packet *rays) {
  const int perspective = view->projection == ASC_PERSPECTIVE;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double u = (2.0 * rays->sample_x[i] / view->width - 1.0) * view->half_width;
    const double v = (1.0 - 2.0 * rays->sample_y[i] / view->height) * view->half_height;
    rays->origin.row[0][i] = perspective ? 0.0 : u;
    rays->origin.row[1][i] = perspective ? 0.0 : v;
    rays->origin.row[2][i] = 0.0;
    rays->direction.row[0][i] = perspective ? u : 0.0;
    rays->direction.row[1][i] = perspective ? v : 0.0;
    rays->direction.row[2][i] = 1.0;
  }
}

ASC_VECTORISE static void move_to_lens(const asc_view *view, packet *rays) {
  for (int axis = 0; axis < 2; axis++) {
    for (uint32_t i = 0; i < PACKET; i++) {
      rays->origin.row[axis][i] = rays->lens[i][axis];
      rays->direction.row[axis][i] -= rays->lens[i][axis] / view->focus_distance;
    }
  }
}

static void begin(const tracer *made, packet *rays) {
  const path fresh = {.mirrors_left = made->transport.mirror_bounces,
                      .scatters_left = made->transport.diffuse_bounces,
                      .density = -1.0};
  set_eye_rays(&made->view, rays);
  if (made->view.lens_radius > 0.0) move_to_lens(&made->view, rays);
  if (made->motion_count > 0) memcpy(rays->shadows.time, rays->rays.ray.time, sizeof rays->shadows.time);
  for (int channel = 0; channel < 3; channel++) {
    for (uint32_t i = 0; i < PACKET; i++) {
      rays->throughput.row[channel][i] = 1.0;
      rays->gathered.row[channel][i] = 0.0;
    }
  }
  for (uint32_t i = 0; i < PACKET && made->transport.bounces > 0; i++) rays->paths[i] = fresh;
}

/* How much of the light that shines where a lane's ray ends counts there; the rest does where the ray came from. */
static double share_of_emission(const tracer *made, const packet *rays, const meetings *met, uint32_t lane) {
  const path *way = &rays->paths[lane];
  double origin[3], direction[3];
  if (way->density < 0.0) return 1.0;
  const meeting here = meeting_of(met, lane);
  get_lane(&rays->origin, lane, origin);
  get_lane(&rays->direction, lane, direction);
  const double density = emitter_density(made, rays->time[lane], &here, origin, direction);
  return direct_share_of_rays(made, way->density, density);
}

/* `counting`: how much of the light that shines where the lanes' rays end counts. */
ASC_VECTORISE static void add_shining(const meetings *met, const scalars *counting, packet *rays) {
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

/* The chances that a lane's path goes on by the reflection and by the albedo: as what either brings to the eye is of
 * both. They make 1, or, where less light than that is left after some bounces, that much (Russian roulette). */
static void set_chances(const transport *far, packet *rays, uint32_t lane, const meeting *met, uint32_t bounce) {
  path *way = &rays->paths[lane];
  double mirror = 0.0, scatter = 0.0;
  for (int channel = 0; channel < 3; channel++) {
    const double left = rays->throughput.row[channel][lane];
    if (way->mirrors_left > 0) mirror = larger(mirror, left * met->material->reflection[channel]);
    if (way->scatters_left > 0)
      scatter = larger(scatter, left * (met->colour[channel] * met->material->albedo[channel]));
  }
  const double sum = mirror + scatter;
  way->mirror = way->scatter = 0.0;
  if (!(sum > 0.0)) return;
  const double chance = far->diffuse_bounces > 0 && bounce >= far->roulette_from ? fmin(1.0, sum) : 1.0;
  way->mirror = chance * mirror / sum;
  way->scatter = chance * scatter / sum;
}

/* Sends a lane's path on along its reflection. Gives 0 where it ends. */
static int reflect(packet *rays, uint32_t lane, const meeting *met, const double u[2]) {
  path *way = &rays->paths[lane];
  double direction[3], to_eye[3];
  get_lane(&rays->direction, lane, direction);
  const double length = sqrt(dot(direction, direction));
  for (int i = 0; i < 3; i++) to_eye[i] = -direction[i] / length;
  const asc_lobe *gloss = &met->material->gloss;
  const double share = lobe_sample(gloss, met->normal, to_eye, u, direction);
  if (!(share > 0.0)) return 0;
  set_lane(&rays->direction, lane, direction);
  for (int channel = 0; channel < 3; channel++)
    rays->throughput.row[channel][lane] *= met->material->reflection[channel] * (share / way->mirror);
  way->density =
      gloss->kind == ASC_LOBE_MIRROR ? -1.0 : way->mirror * lobe_towards(gloss, met->normal, to_eye, direction).density;
  way->mirrors_left--;
  rays->counts.reflection++;
  return 1;
}

/* Sends a lane's path on from its albedo. */
static int scatter(packet *rays, uint32_t lane, const meeting *met, const double u[2]) {
  path *way = &rays->paths[lane];
  double direction[3];
  lobe_cosine(met->normal, u, direction);
  set_lane(&rays->direction, lane, direction);
  for (int channel = 0; channel < 3; channel++)
    rays->throughput.row[channel][lane] *= met->colour[channel] * met->material->albedo[channel] / way->scatter;
  way->density = way->scatter * larger(0.0, dot(met->normal, direction)) / ASC_PI;
  way->scatters_left--;
  rays->counts.bounce++;
  return 1;
}

/* Sends a lane's path on. Gives 0 where it ends. */
static int send_on(const tracer *made, packet *rays, uint32_t lane, const meeting *met, uint32_t bounce) {
  const path *way = &rays->paths[lane];
  const layout *further = &made->further;
  static const double none[3] = {0.0};
  const double *numbers =
      further->bounce ? rays->further[lane] + further->bounces + (size_t)bounce * further->bounce : none;
  double choice = 0.0;
  if (made->transport.diffuse_bounces > 0) choice = *numbers++;
  if (choice >= way->mirror + way->scatter) return 0;
  const int goes_on = choice < way->mirror ? reflect(rays, lane, met, numbers) : scatter(rays, lane, met, numbers);
  if (goes_on) set_lane(&rays->origin, lane, met->lifted);
  return goes_on;
}

static void set_ray(packet *rays, uint32_t lane) {
  struct RTCRay16 *ray = &rays->rays.ray;
  struct RTCHit16 *hit = &rays->rays.hit;
  ray->org_x[lane] = (float)rays->origin.row[0][lane];
  ray->org_y[lane] = (float)rays->origin.row[1][lane];
  ray->org_z[lane] = (float)rays->origin.row[2][lane];
  ray->dir_x[lane] = (float)rays->direction.row[0][lane];
  ray->dir_y[lane] = (float)rays->direction.row[1][lane];
  ray->dir_z[lane] = (float)rays->direction.row[2][lane];
  ray->tfar[lane] = INFINITY;
  hit->geomID[lane] = RTC_INVALID_GEOMETRY_ID;
}

/* Sends the lanes' paths on, and traces their rays. Gives 0 where all end. */
static int go_on(const tracer *made, packet *rays, const meetings *met, uint32_t bounce) {
  int left = 0;
  for (uint32_t i = 0; i < PACKET; i++) {
    rays->valid[i] = 0;
    if (!met->material[i]) continue;
    const meeting here = meeting_of(met, i);
    if (!send_on(made, rays, i, &here, bounce)) continue;
    rays->valid[i] = -1;
    set_ray(rays, i);
    left = 1;
  }
  if (left) rtcIntersect16(rays->valid, made->scene, &rays->scattered, &rays->rays);
  return left;
}

static void follow(const tracer *made, packet *rays) {
  const transport *far = &made->transport;
  meetings met;
  for (uint32_t bounce = 0;; bounce++) {
    struct RTCIntersectContext *context = bounce == 0 ? &rays->context : &rays->scattered;
    if (!arrive(made, rays, bounce, &met)) return;
    direct_add_lights(made, rays, &met, context);
    if (bounce == far->bounces) return;
    for (uint32_t i = 0; i < PACKET; i++) {
      if (!met.material[i]) continue;
      const meeting here = meeting_of(&met, i);
      set_chances(far, rays, i, &here, bounce);
    }
    direct_add_emitters(made, rays, &met, context);
    if (!go_on(made, rays, &met, bounce)) return;
  }
}

ASC_VECTORISE static void set_radiance(packet *rays) {
  for (uint32_t i = 0; i < PACKET; i++)
    for (int channel = 0; channel < 3; channel++) rays->radiance[i][channel] = rays->gathered.row[channel][i];
}

void path_follow(const tracer *made, packet *rays) {
  begin(made, rays);
  follow(made, rays);
  set_radiance(rays);
}

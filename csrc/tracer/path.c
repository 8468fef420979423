#include "path.h"

#include "direct.h"
#include "lobe.h"
#include "rows.h"

/* A lane's ray from the eye, again in double. */
static void eye_ray(const tracer *made, const packet *rays, uint32_t lane, double origin[3], double direction[3]) {
  const asc_view *view = &made->view;
  const double u = (2.0 * (rays->sample_x[lane] - view->shift[0]) / view->width - 1.0) * view->half_width;
  const double v = (1.0 - 2.0 * (rays->sample_y[lane] - view->shift[1]) / view->height) * view->half_height;
  const int perspective = view->projection == ASC_PERSPECTIVE;
  origin[0] = perspective ? 0.0 : u;
  origin[1] = perspective ? 0.0 : v;
  origin[2] = 0.0;
  direction[0] = perspective ? u : 0.0;
  direction[1] = perspective ? v : 0.0;
  direction[2] = 1.0;
  if (!(view->lens_radius > 0.0)) return;
  for (int i = 0; i < 2; i++) {
    origin[i] = rays->lens[lane][i];
    direction[i] -= rays->lens[lane][i] / view->focus_distance;
  }
}

static void begin(const tracer *made, packet *rays) {
  const path fresh = {.throughput = {1.0, 1.0, 1.0},
                      .mirrors_left = made->transport.mirror_bounces,
                      .scatters_left = made->transport.diffuse_bounces,
                      .density = -1.0};
  for (uint32_t i = 0; i < rays->lanes; i++) {
    eye_ray(made, rays, i, rays->origin[i], rays->direction[i]);
    rays->paths[i] = fresh;
    for (int channel = 0; channel < 3; channel++) rays->radiance[i][channel] = 0.0;
  }
}

/* How much of the light that shines where a lane's ray ends counts there; the rest does where the ray came from. */
static double share_of_emission(const tracer *made, const packet *rays, uint32_t lane, const meeting *met) {
  const path *way = &rays->paths[lane];
  if (way->density < 0.0) return 1.0;
  const double density = emitter_density(made, rays->time[lane], met, rays->origin[lane], rays->direction[lane]);
  return direct_share_of_rays(made, way->density, density);
}

/* Finds where the lanes' rays end, and adds what shines there by itself. */
static void arrive(const tracer *made, packet *rays, meeting met[PACKET]) {
  for (uint32_t i = 0; i < rays->lanes; i++) {
    met[i].material = NULL;
    if (!rays->valid[i]) continue;
    meeting_find(made, rays, i, &met[i]);
    const asc_material *material = met[i].material;
    const double *throughput = rays->paths[i].throughput;
    const double share = material ? share_of_emission(made, rays, i, &met[i]) : 1.0;
    for (int channel = 0; channel < 3; channel++)
      rays->radiance[i][channel] +=
          throughput[channel] *
          (material ? share * (met[i].colour[channel] * material->emission[channel]) : made->view.background[channel]);
  }
}

/* The chances that a lane's path goes on by the reflection and by the albedo: as what either brings to the eye is of
 * both. They make 1, or, where less light than that is left after some bounces, that much (Russian roulette). */
static void set_chances(const transport *far, path *way, const meeting *met, uint32_t bounce) {
  double mirror = 0.0, scatter = 0.0;
  for (int channel = 0; channel < 3; channel++) {
    const double left = way->throughput[channel];
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
  double *direction = rays->direction[lane], to_eye[3];
  const double length = sqrt(dot(direction, direction));
  for (int i = 0; i < 3; i++) to_eye[i] = -direction[i] / length;
  const asc_lobe *gloss = &met->material->gloss;
  const double share = lobe_sample(gloss, met->normal, to_eye, u, direction);
  if (!(share > 0.0)) return 0;
  for (int channel = 0; channel < 3; channel++)
    way->throughput[channel] *= met->material->reflection[channel] * (share / way->mirror);
  way->density =
      gloss->kind == ASC_LOBE_MIRROR ? -1.0 : way->mirror * lobe_towards(gloss, met->normal, to_eye, direction).density;
  way->mirrors_left--;
  rays->counts.reflection++;
  return 1;
}

/* Sends a lane's path on from its albedo. */
static int scatter(packet *rays, uint32_t lane, const meeting *met, const double u[2]) {
  path *way = &rays->paths[lane];
  lobe_cosine(met->normal, u, rays->direction[lane]);
  for (int channel = 0; channel < 3; channel++)
    way->throughput[channel] *= met->colour[channel] * met->material->albedo[channel] / way->scatter;
  way->density = way->scatter * larger(0.0, dot(met->normal, rays->direction[lane])) / ASC_PI;
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
  if (goes_on) meeting_lift(met->point, met->normal, met->slack, rays->origin[lane]);
  return goes_on;
}

static void set_ray(packet *rays, uint32_t lane) {
  struct RTCRay16 *ray = &rays->rays.ray;
  struct RTCHit16 *hit = &rays->rays.hit;
  ray->org_x[lane] = (float)rays->origin[lane][0];
  ray->org_y[lane] = (float)rays->origin[lane][1];
  ray->org_z[lane] = (float)rays->origin[lane][2];
  ray->dir_x[lane] = (float)rays->direction[lane][0];
  ray->dir_y[lane] = (float)rays->direction[lane][1];
  ray->dir_z[lane] = (float)rays->direction[lane][2];
  ray->tfar[lane] = INFINITY;
  hit->geomID[lane] = RTC_INVALID_GEOMETRY_ID;
}

/* Sends the lanes' paths on, and traces their rays. Gives 0 where all end. */
static int go_on(const tracer *made, packet *rays, const meeting met[PACKET], uint32_t bounce) {
  int left = 0;
  for (uint32_t i = 0; i < rays->lanes; i++) {
    const int goes_on = met[i].material && send_on(made, rays, i, &met[i], bounce);
    rays->valid[i] = goes_on ? -1 : 0;
    if (goes_on) set_ray(rays, i);
    left |= goes_on;
  }
  if (left) rtcIntersect16(rays->valid, made->scene, &rays->scattered, &rays->rays);
  return left;
}

void path_follow(const tracer *made, packet *rays) {
  const transport *far = &made->transport;
  meeting met[PACKET];
  begin(made, rays);
  for (uint32_t bounce = 0;; bounce++) {
    struct RTCIntersectContext *context = bounce == 0 ? &rays->context : &rays->scattered;
    arrive(made, rays, met);
    direct_add_lights(made, rays, met, context);
    if (bounce == far->bounces) return;
    for (uint32_t i = 0; i < rays->lanes; i++)
      if (met[i].material) set_chances(far, &rays->paths[i], &met[i], bounce);
    direct_add_emitters(made, rays, met, context);
    if (!go_on(made, rays, met, bounce)) return;
  }
}

#include "path.h"

#include "direct.h"

/* A lane's ray from the eye, again in double. */
static void eye_ray(const tracer *made, const packet *rays, uint32_t lane, double origin[3], double direction[3]) {
  const asc_view *view = &made->view;
  const double u = (2.0 * rays->sample_x[lane] / view->width - 1.0) * view->half_width;
  const double v = (1.0 - 2.0 * rays->sample_y[lane] / view->height) * view->half_height;
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
  for (uint32_t i = 0; i < rays->lanes; i++) {
    eye_ray(made, rays, i, rays->origin[i], rays->direction[i]);
    rays->paths[i] = (path){{1.0, 1.0, 1.0}, made->transport.mirror_bounces};
    for (int channel = 0; channel < 3; channel++) rays->radiance[i][channel] = 0.0;
  }
}

/* Finds where the lanes' rays end, and adds what shines there by itself. */
static void arrive(const tracer *made, packet *rays, meeting met[PACKET]) {
  for (uint32_t i = 0; i < rays->lanes; i++) {
    met[i].material = NULL;
    if (!rays->valid[i]) continue;
    meeting_find(made, rays, i, &met[i]);
    const double *throughput = rays->paths[i].throughput;
    for (int channel = 0; channel < 3; channel++)
      rays->radiance[i][channel] +=
          throughput[channel] * (met[i].material ? met[i].colour[channel] * met[i].material->emission[channel]
                                                 : made->view.background[channel]);
  }
}

static void mirror(const double direction[3], const double normal[3], double mirrored[3]) {
  const double along = dot(direction, normal);
  for (int i = 0; i < 3; i++) mirrored[i] = direction[i] - 2.0 * along * normal[i];
}

/* Sends a lane's path on. Gives 0 where it ends. */
static int scatter(packet *rays, uint32_t lane, const meeting *met) {
  path *way = &rays->paths[lane];
  const double *reflection = met->material->reflection;
  if (way->mirrors_left == 0) return 0;
  double largest = 0.0, onward[3];
  for (int channel = 0; channel < 3; channel++) {
    way->throughput[channel] *= reflection[channel];
    largest = fmax(largest, way->throughput[channel]);
  }
  if (!(largest > 0.0)) return 0;
  way->mirrors_left--;
  mirror(rays->direction[lane], met->normal, onward);
  const double length = sqrt(dot(onward, onward));
  for (int i = 0; i < 3; i++) rays->direction[lane][i] = onward[i] / length;
  meeting_lift(met->point, met->normal, met->slack, rays->origin[lane]);
  rays->counts.reflection++;
  return 1;
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
static int go_on(const tracer *made, packet *rays, const meeting met[PACKET]) {
  int left = 0;
  for (uint32_t i = 0; i < rays->lanes; i++) {
    const int goes_on = met[i].material && scatter(rays, i, &met[i]);
    rays->valid[i] = goes_on ? -1 : 0;
    if (goes_on) set_ray(rays, i);
    left |= goes_on;
  }
  if (left) rtcIntersect16(rays->valid, made->scene, &rays->scattered, &rays->rays);
  return left;
}

void path_follow(const tracer *made, packet *rays) {
  meeting met[PACKET];
  begin(made, rays);
  for (uint32_t bounce = 0;; bounce++) {
    arrive(made, rays, met);
    direct_add_lights(made, rays, met, bounce == 0 ? &rays->context : &rays->scattered);
    if (bounce == made->transport.bounces || !go_on(made, rays, met)) return;
  }
}

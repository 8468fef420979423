#include "direct.h"

#include "lobe.h"
#include "rows.h"
#include "vectorise.h"

/* What the lanes' surfaces scatter of a light to the eye, but for its cosine. */
ASC_VECTORISE static void find_scattering(const packet *rays, const meetings *met, vectors *shares) {
  for (uint32_t i = 0; i < PACKET; i++)
    for (int channel = 0; channel < 3; channel++)
      shares->row[channel][i] =
          rays->throughput.row[channel][i] * met->colour.row[channel][i] * met->albedo.row[channel][i];
}

/* Sets the shadow rays, and which lanes have one; gives what they weigh where nothing is between: the cosine and the
 * fall-off. */
ASC_VECTORISE static void set_shadow_rays(packet *rays, const meetings *met, const light_ways *ways, scalars *weights) {
  struct RTCRay16 *ray = &rays->shadows;
  for (uint32_t i = 0; i < PACKET; i++) {
    const double normal[3] = {met->normal.row[0][i], met->normal.row[1][i], met->normal.row[2][i]};
    const double toward[3] = {ways->toward.row[0][i], ways->toward.row[1][i], ways->toward.row[2][i]};
    const double cosine = dot(normal, toward), arriving = ways->arriving[i];
    weights->of[i] = cosine * arriving;
    rays->shadowed[i] = -((cosine > 0.0) & (arriving != 0.0));
    ray->org_x[i] = (float)met->lifted.row[0][i];
    ray->org_y[i] = (float)met->lifted.row[1][i];
    ray->org_z[i] = (float)met->lifted.row[2][i];
    ray->dir_x[i] = (float)toward[0];
    ray->dir_y[i] = (float)toward[1];
    ray->dir_z[i] = (float)toward[2];
    ray->tfar[i] = (float)ways->distance[i];
  }
}

/* Embree sets tfar to -inf where a shadow ray is blocked. */
ASC_VECTORISE static void add_unblocked(packet *rays, const vectors *shares, const double intensity[3],
                                        const scalars *weights) {
  for (uint32_t i = 0; i < PACKET; i++) {
    const int reaches = (rays->shadowed[i] != 0) & !(rays->shadows.tfar[i] < 0.0f);
    const double weight = reaches ? weights->of[i] : 0.0;
    for (int channel = 0; channel < 3; channel++)
      rays->gathered.row[channel][i] += shares->row[channel][i] * intensity[channel] * weight;
  }
}

/* Drops the shadow rays that endless planes block. */
static void drop_blocked(const tracer *made, packet *rays, const meetings *met, const light_ways *ways) {
  for (uint32_t i = 0; i < PACKET; i++) {
    double origin[3], toward[3];
    if (!rays->shadowed[i]) continue;
    get_lane(&met->lifted, i, origin);
    get_lane(&ways->toward, i, toward);
    if (meeting_planes_block(made, rays->time[i], origin, toward, ways->distance[i])) rays->shadowed[i] = 0;
  }
}

/* Traces the shadow rays. Gives how many there are. */
static int trace_shadows(const tracer *made, packet *rays, struct RTCIntersectContext *context) {
  int count = 0;
  for (uint32_t i = 0; i < PACKET; i++) count -= rays->shadowed[i];
  if (count > 0) rtcOccluded16(rays->shadowed, made->scene, context, &rays->shadows);
  rays->counts.shadow += (uint64_t)count;
  return count;
}

static void take_numbers(const packet *rays, uint32_t first, pairs *u) {
  for (uint32_t i = 0; i < PACKET; i++) {
    u->row[0][i] = rays->further[i][first];
    u->row[1][i] = rays->further[i][first + 1];
  }
}

static void add_light(const tracer *made, packet *rays, const light_source *from, const meetings *met,
                      const vectors *shares, struct RTCIntersectContext *context) {
  pairs u;
  light_ways ways;
  scalars weights;
  if (light_has_area(&from->given)) take_numbers(rays, from->numbers, &u);
  light_toward(from, &u, &met->point, &ways);
  set_shadow_rays(rays, met, &ways, &weights);
  if (made->plane_count > 0) drop_blocked(made, rays, met, &ways);
  if (trace_shadows(made, rays, context)) add_unblocked(rays, shares, from->given.intensity, &weights);
}

void direct_add_lights(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context) {
  vectors shares;
  if (made->light_count == 0) return;
  find_scattering(rays, met, &shares);
  for (size_t i = 0; i < made->light_count; i++) add_light(made, rays, &made->lights[i], met, &shares, context);
}

double direct_share_of_rays(const tracer *made, double density_of_ray, double density_of_emitter) {
  if (!(density_of_emitter > 0.0) || made->transport.emission_from == FROM_RAYS) return 1.0;
  if (made->transport.emission_from == FROM_EMITTERS) return 0.0;
  return density_of_ray / (density_of_ray + density_of_emitter);
}

static void set_shadow_ray(packet *rays, uint32_t lane, const double origin[3], const double toward[3],
                           double distance) {
  struct RTCRay16 *ray = &rays->shadows;
  ray->org_x[lane] = (float)origin[0];
  ray->org_y[lane] = (float)origin[1];
  ray->org_z[lane] = (float)origin[2];
  ray->dir_x[lane] = (float)toward[0];
  ray->dir_y[lane] = (float)toward[1];
  ray->dir_z[lane] = (float)toward[2];
  ray->tfar[lane] = (float)distance;
}

/* What of the radiance along a way reaches the eye, in a steradian, less what rays will find. */
static void weigh(const tracer *made, const packet *rays, uint32_t lane, const meeting *met, const double way[3],
                  double cosine, double density, double share[3]) {
  const path *from = &rays->paths[lane];
  const asc_material *material = met->material;
  double scattered = 0.0, reflected = 0.0;
  if (from->scatters_left > 0) {
    const double value = cosine / ASC_PI;
    scattered = value * (1.0 - direct_share_of_rays(made, from->scatter * value, density));
  }
  if (from->mirror > 0.0 && material->gloss.kind != ASC_LOBE_MIRROR) {
    double to_eye[3], direction[3];
    get_lane(&rays->direction, lane, direction);
    const double length = sqrt(dot(direction, direction));
    for (int i = 0; i < 3; i++) to_eye[i] = -direction[i] / length;
    const lobe_at towards = lobe_towards(&material->gloss, met->normal, to_eye, way);
    reflected = towards.value * (1.0 - direct_share_of_rays(made, from->mirror * towards.density, density));
  }
  for (int channel = 0; channel < 3; channel++)
    share[channel] =
        rays->throughput.row[channel][lane] *
        (met->colour[channel] * material->albedo[channel] * scattered + material->reflection[channel] * reflected);
}

/* The shadow ray of a lane to a place on a surface that shines, and what that gives where nothing is between. Gives 0
 * where it is nothing. */
static int towards_emitter(const tracer *made, packet *rays, uint32_t lane, const meeting *met, double gives[3]) {
  emitter_place chosen;
  double end[3], way[3], share[3];
  const path *from = &rays->paths[lane];
  if (!(from->mirror > 0.0) && !(from->scatter > 0.0)) return 0;
  const double *origin = met->lifted, *u = rays->further[lane] + made->further.emitter;
  if (!emitter_choose(made, rays->time[lane], u, origin, &chosen)) return 0;
  /* It ends as far from the other surface as it starts from this one. */
  meeting_lift(chosen.point, chosen.normal, chosen.slack, end);
  for (int i = 0; i < 3; i++) way[i] = end[i] - origin[i];
  const double distance = sqrt(dot(way, way));
  for (int i = 0; i < 3; i++) way[i] /= distance;
  const double cosine = dot(met->normal, way);
  if (!(cosine > 0.0) || !(dot(chosen.normal, way) < 0.0)) return 0;
  weigh(made, rays, lane, met, way, cosine, chosen.density, share);
  double largest = 0.0;
  for (int channel = 0; channel < 3; channel++) {
    gives[channel] = share[channel] * chosen.radiance[channel] / chosen.density;
    largest = larger(largest, fabs(gives[channel]));
  }
  if (!(largest > 0.0) || meeting_planes_block(made, rays->time[lane], origin, way, distance)) return 0;
  set_shadow_ray(rays, lane, origin, way, distance);
  return 1;
}

void direct_add_emitters(const tracer *made, packet *rays, const meetings *met, struct RTCIntersectContext *context) {
  double gives[PACKET][3];
  if (made->emitter_count == 0) return;
  for (uint32_t i = 0; i < PACKET; i++) {
    rays->shadowed[i] = 0;
    if (!met->material[i]) continue;
    const meeting here = meeting_of(met, i);
    if (towards_emitter(made, rays, i, &here, gives[i])) rays->shadowed[i] = -1;
  }
  if (!trace_shadows(made, rays, context)) return;
  for (uint32_t i = 0; i < PACKET; i++) {
    if (!rays->shadowed[i] || rays->shadows.tfar[i] < 0.0f) continue;
    for (int channel = 0; channel < 3; channel++) rays->gathered.row[channel][i] += gives[i][channel];
  }
}

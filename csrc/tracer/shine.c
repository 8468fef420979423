#include "shine.h"

#include "arithmetic.h"

/* As many samples are shaded together as have their steps under way at once, and are still in the nearest cache. */
#define TILE 64
typedef double row[TILE];

/* Some samples, and a surface where their rays meet its plane. */
typedef struct tile {
  alignas(64) row u;
  alignas(64) row v; /* where the rays are at distance 1, or all along */
  alignas(64) row distance;
  alignas(64) row point[3]; /* then from the pattern's origin, along the world's axes */
  alignas(64) row mix;      /* the share of the pattern's second colour */
  alignas(64) row nearest;  /* distance, of what is seen so far */
  sample_rows of;
  const asc_view *view;
  const asc_material *material;
} tile;

ASC_VECTORISE static int agree(const struct RTCHit16 *hit) {
  uint32_t geometry = 0, primitive = 0;
  for (int i = 0; i < PACKET; i++) {
    geometry |= hit->geomID[i] ^ hit->geomID[0];
    primitive |= hit->primID[i] ^ hit->primID[0];
  }
  return geometry == 0 && (primitive == 0 || hit->geomID[0] == RTC_INVALID_GEOMETRY_ID);
}

sight shine_see(const tracer *made, const packet *rays) {
  const struct RTCHit16 *hit = &rays->rays.hit;
  if (!(made->plain || made->shines_alone) || rays->lanes < PACKET || !agree(hit)) return (sight){0};
  const uint32_t geometry = hit->geomID[0];
  if (geometry == RTC_INVALID_GEOMETRY_ID) return (sight){1, geometry, 0};
  return (sight){made->plain || geometry != SPHERES, geometry, hit->primID[0]};
}

/* --- one colour -----------------------------------------------------------------------------------------------------
 */

ASC_VECTORISE static void fill(const double from[3], const sample_rows *of) {
  const double colour[4] = {from[0], from[1], from[2], 0.0};
  for (size_t i = 0; i < of->count; i++) memcpy(of->radiance[i], colour, sizeof colour);
}

static void take_colour(const tracer *made, sight seen, const sample_rows *of) {
  if (seen.geometry == RTC_INVALID_GEOMETRY_ID) {
    fill(made->view.background, of);
    return;
  }
  const surface met = tracer_surface(made, seen.geometry, seen.primitive);
  fill(made->materials[made->material_of[met.kind][met.number]].emission, of);
}

/* --- patterns -------------------------------------------------------------------------------------------------------
 */

/* As path.c has the rays. */
ASC_VECTORISE static void set_rays(tile *restrict on) {
  const asc_view *view = on->view;
  const double width = view->width, height = view->height, half_width = view->half_width,
               half_height = view->half_height, right = view->shift[0], down = view->shift[1];
  const double *restrict x = on->of.x, *restrict y = on->of.y;
  for (size_t i = 0; i < on->of.count; i++) {
    on->u[i] = (quotient(2.0 * (x[i] - right), width, 1.0 / width) - 1.0) * half_width;
    on->v[i] = (1.0 - quotient(2.0 * (y[i] - down), height, 1.0 / height)) * half_height;
  }
}

/* Where the rays meet a plane. Beside it they are given a distance that is not in front of the eye. */
ASC_VECTORISE static void meet_along(double normal_x, double normal_y, double along, double offset, tile *restrict on) {
  for (size_t i = 0; i < on->of.count; i++) {
    const double u = on->u[i], v = on->v[i];
    const double t = (offset - (normal_x * u + normal_y * v)) / (along == 0.0 ? 1.0 : along);
    on->distance[i] = along == 0.0 ? -1.0 : t;
    on->point[0][i] = u;
    on->point[1][i] = v;
    on->point[2][i] = t;
  }
}

ASC_VECTORISE static void meet_from_eye(const plane *with, tile *restrict on) {
  const plane met = *with;
  for (size_t i = 0; i < on->of.count; i++) {
    const double direction[3] = {on->u[i], on->v[i], 1.0};
    const double along = dot(met.normal, direction);
    const double t = met.offset / (along == 0.0 ? 1.0 : along);
    on->distance[i] = along == 0.0 ? -1.0 : t;
    for (int axis = 0; axis < 3; axis++) on->point[axis][i] = t * direction[axis];
  }
}

ASC_VECTORISE static void meet_from_lens(const plane *with, tile *restrict on) {
  const plane met = *with;
  const double focus_distance = on->view->focus_distance;
  for (size_t i = 0; i < on->of.count; i++) {
    const double origin[3] = {on->of.lens[i][0], on->of.lens[i][1], 0.0};
    const double direction[3] = {on->u[i] - origin[0] / focus_distance, on->v[i] - origin[1] / focus_distance, 1.0};
    const double along = dot(met.normal, direction);
    const double t = (met.offset - dot(met.normal, origin)) / (along == 0.0 ? 1.0 : along);
    on->distance[i] = along == 0.0 ? -1.0 : t;
    for (int axis = 0; axis < 3; axis++) on->point[axis][i] = origin[axis] + t * direction[axis];
  }
}

static void meet(const plane *with, tile *on) {
  if (on->view->projection == ASC_ORTHOGRAPHIC)
    meet_along(with->normal[0], with->normal[1], with->normal[2], with->offset, on);
  else if (on->view->lens_radius > 0.0)
    meet_from_lens(with, on);
  else
    meet_from_eye(with, on);
}

ASC_VECTORISE static void move_to_pattern(tile *restrict on) {
  const asc_view in = *on->view;
  const double *origin = on->material->pattern.origin, from[3] = {origin[0], origin[1], origin[2]};
  for (size_t i = 0; i < on->of.count; i++) {
    const double x = on->point[0][i], y = on->point[1][i], z = on->point[2][i];
    for (int axis = 0; axis < 3; axis++)
      on->point[axis][i] = in.right[axis] * x + in.up[axis] * y + in.forward[axis] * z - from[axis];
  }
}

/* Gives whether all phases are small enough for `cosine`; else sets them alone. */
ASC_VECTORISE static int mix_rings(tile *restrict on) {
  const double scale = on->material->pattern.scale;
  int far = 0;
  for (size_t i = 0; i < on->of.count; i++) {
    const double away[3] = {on->point[0][i], on->point[1][i], on->point[2][i]};
    on->mix[i] = scale * dot(away, away);
    far |= !(fabs(on->mix[i]) <= COSINE_MOST);
  }
  for (size_t i = 0; i < on->of.count && !far; i++) on->mix[i] = 0.5 * (1.0 + cosine(on->mix[i]));
  return !far;
}

ASC_VECTORISE static void mix_checks(tile *restrict on) {
  const double scale = on->material->pattern.scale;
  for (size_t i = 0; i < on->of.count; i++) {
    const double sum = floor(scale * on->point[0][i]) + floor(scale * on->point[1][i]) + floor(scale * on->point[2][i]);
    on->mix[i] = sum - 2.0 * floor(0.5 * sum);
  }
}

static void mix(tile *on) {
  const asc_pattern *pattern = &on->material->pattern;
  if (pattern->kind == ASC_PATTERN_NONE) {
    memset(on->mix, 0, sizeof on->mix);
    return;
  }
  move_to_pattern(on);
  if (pattern->kind == ASC_PATTERN_CHECKER)
    mix_checks(on);
  else if (!mix_rings(on))
    for (size_t i = 0; i < on->of.count; i++) on->mix[i] = 0.5 * (1.0 + cosine_of_any(on->mix[i]));
}

/* --- what is seen ---------------------------------------------------------------------------------------------------
 */

/* A colour, as a vector, of GCC and Clang, as those of a film are. */
typedef double colour __attribute__((vector_size(4 * sizeof(double))));

/* Shows a surface where it lies in front of the eye, and before what was seen so far; or, at first, everywhere. */
ASC_VECTORISE static void show(int everywhere, tile *restrict on) {
  const asc_pattern *pattern = &on->material->pattern;
  const double *low = pattern->low, *high = pattern->high, *shines = on->material->emission;
  const int patterned = pattern->kind != ASC_PATTERN_NONE;
  const colour emission = {shines[0], shines[1], shines[2], 0.0}, one = {1.0, 1.0, 1.0, 1.0}, none = {0.0};
  const colour first = patterned ? (colour){low[0], low[1], low[2], 0.0} : one;
  const colour change = patterned ? (colour){high[0], high[1], high[2], 0.0} - first : none;
  for (size_t i = 0; i < on->of.count; i++) {
    if (!everywhere && !(on->distance[i] > 0.0 && on->distance[i] < on->nearest[i])) continue;
    const colour seen = (first + change * on->mix[i]) * emission;
    memcpy(on->of.radiance[i], &seen, sizeof seen);
    on->nearest[i] = on->distance[i];
  }
}

static void add_surface(const tracer *made, surface of, const plane *with, int everywhere, tile *on) {
  on->material = &made->materials[made->material_of[of.kind][of.number]];
  meet(with, on);
  mix(on);
  show(everywhere, on);
}

static void take_tile(const tracer *made, sight seen, tile *on) {
  set_rays(on);
  if (seen.geometry == RTC_INVALID_GEOMETRY_ID) {
    fill(made->view.background, &on->of);
    for (size_t i = 0; i < on->of.count; i++) on->nearest[i] = INFINITY;
  } else {
    const surface of = tracer_surface(made, seen.geometry, seen.primitive);
    const plane *with = of.kind == TRIANGLES ? &made->triangle_planes[of.number] : &made->disc_planes[of.number];
    add_surface(made, of, with, 1, on);
  }
  for (uint32_t i = 0; i < made->plane_count; i++) add_surface(made, (surface){PLANES, i}, &made->planes[i], 0, on);
}

void shine_take(const tracer *made, sight seen, const sample_rows *of) {
  if (made->plain) {
    take_colour(made, seen, of);
    return;
  }
  tile on;
  on.view = &made->view;
  for (size_t first = 0; first < of->count; first += TILE) {
    on.of = (sample_rows){of->count - first < TILE ? of->count - first : TILE, of->x + first, of->y + first,
                          of->lens + first, of->radiance + first};
    take_tile(made, seen, &on);
  }
}

int shine_take_each(const tracer *made, const packet *rays) {
  const struct RTCHit16 *hit = &rays->rays.hit;
  if (made->plain || !made->shines_alone || rays->lanes < PACKET) return 0;
  for (int i = 0; i < PACKET; i++)
    if (hit->geomID[i] == SPHERES) return 0;
  double radiance[PACKET][4];
  const sample_rows of = {PACKET, rays->sample_x, rays->sample_y, rays->lens, radiance};
  for (uint32_t left = (1u << PACKET) - 1; left;) {
    const int lane = __builtin_ctz(left);
    const uint32_t geometry = hit->geomID[lane], nothing = geometry == RTC_INVALID_GEOMETRY_ID;
    const sight seen = {1, geometry, nothing ? 0 : hit->primID[lane]};
    shine_take(made, seen, &of);
    for (int i = lane; i < PACKET; i++) {
      if (hit->geomID[i] != geometry || (!nothing && hit->primID[i] != seen.primitive)) continue;
      memcpy(rays->radiance[i], radiance[i], sizeof radiance[i]);
      left &= ~(1u << i);
    }
  }
  return 1;
}

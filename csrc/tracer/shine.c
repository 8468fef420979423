#include "shine.h"

#include "arithmetic.h"
#include "eye.h"
#include "surface_pattern.h"

/* As many samples are shaded together as have their steps under way at once, and are still in the nearest cache. */
/* As many samples are shaded together as have their steps under way at once, and are still in the nearest cache; whole
 * packets. */
#define TILE 64
typedef double row[TILE];

/* Some samples, and a surface where their rays meet its plane. */
typedef struct tile {
  alignas(64) row distance;
  alignas(64) row nearest; /* distance, of what is seen so far */
  double *mix;             /* the share of the pattern's second colour */
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

/* Of Embree's geometries. */
static int is_round(const tracer *made, uint32_t geometry) {
  const int of_part = made->parts && geometry != RTC_INVALID_GEOMETRY_ID;
  return (of_part ? made->parts[geometry].kind : geometry) == SPHERES;
}

sight shine_see(const tracer *made, const packet *rays) {
  const struct RTCHit16 *hit = &rays->rays.hit;
  if (!(made->plain || made->shines_alone) || rays->lanes < PACKET || !agree(hit)) return (sight){0};
  const uint32_t geometry = hit->geomID[0];
  if (geometry == RTC_INVALID_GEOMETRY_ID) return (sight){1, geometry, 0};
  return (sight){made->plain || !is_round(made, geometry), geometry, hit->primID[0]};
}

/* --- one surface alone ----------------------------------------------------------------------------------------------
 */

/* The material that is seen; NULL: the background. */
static const asc_material *material_of(const tracer *made, sight seen) {
  if (seen.geometry == RTC_INVALID_GEOMETRY_ID) return NULL;
  const surface met = tracer_surface(made, seen.geometry, seen.primitive);
  return &made->materials[made->material_of[met.kind][met.number]];
}

static int is_alone(const tracer *made) { return made->plain || made->plane_count == 0; }

int shine_paint(const tracer *made, sight seen, paint *found) {
  if (!seen.one || !is_alone(made)) return 0;
  const asc_material *material = material_of(made, seen);
  const asc_pattern *pattern = material && material->pattern.kind != ASC_PATTERN_NONE ? &material->pattern : NULL;
  *found = (paint){.patterned = pattern != NULL};
  for (int channel = 0; channel < 3; channel++) {
    const double shines = material ? material->emission[channel] : made->view.background[channel];
    found->base[channel] = shines * (pattern ? pattern->low[channel] : 1.0);
    if (pattern) found->change[channel] = shines * (pattern->high[channel] - pattern->low[channel]);
  }
  return 1;
}

ASC_VECTORISE static void fill(const double from[3], const sample_rows *of) {
  const double colour[4] = {from[0], from[1], from[2], 0.0};
  for (size_t i = 0; i < of->count; i++) memcpy(of->radiance[i], colour, sizeof colour);
}

static void take_colour(const tracer *made, sight seen, const sample_rows *of) {
  const asc_material *material = material_of(made, seen);
  fill(material ? material->emission : made->view.background, of);
}

/* --- patterns -------------------------------------------------------------------------------------------------------
 */

/* How rays leave the eye; FACING: side by side, square to the plane, which is as far everywhere. */
enum { FACING, SLANTING, FROM_EYE, FROM_LENS };

/* Where a sample's ray meets a plane, and how far away, or, for one along the plane, a distance that is not in front of
 * the eye. As path.c and meeting.c have it. */
ASC_INLINE double meet(int from, const asc_view *view, const plane *met, const sample_rows *of, size_t i,
                       double point[3]) {
  const double u = eye_right(view, of->x[i]), v = eye_up(view, of->y[i]);
  double origin[3] = {0.0, 0.0, 0.0}, direction[3] = {u, v, 1.0}, along, t;
  if (from == FACING || from == SLANTING) {
    along = met->normal[2];
    const double aside = from == FACING ? 0.0 : met->normal[0] * u + met->normal[1] * v;
    t = (met->offset - aside) / (along == 0.0 ? 1.0 : along);
    point[0] = u;
    point[1] = v;
    point[2] = t;
  } else {
    for (int axis = 0; axis < 2 && from == FROM_LENS; axis++) {
      origin[axis] = of->lens[i][axis];
      direction[axis] -= eye_turn(view, origin[axis]);
    }
    along = dot(met->normal, direction);
    const double ahead = from == FROM_LENS ? met->offset - dot(met->normal, origin) : met->offset;
    t = ahead / (along == 0.0 ? 1.0 : along);
    for (int axis = 0; axis < 3; axis++)
      point[axis] = from == FROM_LENS ? origin[axis] + t * direction[axis] : t * direction[axis];
  }
  return along == 0.0 ? -1.0 : t;
}

/* Distances and mixes of all samples, of rings the phases. Gives the most that a phase can be, 0 of other patterns. The
 * loops take copies: what is only pointed to could change with each store. */
ASC_INLINE double meet_all(int from, asc_pattern_kind kind, const plane *with, tile *restrict on) {
  const asc_view view = *on->view;
  const asc_pattern pattern = on->material->pattern;
  const plane met = *with;
  const sample_rows of = on->of;
  double *restrict mix = on->mix;
  double sums[PACKET] = {0.0}, most = 0.0;
  for (size_t first = 0; first < of.count; first += PACKET) {
    ASC_LANES_LOOP
    for (size_t lane = 0; lane < PACKET; lane++) {
      const size_t i = first + lane;
      double point[3];
      on->distance[i] = meet(from, &view, &met, &of, i, point);
      if (kind == ASC_PATTERN_NONE) mix[i] = 0.0;
      if (kind == ASC_PATTERN_CHECKER) mix[i] = pattern_parity(&view, &pattern, point);
      if (kind == ASC_PATTERN_ZONE_PLATE) {
        mix[i] = pattern_phase(&pattern, point);
        sums[lane] += fabs(mix[i]);
      }
    }
  }
  for (size_t lane = 0; lane < PACKET && kind == ASC_PATTERN_ZONE_PLATE; lane++) most += sums[lane];
  return most;
}

ASC_VECTORISE static double meet_none(int from, const plane *with, tile *restrict on) {
  if (from == FACING) return meet_all(FACING, ASC_PATTERN_NONE, with, on);
  if (from == SLANTING) return meet_all(SLANTING, ASC_PATTERN_NONE, with, on);
  if (from == FROM_EYE) return meet_all(FROM_EYE, ASC_PATTERN_NONE, with, on);
  return meet_all(FROM_LENS, ASC_PATTERN_NONE, with, on);
}

ASC_VECTORISE static double meet_checks(int from, const plane *with, tile *restrict on) {
  if (from == FACING) return meet_all(FACING, ASC_PATTERN_CHECKER, with, on);
  if (from == SLANTING) return meet_all(SLANTING, ASC_PATTERN_CHECKER, with, on);
  if (from == FROM_EYE) return meet_all(FROM_EYE, ASC_PATTERN_CHECKER, with, on);
  return meet_all(FROM_LENS, ASC_PATTERN_CHECKER, with, on);
}

ASC_VECTORISE static double meet_rings(int from, const plane *with, tile *restrict on) {
  if (from == FACING) return meet_all(FACING, ASC_PATTERN_ZONE_PLATE, with, on);
  if (from == SLANTING) return meet_all(SLANTING, ASC_PATTERN_ZONE_PLATE, with, on);
  if (from == FROM_EYE) return meet_all(FROM_EYE, ASC_PATTERN_ZONE_PLATE, with, on);
  return meet_all(FROM_LENS, ASC_PATTERN_ZONE_PLATE, with, on);
}

ASC_VECTORISE static void mix_rings(size_t count, double *mix) {
  for (size_t first = 0; first < count; first += PACKET) {
    ASC_LANES_LOOP
    for (size_t i = first; i < first + PACKET; i++) mix[i] = havercosine(mix[i]);
  }
}

static void meet_pattern(const plane *with, tile *on) {
  const asc_view *view = on->view;
  const int facing = with->normal[0] == 0.0 && with->normal[1] == 0.0 ? FACING : SLANTING;
  const int from = view->projection == ASC_ORTHOGRAPHIC ? facing : view->lens_radius > 0.0 ? FROM_LENS : FROM_EYE;
  switch (on->material->pattern.kind) {
  case ASC_PATTERN_NONE: (void)meet_none(from, with, on); return;
  case ASC_PATTERN_CHECKER: (void)meet_checks(from, with, on); return;
  case ASC_PATTERN_ZONE_PLATE:
    if (meet_rings(from, with, on) <= HAVERCOSINE_MOST)
      mix_rings(on->of.count, on->mix);
    else
      for (size_t i = 0; i < on->of.count; i++) on->mix[i] = havercosine_of_any(on->mix[i]);
  }
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

static const plane *flat_of(const tracer *made, sight seen) {
  const surface of = tracer_surface(made, seen.geometry, seen.primitive);
  return of.kind == TRIANGLES ? &made->triangle_planes[of.number] : &made->disc_planes[of.number];
}

static void take_tile(const tracer *made, sight seen, tile *on) {
  on->material = material_of(made, seen);
  if (on->material) {
    meet_pattern(flat_of(made, seen), on);
    show(1, on);
  } else {
    fill(made->view.background, &on->of);
    for (size_t i = 0; i < on->of.count; i++) on->nearest[i] = INFINITY;
  }
  for (uint32_t i = 0; i < made->plane_count; i++) {
    on->material = &made->materials[made->material_of[PLANES][i]];
    meet_pattern(&made->planes[i], on);
    show(0, on);
  }
}

/* Some of the samples. */
static sample_rows tile_of(const sample_rows *of, size_t first) {
  return (sample_rows){of->count - first < TILE ? of->count - first : TILE, of->x + first, of->y + first,
                       of->lens + first, of->radiance + first};
}

void shine_take(const tracer *made, sight seen, const sample_rows *of) {
  if (made->plain) {
    take_colour(made, seen, of);
    return;
  }
  alignas(64) row mix;
  tile on;
  on.view = &made->view;
  on.mix = mix;
  for (size_t first = 0; first < of->count; first += TILE) {
    on.of = tile_of(of, first);
    take_tile(made, seen, &on);
  }
}

void shine_mix(const tracer *made, sight seen, const sample_rows *of, double *mix) {
  tile on;
  on.view = &made->view;
  on.material = material_of(made, seen);
  for (size_t first = 0; first < of->count; first += TILE) {
    on.of = tile_of(of, first);
    on.mix = mix + first;
    meet_pattern(flat_of(made, seen), &on);
  }
}

int shine_take_each(const tracer *made, const packet *rays) {
  const struct RTCHit16 *hit = &rays->rays.hit;
  if (made->plain || !made->shines_alone || rays->lanes < PACKET) return 0;
  for (int i = 0; i < PACKET; i++)
    if (is_round(made, hit->geomID[i])) return 0;
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

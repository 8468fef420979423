#include "lobe.h"

#include "arithmetic.h"
#include "concentric.h"
#include "vectorise.h"

#define COSINE_LEAST 1e-9 /* seen along the surface itself, a lobe has no direction */

ASC_INLINE void take(const vectors *of, uint32_t lane, double v[3]) {
  for (int i = 0; i < 3; i++) v[i] = of->row[i][lane];
}

ASC_INLINE void put(vectors *of, uint32_t lane, const double v[3]) {
  for (int i = 0; i < 3; i++) of->row[i][lane] = v[i];
}

ASC_INLINE void mirror(const double normal[3], const double to_eye[3], double mirrored[3]) {
  const double along = 2.0 * dot(normal, to_eye);
  for (int i = 0; i < 3; i++) mirrored[i] = along * normal[i] - to_eye[i];
}

/* What is 0 stays so. */
ASC_INLINE void normalise(double v[3]) {
  const double length = sqrt(dot(v, v)), one = length > 0.0 ? 1.0 / length : 1.0;
  for (int i = 0; i < 3; i++) v[i] *= one;
}

ASC_VECTORISE static void cosine_ways(const vectors *restrict normal, const pairs *restrict u, vectors *restrict way) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double numbers[2] = {u->row[0][lane], u->row[1][lane]};
    const double axis[3] = {normal->row[0][lane], normal->row[1][lane], normal->row[2][lane]};
    double a[3], b[3], disc[2];
    const double radius = asc_to_disc(numbers, disc), height = sqrt((1.0 - radius) * (1.0 + radius));
    across(axis, a, b);
    for (int i = 0; i < 3; i++) way->row[i][lane] = disc[0] * a[i] + disc[1] * b[i] + height * axis[i];
  }
}

void lobe_cosine(const vectors *normal, const pairs *u, vectors *way) { cosine_ways(normal, u, way); }

/* --- Phong ----------------------------------------------------------------------------------------------------------
 */

/* cos^(exponent + 1) of the angle to the axis is uniform; so is the square of a disc's radius, and its angle serves.
 * The density is (exponent + 1) / (2 pi) cos^exponent. */
ASC_VECTORISE static void phong_sample(double exponent, const vectors *restrict normals, const vectors *restrict to_eye,
                                       const pairs *restrict u, lobe_ways *restrict ways) {
  const double root = 1.0 / (exponent + 1.0), scale = (exponent + 1.0) / (2.0 * ASC_PI);
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double numbers[2] = {u->row[0][lane], u->row[1][lane]};
    double normal[3], eye[3], axis[3], a[3], b[3], disc[2], way[3];
    take(normals, lane, normal);
    take(to_eye, lane, eye);
    mirror(normal, eye, axis);
    const double radius = asc_to_disc(numbers, disc);
    const double versine = -exponential_less_one(root * log_of_one_plus(-radius * radius)), cosine = 1.0 - versine;
    const double sine = sqrt(versine * (1.0 + cosine)), out = radius > 0.0 ? sine / radius : 0.0;
    across(axis, a, b);
    for (int i = 0; i < 3; i++) way[i] = out * (disc[0] * a[i] + disc[1] * b[i]) + cosine * axis[i];
    put(&ways->way, lane, way);
    ways->share.of[lane] = dot(normal, way) > 0.0 ? 1.0 : 0.0;
    ways->density.of[lane] = scale * ((1.0 - radius) * (1.0 + radius)) / (cosine > 0.0 ? cosine : 1.0);
  }
}

ASC_VECTORISE static void phong_towards(double exponent, const vectors *restrict normals,
                                        const vectors *restrict to_eye, const vectors *restrict toward,
                                        lobe_at *restrict found) {
  const double scale = (exponent + 1.0) / (2.0 * ASC_PI);
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    double normal[3], eye[3], axis[3], way[3];
    take(normals, lane, normal);
    take(to_eye, lane, eye);
    take(toward, lane, way);
    mirror(normal, eye, axis);
    const double cosine = dot(axis, way);
    const int seen = (dot(normal, way) > 0.0) & (cosine > 0.0);
    const double base = seen ? cosine : 1.0, density = scale * power_of_fraction(base < 1.0 ? base : 1.0, exponent);
    found->value.of[lane] = found->density.of[lane] = seen ? density : 0.0;
  }
}

/* --- GGX ------------------------------------------------------------------------------------------------------------
 */

/* Of a surface, and a way from it to the eye: z along the normal. */
typedef struct frame {
  double axes[3][3], eye[3];
} frame;

ASC_INLINE void into_frame(const frame *to, const double v[3], double local[3]) {
  for (int i = 0; i < 3; i++) local[i] = dot(to->axes[i], v);
}

ASC_INLINE frame frame_of(const vectors *normals, const vectors *to_eye, uint32_t lane) {
  frame made;
  double eye[3];
  take(normals, lane, made.axes[2]);
  across(made.axes[2], made.axes[0], made.axes[1]);
  take(to_eye, lane, eye);
  into_frame(&made, eye, made.eye);
  made.eye[2] = larger(made.eye[2], COSINE_LEAST);
  return made;
}

/* Smith's Lambda for GGX; above the surface. */
ASC_INLINE double hidden(double alpha, const double local[3]) {
  const double squared = local[2] * local[2];
  const double tangent = (local[0] * local[0] + local[1] * local[1]) / (squared > 0.0 ? squared : 1.0);
  return 0.5 * (sqrt(1.0 + alpha * alpha * tangent) - 1.0);
}

/* The microfacets' distribution of slopes, over the solid angle of their normal. */
ASC_INLINE double ggx_facets(double alpha, const double half[3]) {
  const double squared = alpha * alpha;
  const double spread = squared * half[2] * half[2] + half[0] * half[0] + half[1] * half[1];
  const double whole = ASC_PI * spread * spread;
  return squared / (whole > 0.0 ? whole : 1.0); /* a way straight back from below has no half */
}

/* Normals that are seen from a direction (Heitz 2018, "Sampling the GGX distribution of visible normals", listing 1).
 */
ASC_INLINE void ggx_normal(double alpha, const double eye[3], const double u[2], double half[3]) {
  double stretched[3] = {alpha * eye[0], alpha * eye[1], eye[2]}, b[3], disc[2];
  normalise(stretched);
  /* The listing's second axis points up the surface, so that the half of the disc below it is squeezed. */
  const double out = sqrt(stretched[0] * stretched[0] + stretched[1] * stretched[1]), one = out > 0.0 ? 1.0 / out : 0.0;
  const double a[3] = {out > 0.0 ? -stretched[1] * one : 1.0, stretched[0] * one, 0.0};
  cross(stretched, a, b);
  (void)asc_to_disc(u, disc);
  const double share = 0.5 * (1.0 + stretched[2]);
  const double side = (1.0 - share) * sqrt(larger(1.0 - disc[0] * disc[0], 0.0)) + share * disc[1];
  const double rest = sqrt(larger(1.0 - disc[0] * disc[0] - side * side, 0.0));
  for (int i = 0; i < 3; i++) half[i] = disc[0] * a[i] + side * b[i] + rest * stretched[i];
  half[0] *= alpha;
  half[1] *= alpha;
  half[2] = larger(half[2], 0.0);
  normalise(half);
}

ASC_VECTORISE static void ggx_sample(double alpha, const vectors *restrict normals, const vectors *restrict to_eye,
                                     const pairs *restrict u, lobe_ways *restrict ways) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const double numbers[2] = {u->row[0][lane], u->row[1][lane]};
    const frame surface = frame_of(normals, to_eye, lane);
    double half[3], local[3], way[3];
    ggx_normal(alpha, surface.eye, numbers, half);
    mirror(half, surface.eye, local);
    for (int i = 0; i < 3; i++)
      way[i] = local[0] * surface.axes[0][i] + local[1] * surface.axes[1][i] + local[2] * surface.axes[2][i];
    put(&ways->way, lane, way);
    const double masked = 1.0 + hidden(alpha, surface.eye);
    const double share = masked / (masked + hidden(alpha, local));
    ways->share.of[lane] = ((local[2] > 0.0) & (dot(surface.axes[2], way) > 0.0)) ? share : 0.0;
    ways->density.of[lane] = ggx_facets(alpha, half) / (4.0 * surface.eye[2] * masked);
  }
}

ASC_VECTORISE static void ggx_towards(double alpha, const vectors *restrict normals, const vectors *restrict to_eye,
                                      const vectors *restrict toward, lobe_at *restrict found) {
  for (uint32_t lane = 0; lane < PACKET; lane++) {
    const frame surface = frame_of(normals, to_eye, lane);
    double way[3], local[3], half[3];
    take(toward, lane, way);
    into_frame(&surface, way, local);
    for (int i = 0; i < 3; i++) half[i] = surface.eye[i] + local[i];
    normalise(half);
    const double masked = 1.0 + hidden(alpha, surface.eye), facets = ggx_facets(alpha, half) / (4.0 * surface.eye[2]);
    const int seen = dot(surface.axes[2], way) > 0.0;
    found->value.of[lane] = seen ? facets / (masked + hidden(alpha, local)) : 0.0;
    found->density.of[lane] = seen ? facets / masked : 0.0;
  }
}

void lobe_towards(const asc_lobe *lobe, const vectors *normal, const vectors *to_eye, const vectors *toward,
                  lobe_at *found) {
  if (lobe->kind == ASC_LOBE_GGX)
    ggx_towards(lobe->roughness, normal, to_eye, toward, found);
  else
    phong_towards(lobe->exponent, normal, to_eye, toward, found);
}

void lobe_sample(const asc_lobe *lobe, const vectors *normal, const vectors *to_eye, const pairs *u, lobe_ways *ways) {
  if (lobe->kind == ASC_LOBE_GGX)
    ggx_sample(lobe->roughness, normal, to_eye, u, ways);
  else
    phong_sample(lobe->exponent, normal, to_eye, u, ways);
}

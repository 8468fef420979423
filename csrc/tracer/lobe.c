#include "lobe.h"

#include "concentric.h"
#include "vectorise.h"

#define COSINE_LEAST 1e-9 /* seen along the surface itself, a lobe has no direction */

static void mirror(const double normal[3], const double to_eye[3], double mirrored[3]) {
  const double along = 2.0 * dot(normal, to_eye);
  for (int i = 0; i < 3; i++) mirrored[i] = along * normal[i] - to_eye[i];
}

static void normalise(double v[3]) {
  const double length = sqrt(dot(v, v));
  for (int i = 0; i < 3; i++) v[i] /= length;
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

/* cos^(exponent + 1) of the angle to the axis is uniform; so is the square of a disc's radius, and its angle serves. */
static void phong_sample(double exponent, const double axis[3], const double u[2], double way[3]) {
  double a[3], b[3], disc[2];
  const double radius = asc_to_disc(u, disc);
  const double logarithm = log1p(-radius * radius) / (exponent + 1.0);
  const double sine = sqrt(-expm1(2.0 * logarithm)), out = radius > 0.0 ? sine / radius : 0.0;
  across(axis, a, b);
  for (int i = 0; i < 3; i++) way[i] = out * (disc[0] * a[i] + disc[1] * b[i]) + exp(logarithm) * axis[i];
}

/* The surface's frame: z along the normal. */
typedef struct frame {
  double axes[3][3];
} frame;

static frame frame_of(const double normal[3]) {
  frame made;
  across(normal, made.axes[0], made.axes[1]);
  for (int i = 0; i < 3; i++) made.axes[2][i] = normal[i];
  return made;
}

static void into_frame(const frame *to, const double v[3], double local[3]) {
  for (int i = 0; i < 3; i++) local[i] = dot(to->axes[i], v);
}

/* Smith's Lambda for GGX. */
static double hidden(double alpha, const double local[3]) {
  const double tangent = (local[0] * local[0] + local[1] * local[1]) / (local[2] * local[2]);
  return 0.5 * (sqrt(1.0 + alpha * alpha * tangent) - 1.0);
}

/* The microfacets' distribution of slopes, over the solid angle of their normal. */
static double ggx_facets(double alpha, const double half[3]) {
  const double squared = alpha * alpha;
  const double spread = squared * half[2] * half[2] + half[0] * half[0] + half[1] * half[1];
  return squared / (ASC_PI * spread * spread);
}

/* Normals that are seen from a direction (Heitz 2018, "Sampling the GGX distribution of visible normals", listing 1).
 */
static void ggx_normal(double alpha, const double eye[3], const double u[2], double half[3]) {
  double stretched[3] = {alpha * eye[0], alpha * eye[1], eye[2]}, a[3], b[3], disc[2];
  normalise(stretched);
  across(stretched, a, b);
  /* The listing's second axis points up the surface, so that the half of the disc below it is squeezed. */
  const double out = hypot(stretched[0], stretched[1]);
  if (out > 0.0) {
    a[0] = -stretched[1] / out;
    a[1] = stretched[0] / out;
    a[2] = 0.0;
    cross(stretched, a, b);
  }
  (void)asc_to_disc(u, disc);
  const double share = 0.5 * (1.0 + stretched[2]);
  const double side = (1.0 - share) * sqrt(fmax(0.0, 1.0 - disc[0] * disc[0])) + share * disc[1];
  const double rest = sqrt(fmax(0.0, 1.0 - disc[0] * disc[0] - side * side));
  for (int i = 0; i < 3; i++) half[i] = disc[0] * a[i] + side * b[i] + rest * stretched[i];
  half[0] *= alpha;
  half[1] *= alpha;
  half[2] = fmax(0.0, half[2]);
  normalise(half);
}

static double ggx_sample(double alpha, const double normal[3], const double to_eye[3], const double u[2],
                         double way[3]) {
  const frame surface = frame_of(normal);
  double eye[3], half[3], local[3];
  into_frame(&surface, to_eye, eye);
  eye[2] = fmax(eye[2], COSINE_LEAST);
  ggx_normal(alpha, eye, u, half);
  mirror(half, eye, local);
  for (int i = 0; i < 3; i++)
    way[i] = local[0] * surface.axes[0][i] + local[1] * surface.axes[1][i] + local[2] * surface.axes[2][i];
  if (!(local[2] > 0.0)) return 0.0;
  const double masked = 1.0 + hidden(alpha, eye);
  return masked / (masked + hidden(alpha, local));
}

static lobe_at ggx_towards(double alpha, const double normal[3], const double to_eye[3], const double way[3]) {
  const frame surface = frame_of(normal);
  double eye[3], local[3], half[3];
  into_frame(&surface, to_eye, eye);
  into_frame(&surface, way, local);
  eye[2] = fmax(eye[2], COSINE_LEAST);
  for (int i = 0; i < 3; i++) half[i] = eye[i] + local[i];
  normalise(half);
  const double masked = 1.0 + hidden(alpha, eye), facets = ggx_facets(alpha, half) / (4.0 * eye[2]);
  return (lobe_at){facets / (masked + hidden(alpha, local)), facets / masked};
}

lobe_at lobe_towards(const asc_lobe *lobe, const double normal[3], const double to_eye[3], const double way[3]) {
  if (!(dot(normal, way) > 0.0)) return (lobe_at){0.0, 0.0};
  if (lobe->kind == ASC_LOBE_GGX) return ggx_towards(lobe->roughness, normal, to_eye, way);
  double mirrored[3];
  mirror(normal, to_eye, mirrored);
  const double cosine = dot(mirrored, way);
  if (!(cosine > 0.0)) return (lobe_at){0.0, 0.0};
  const double density = (lobe->exponent + 1.0) / (2.0 * ASC_PI) * pow(fmin(cosine, 1.0), lobe->exponent);
  return (lobe_at){density, density};
}

double lobe_sample(const asc_lobe *lobe, const double normal[3], const double to_eye[3], const double u[2],
                   double way[3]) {
  if (lobe->kind == ASC_LOBE_GGX) return ggx_sample(lobe->roughness, normal, to_eye, u, way);
  double mirrored[3];
  mirror(normal, to_eye, mirrored);
  if (lobe->kind == ASC_LOBE_PHONG)
    phong_sample(lobe->exponent, mirrored, u, way);
  else
    for (int i = 0; i < 3; i++) way[i] = mirrored[i];
  return dot(normal, way) > 0.0 ? 1.0 : 0.0;
}

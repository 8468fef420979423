/* The samplers: a spec, N, dimensions, seed, pixel and range out of the bytes. What is made is resolved, and filled
 * whole, in pieces, and with its neighbours: the same bits, all in [0, 1). */
#include "bytes.h"

enum {
  MOST_SAMPLES = 256,
  SLOW_SAMPLES = 24,
  MOST_DIMENSIONS = 24,
  MOST_ROWS = 64,
  MOST_VALUES = MOST_ROWS * MOST_DIMENSIONS
};

/* Each point of these needs all before it. */
static int is_slow(const char *spec) {
  return strncmp(spec, "best-candidate", 14) == 0 || strncmp(spec, "blue-noise", 10) == 0 ||
         strncmp(spec, "poisson-disk", 12) == 0;
}

/* Of N points, in no more time than a fuzzer has. */
static uint64_t take_samples(bytes *from, const char *name) {
  const uint64_t count = take_count(from);
  const uint64_t most = is_slow(name) ? SLOW_SAMPLES : MOST_SAMPLES;
  /* Past what can be made they are to be refused, and those that have no table of points are made as quickly. */
  static const char *const without_table[] = {"random", "regular", "jittered", "halton",    "sobol",
                                              "r2",     "pmj02",   "zaremba",  "hammersley"};
  for (size_t i = 0; i < sizeof without_table / sizeof *without_table; i++)
    if (strcmp(name, without_table[i]) == 0) return count;
  if (strcmp(name, "lattice") == 0 && count > 1 << 20) return count; /* known numbers, or too many */
  return count > ((uint64_t)1 << 53) ? count : count % (most + 1);
}

/* Values of a range, in memory of their own length. NULL where the sampler has no such. */
static double *filled(const asc_sampler *sampler, const asc_range *range, size_t pixels, const char *spec) {
  const size_t count = pixels * range->sample_count * range->dimension_count;
  double *points = malloc(count ? count * sizeof *points : 1);
  require(points != NULL, "no memory");
  const asc_status status =
      pixels == 1 ? asc_sampler_fill(sampler, range, points) : asc_sampler_fill_pixels(sampler, range, pixels, points);
  if (status) {
    require(status == ASC_UNSUPPORTED, "%s: fill: %s", spec, asc_status_text(status));
    free(points);
    return NULL;
  }
  for (size_t i = 0; i < count; i++)
    require(points[i] >= 0.0 && (float)points[i] < 1.0f, "%s: value %zu is %g", spec, i, points[i]);
  return points;
}

/* Each sample and dimension alone has the bits that it has in the whole. */
static void check_pieces(const asc_sampler *sampler, const asc_range *range, const double *whole, const char *spec,
                         bytes *from) {
  const size_t d = range->dimension_count;
  for (int tries = 0; tries < 4 && range->sample_count && d; tries++) {
    asc_range piece = *range;
    const uint32_t row = take_below(from, (uint32_t)range->sample_count);
    const uint32_t column = take_below(from, (uint32_t)d);
    piece.first_sample += row;
    piece.sample_count = 1 + take_below(from, (uint32_t)range->sample_count - row);
    piece.first_dimension += column;
    piece.dimension_count = 1 + take_below(from, (uint32_t)d - column);
    double *points = filled(sampler, &piece, 1, spec);
    require(points != NULL, "%s: a part of what there is is not there", spec);
    for (size_t i = 0; i < piece.sample_count; i++)
      require(memcmp(points + i * piece.dimension_count, whole + (row + i) * d + column,
                     piece.dimension_count * sizeof *points) == 0,
              "%s: sample %zu has other bits in a piece", spec, row + i);
    free(points);
  }
}

/* A row of pixels at once is what each is alone. */
static void check_pixels(const asc_sampler *sampler, const asc_range *range, const char *spec) {
  enum { PIXELS = 3 };
  if (range->pixel_x > INT32_MAX - PIXELS) return;
  double *row = filled(sampler, range, PIXELS, spec);
  require(row != NULL, "%s: not in a row of pixels", spec);
  const size_t count = range->sample_count * range->dimension_count;
  for (int p = 0; p < PIXELS; p++) {
    asc_range one = *range;
    one.pixel_x += p;
    double *points = filled(sampler, &one, 1, spec);
    require(points && memcmp(points, row + (size_t)p * count, count * sizeof *row) == 0, "%s: other bits in a row",
            spec);
    free(points);
  }
  free(row);
}

static void check_weights(const asc_sampler *sampler, uint64_t samples, const asc_range *range, const char *spec) {
  double weights[MOST_ROWS];
  const asc_status status = asc_sampler_weights(sampler, range->first_sample, range->sample_count, weights);
  require(status == ASC_OK, "%s: weights: %s", spec, asc_status_text(status));
  for (size_t i = 0; i < range->sample_count; i++)
    require(isfinite(weights[i]) && weights[i] > 0.0, "%s: weight %zu is %g of %llu", spec, i, weights[i],
            (unsigned long long)samples);
}

static void check_resolved(const asc_sampler *sampler, const asc_sampler_desc *asked) {
  asc_sampler_desc resolved;
  require(asc_sampler_resolved(sampler, &resolved) == ASC_OK, "not resolved");
  require(resolved.samples == (asked->samples ? asked->samples : 1), "%s: another N", asked->spec);
  require(resolved.dimensions == (asked->dimensions ? asked->dimensions : 2), "%s: other dimensions", asked->spec);
  require(resolved.seed == asked->seed, "%s: another seed", asked->spec);
  asc_sampler *again = NULL;
  require(asc_sampler_create(&resolved, &again, NULL) == ASC_OK, "\"%s\" is not made again", resolved.spec);
  asc_sampler_desc twice;
  require(asc_sampler_resolved(again, &twice) == ASC_OK && strcmp(twice.spec, resolved.spec) == 0, "\"%s\": another",
          resolved.spec);
  require(asc_sampler_traits(again) == asc_sampler_traits(sampler), "\"%s\": other traits", resolved.spec);
  asc_sampler_destroy(again);
}

/* Anywhere in a sequence; of what has N points about the two ends, past which nothing is there. */
static asc_range take_range(bytes *from, const asc_sampler *sampler, const char *spec) {
  asc_sampler_desc resolved;
  require(asc_sampler_resolved(sampler, &resolved) == ASC_OK, "not resolved");
  const int sequence = (asc_sampler_traits(sampler) & ASC_TRAIT_SEQUENCE) != 0;
  const uint64_t first = take_count(from), past = sequence ? UINT64_MAX : resolved.samples + 2;
  asc_range range = {.pixel_x = (int32_t)take(from, 4), .pixel_y = (int32_t)take(from, 4)};
  range.first_dimension = take_below(from, resolved.dimensions);
  range.dimension_count = take_below(from, resolved.dimensions - range.first_dimension + 1);
  range.first_sample = first % past;
  range.sample_count = take_below(from, MOST_ROWS + 1);
  if (!is_slow(spec)) return range;
  range.sample_count %= SLOW_SAMPLES;
  if (first < 1 << 24) range.first_sample %= SLOW_SAMPLES;
  return range;
}

static void check(const asc_sampler *sampler, const asc_sampler_desc *desc, bytes *from) {
  asc_sampler_desc resolved;
  require(asc_sampler_resolved(sampler, &resolved) == ASC_OK, "not resolved");
  check_resolved(sampler, desc);
  const asc_range range = take_range(from, sampler, desc->spec);
  const int sequence = (asc_sampler_traits(sampler) & ASC_TRAIT_SEQUENCE) != 0;
  double *whole = filled(sampler, &range, 1, desc->spec);
  require(whole || range.sample_count == 0 || sequence || range.first_sample + range.sample_count > resolved.samples,
          "%s: made with N = %llu, but has no such points", desc->spec, (unsigned long long)resolved.samples);
  if (!whole) return;
  check_pieces(sampler, &range, whole, desc->spec, from);
  check_pixels(sampler, &range, desc->spec);
  check_weights(sampler, resolved.samples, &range, desc->spec);
  free(whole);
}

/* Arranged in groups of dimensions, as renderers ask for them. */
static asc_status arranged(const asc_sampler_desc *desc, bytes *from, asc_sampler **sampler, asc_error *error) {
  uint32_t groups[6];
  asc_arrangement_desc arrangement = {.struct_size = sizeof arrangement,
                                      .spec = desc->spec,
                                      .samples = desc->samples,
                                      .seed = desc->seed,
                                      .groups = groups,
                                      .group_count = 1 + take_below(from, 6),
                                      .arrangement = (asc_arrangement)take_below(from, 3),
                                      .sequential = take_below(from, 2)};
  for (size_t i = 0; i < arrangement.group_count; i++) groups[i] = 1 + take_below(from, 4);
  /* The whole pattern of the pixel is made. */
  if (arrangement.arrangement == ASC_ARRANGEMENT_DECORRELATED) {
    arrangement.samples %= MOST_SAMPLES + 1;
    if (is_slow(desc->spec)) arrangement.samples %= SLOW_SAMPLES;
  }
  return asc_sampler_arrange(&arrangement, sampler, error);
}

static void check_arranged(const asc_sampler *sampler, const char *spec, bytes *from) {
  asc_arrangement_desc made = {.struct_size = sizeof made};
  require(asc_sampler_arranged(sampler, &made) == ASC_OK && made.group_count >= 1, "%s: not arranged", spec);
  const asc_range range = take_range(from, sampler, spec);
  double *whole = filled(sampler, &range, 1, spec);
  if (!whole) return;
  check_pieces(sampler, &range, whole, spec, from);
  check_pixels(sampler, &range, spec);
  free(whole);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes from = {data, size};
  asc_sampler_info info;
  require(asc_sampler_describe(take_below(&from, (uint32_t)asc_sampler_count()), &info) == ASC_OK, "no such sampler");
  char spec[512];
  (void)snprintf(spec, sizeof spec, "%s", info.name);
  take_keys(&from, info.parameters, info.parameter_count, 64.0, spec, sizeof spec);
  const uint64_t samples = take_samples(&from, info.name);
  const asc_sampler_desc desc = {sizeof desc, spec, samples, take_below(&from, MOST_DIMENSIONS), take(&from, 8)};
  const int grouped = take_below(&from, 4) == 3;
  asc_sampler *sampler = NULL;
  asc_error error = {{0}};
  const asc_status status =
      grouped ? arranged(&desc, &from, &sampler, &error) : asc_sampler_create(&desc, &sampler, &error);
  require((status == ASC_OK) == (sampler != NULL), "%s: a sampler with status %d", spec, (int)status);
  if (status) {
    require(status == ASC_UNSUPPORTED || status == ASC_INVALID_VALUE || status == ASC_OUT_OF_MEMORY, "%s: %s", spec,
            error.text);
    require(error.text[0] && memchr(error.text, '\0', sizeof error.text), "%s: refused without a reason", spec);
    return 0;
  }
  if (grouped)
    check_arranged(sampler, spec, &from);
  else
    check(sampler, &desc, &from);
  asc_sampler_destroy(sampler);
  return 0;
}

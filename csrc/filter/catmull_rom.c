/* Catmull and Rom's interpolating cubic: 1 at 0 and 0 at the other whole numbers, and Mitchell and Netravali's filter
 * for B = 0, C = 1/2.
 *
 * Source: Catmull and Rom 1974, "A class of local interpolating splines". */
#include "cubic.h"
#include "profile.h"

static void catmull_rom_evaluate(const double *values, const double *x, size_t n, double *profile) {
  asc_cubic_evaluate(0.0, 0.5, values[0], x, n, profile);
}

static double catmull_rom_primitive(const double *values, double x) {
  return asc_cubic_primitive(0.0, 0.5, values[0], x);
}

static const asc_parameter catmull_rom_parameters[] = {ASC_RADIUS_PARAMETER(2)};

const asc_filter_interface asc_filter_catmull_rom = {
    .struct_size = sizeof(asc_filter_interface),
    .name = "catmull-rom",
    .title = "the interpolating cubic, mitchell with B = 0 and C = 1/2",
    .source = "Catmull and Rom 1974",
    .parameters = catmull_rom_parameters,
    .parameter_count = 1,
    .radius = asc_first_value,
    .pieces = asc_cubic_pieces,
    .evaluate = catmull_rom_evaluate,
    .primitive = catmull_rom_primitive,
};

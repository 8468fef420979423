/* The sample locations of multisampling hardware: 1, 2, 4, 8 or 16 points, in the documented order.
 *
 * Source: Vulkan 1.4 specification, chapter "Rasterization", table "Standard sample locations" (devices that report
 * standardSampleLocations); Direct3D 11, D3D11_STANDARD_MULTISAMPLE_PATTERN, whose offsets from the pixel's centre (in
 * sixteenths, Direct3D 11.3 functional specification, 19.2.4) are the same. Both count y downward from the pixel's
 * upper left corner, as pictures here do (row 0 on top), so nothing is turned. The sets of 2, 4 and 8 have one point in
 * each row and column of their grid; that of 16 has points on the left and upper border.
 *
 * Two dimensions; not randomised: every pixel has the same points. */
#include <stdlib.h>

#include "fixed.h"

static const uint8_t sixteenths[1 + 2 + 4 + 8 + 16][2] = {
    {8, 8},                                                                     /* 1 */
    {12, 12}, {4, 4},                                                           /* 2 */
    {6, 2},   {14, 6}, {2, 10}, {10, 14},                                       /* 4 */
    {9, 5},   {7, 11}, {13, 9}, {5, 3},   {3, 13}, {1, 7},   {11, 15}, {15, 1}, /* 8 */
    {9, 9},   {7, 5},  {5, 10}, {12, 7},  {3, 6},  {10, 13}, {13, 11}, {11, 3}, /* 16 */
    {6, 14},  {8, 1},  {4, 2},  {2, 12},  {0, 8},  {15, 4},  {14, 15}, {1, 0},
};

static const asc_fixed_table table = {"standard-msaa", sixteenths, 16};

static asc_status standard_msaa_create(const asc_sampler_config *config, asc_sampler_state *made, asc_error *error) {
  return asc_fixed_create(&table, config, made, error);
}

const asc_sampler_interface asc_sampler_standard_msaa = {
    .struct_size = sizeof(asc_sampler_interface),
    .name = "standard-msaa",
    .title = "the sample locations of Vulkan and Direct3D",
    .source = "Vulkan specification, Standard sample locations; D3D11_STANDARD_MULTISAMPLE_PATTERN",
    .create = standard_msaa_create,
    .destroy = free,
    .fill = asc_fixed_fill,
};

#include "owen.h"

#define FOUR_TIMES(x)                                                                                                  \
  { x, x, x, x }

const asc_owen_constants asc_owen = {
    .draw = {FOUR_TIMES(0xbf58476d1ce4e5b9u), FOUR_TIMES(0x94d049bb133111ebu)},
    .draw_high = {FOUR_TIMES(0xbf58476du), FOUR_TIMES(0x94d049bbu)},
    .factor = {FOUR_TIMES(0x3d20adeau), FOUR_TIMES(0x05526c56u), FOUR_TIMES(0x53a22864u)},
    .even = FOUR_TIMES(0xfffffffeu),
    .nibbles = FOUR_TIMES(0x0f0f0f0f00000000u),
    .nibble_low = {0x0e060a020c040800u, 0x0f070b030d050901u, 0x0e060a020c040800u, 0x0f070b030d050901u},
    .nibble_high = {0xe060a020c0408000u, 0xf070b030d0509010u, 0xe060a020c0408000u, 0xf070b030d0509010u},
    .one = FOUR_TIMES(0x3ff0000000000000u),
};

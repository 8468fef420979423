/* Generated: .venv/bin/python csrc/sampler/make_sgi_positions.py > csrc/sampler/sgi_positions.h */
#ifndef ASC_SGI_POSITIONS_H
#define ASC_SGI_POSITIONS_H

#include <stdint.h>

/* The centres {x, y} of 1, 2, 4 and 8 cells, in sixteenths, from the upper row to the lower. */
static const uint8_t sgi_positions[1 + 2 + 4 + 8][2] = {
    /* 1: edge discrepancy 0.253739; 4 sets have it, 1 but for the square's symmetries */
    {7, 7},
    /* 2: edge discrepancy 0.158310; 2 sets have it, 1 but for the square's symmetries */
    {5, 5},
    {11, 11},
    /* 4: edge discrepancy 0.087363; 2 sets have it, 1 but for the square's symmetries */
    {5, 3},
    {13, 5},
    {3, 11},
    {11, 13},
    /* 8: edge discrepancy 0.054267; 4 sets have it, 1 but for the square's symmetries */
    {3, 1},
    {13, 3},
    {9, 5},
    {3, 7},
    {13, 9},
    {7, 11},
    {3, 13},
    {13, 15},
};

#endif

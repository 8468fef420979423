/* The unit of work: a block of 4 x 4 pixels, whose 16 N rays are N whole packets.
 *
 * Which rays share a packet follows from the pixel's place and N, not from threads: the same ray in another packet can
 * meet another primitive where two touch. */
#ifndef TRACER_BLOCK_H
#define TRACER_BLOCK_H

#include "tracer.h"

#define BLOCK_SIDE 4u

/* A thread's memory for rays and samples. */
typedef struct block_work block_work;

block_work *block_work_make(void);
void block_work_free(block_work *memory);

/* How many shadow rays were traced with this memory. */
uint64_t block_shadow_rays(const block_work *memory);

/* Renders the pixels of the block at (x, y), as far as they are in the picture. */
asc_status block_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, uint32_t x, uint32_t y,
                        block_work *memory, float *pixels);

#endif

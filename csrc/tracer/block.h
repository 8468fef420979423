/* The unit of work: a block of 4 x 4 pixels, whose 16 N rays are N whole packets.
 *
 * Which rays share a packet follows from the pixel's place and N, not from threads: the same ray in another packet can
 * meet another primitive where two touch. */
#ifndef TRACER_BLOCK_H
#define TRACER_BLOCK_H

#include "film.h"
#include "packet.h"
#include "tracer.h"

#define BLOCK_SIDE 4u

/* A thread's memory for rays and samples of one tracer. */
typedef struct block_work block_work;

block_work *block_work_make(const tracer *made);
void block_work_free(block_work *memory);

/* Its packet, for those who fill it themselves. */
packet *block_packet(block_work *memory);

/* The rays that were traced with this memory, beside those from the eye. */
ray_counts block_rays(const block_work *memory);

/* The pixels [x, x + columns) x [y, y + rows); at most BLOCK_SIDE columns and rows. */
typedef struct block {
  int32_t x, y;
  uint32_t columns, rows;
} block;

/* Renders the pixels of a block that lies in the picture: the mean over each. */
asc_status block_render(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area,
                        block_work *memory, float *pixels);

/* Adds the samples of a block to a film, `cells` being those of its pixels, row by row. */
asc_status block_add(const tracer *made, const asc_sampler *sampler, uint64_t samples, block area, const film *target,
                     const film_pixel *cells, block_work *memory);

#endif

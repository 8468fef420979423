/* Random numbers one after the other, for patterns that are made whole: darts, walks, searches. A stream is a value of
 * its maker's alone, so the pattern still depends on (seed, pixel, pair of dimensions) and nothing else. */
#ifndef ASC_STREAM_H
#define ASC_STREAM_H

#include "hash.h"

typedef struct asc_stream {
  asc_key key;
  uint32_t index; /* which pattern of the pixel: the pair of dimensions, say */
  uint64_t block; /* the next to be hashed */
  uint32_t left;  /* words of `lanes` not yet used */
  asc_lanes lanes;
} asc_stream;

void asc_stream_begin(asc_stream *stream, asc_key key, uint32_t index);

/* 32 random bits. */
uint32_t asc_stream_bits(asc_stream *stream);

/* Uniform on 0 .. bound-1, without bias (Lemire 2019, "Fast random integer generation in an interval"); bound >= 1. */
uint32_t asc_stream_below(asc_stream *stream, uint32_t bound);

/* Uniform in (0, 1), at the centres of 2^32 intervals. */
double asc_stream_unit(asc_stream *stream);

#endif

#include "stream.h"

#define WORDS (4u * ASC_LANES)

void asc_stream_begin(asc_stream *stream, asc_key key, uint32_t index) {
  stream->key = key;
  stream->index = index;
  stream->block = 0;
  stream->left = 0;
}

uint32_t asc_stream_bits(asc_stream *stream) {
  if (stream->left == 0) {
    asc_hash_lanes(stream->key, stream->block, stream->index, ASC_PURPOSE_STREAM_OF_BITS, &stream->lanes);
    stream->block += ASC_LANES;
    stream->left = WORDS;
  }
  const uint32_t used = WORDS - stream->left--;
  return stream->lanes.word[used / ASC_LANES][used % ASC_LANES];
}

uint32_t asc_stream_below(asc_stream *stream, uint32_t bound) {
  const uint32_t reject_below = (0u - bound) % bound;
  for (;;) {
    const uint64_t product = (uint64_t)asc_stream_bits(stream) * bound;
    if ((uint32_t)product >= reject_below) return (uint32_t)(product >> 32);
  }
}

double asc_stream_unit(asc_stream *stream) { return asc_unit32(asc_stream_bits(stream)); }

// Rows of tiles of the picture, as the CPU hands them to programs that draw nothing else.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// Side of a tile. Small, so that little is drawn in vain; a rasteriser's own blocks divide it.
const int kCoverTilePx = 16;
// Bits of a tile's number along x or y: pictures up to 16,384 pixels a side. What lies beyond is
// not drawn.
const uint kCoverBits = 10u;
const uint kCoverMask = 1023u;

// Tiles first to end - 1 of row y, in one word; end - first is stored less 1.
RULE uint packCoverSpan(uint first, uint y, uint end) {
  return (first & kCoverMask) | (y & kCoverMask) << kCoverBits |
         ((end - first - 1u) & kCoverMask) << (2u * kCoverBits);
}

// Corner 0 to 5 of the span's two triangles, pixels.
RULE vec2 coverCorner(uint span, uint corner) {
  uint first = span & kCoverMask;
  uint y = span >> kCoverBits & kCoverMask;
  uint end = first + (span >> (2u * kCoverBits) & kCoverMask) + 1u;
  bool right = corner == 1u || corner == 2u || corner == 4u;
  bool upper = corner == 2u || corner == 4u || corner == 5u;
  return vec2(float(right ? end : first), float(upper ? y + 1u : y)) * float(kCoverTilePx);
}

RULES_END

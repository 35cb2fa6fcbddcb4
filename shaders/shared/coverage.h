// Where an atlas is, packed for programs that read it with image loads. Of coverage and heights a word holds a texel, its
// right, its upper and its upper right neighbour, from the lowest byte up, so that one fetch gives what bilinear reading
// takes; beyond the edge all is the edge's. Of color and normal it holds the four bytes of a texel.
//
// Flat textures of one level. Each view has a place of 3/2 p x p in it: on the left its finest level, right of that the
// others, one above the other. Views stand in columns, so low that the last one, which may be nearly empty, is a small part
// of all, and so high that no atlas is wider than textures may be everywhere.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// p is a power of two, and this too.
const int kCoverageHeightBits = 12;
const int kCoverageMostHeight = 1 << kCoverageHeightBits;

RULE int coverageRows(int p) { return kCoverageMostHeight / p; }
RULE ivec2 coverageSize(int p, int views) {
  int rows = coverageRows(p);
  return ivec2((views + rows - 1) / rows * (p + p / 2), (views < rows ? views : rows) * p);
}
// Lower left texel of a level of a view.
RULE ivec2 coverageBase(int p, int view, int level) {
  int at = view * p;
  ivec2 base = ivec2((at >> kCoverageHeightBits) * (p + (p >> 1)), at & (kCoverageMostHeight - 1));
  return level == 0 ? base : base + ivec2(p, p - (2 * p >> level));
}

// Reading counts in 256ths of a texel, as texture units do. These bits, of a float that is added to such a number, leave
// that in its lowest bits, rounded to even.
const float kCoverageBits = 8388608.0f;
// 256ths of a texel in a level: what texture coordinates are multiplied by.
RULE float coverageSteps(int p, int level) { return float((p >> level) * 256); }
// What is added to them, times the above, after clamping.
RULE vec2 coverageFrom(int p, int view, int level) {
  ivec2 base = coverageBase(p, view, level);
  return vec2(float(base.x), float(base.y)) * 256.0f + vec2(kCoverageBits - 128.0f, kCoverageBits - 128.0f);
}

// Between the four values of a word; `part`: 256ths of the way to the right and up. In [0, 255], rounded after each step.
RULE uint coverageBetween(uint word, uvec2 part) {
  // Two at a time: none of the sums leaves its 16 bits.
  uint left = word & 0xff00ffu, right = word >> 8u & 0xff00ffu;
  uint both = ((left << 8u) + (right - left) * part.x + 0x800080u) >> 8u & 0xff00ffu;
  uint low = both & 0xffffu, high = both >> 16u;
  return ((low << 8u) + (high - low) * part.y + 128u) >> 8u;
}

// The same of each byte of four words, those of a texel and its neighbours as above.
RULE uint coverageHalfway(uint a, uint b, uint part) { return ((a << 8u) + (b - a) * part + 0x800080u) >> 8u & 0xff00ffu; }
RULE uint coverageAcross(uint a, uint b, uint c, uint d, uvec2 part) {
  return coverageHalfway(coverageHalfway(a, b, part.x), coverageHalfway(c, d, part.x), part.y);
}
// In [0, 1].
RULE vec4 coverageBytes(uint word, uint right, uint upper, uint both, uvec2 part) {
  uint even = coverageAcross(word & 0xff00ffu, right & 0xff00ffu, upper & 0xff00ffu, both & 0xff00ffu, part);
  uint odd = coverageAcross(word >> 8u & 0xff00ffu, right >> 8u & 0xff00ffu, upper >> 8u & 0xff00ffu, both >> 8u & 0xff00ffu, part);
  return vec4(float(even & 0xffffu), float(odd & 0xffffu), float(even >> 16u), float(odd >> 16u)) * (1.0f / 255.0f);
}

RULES_END

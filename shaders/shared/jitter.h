// Sub-pixel sample positions for many-sample accumulation.
#pragma once
#include "shared/prelude.h"

RULES_BEGIN

// Offset of sample `index` from the pixel's centre, within [-0.5, 0.5); sample 0 is the centre.
// R2 sequence (Roberts 2018): low-discrepancy for every prefix, so that averages converge faster
// than with random offsets.
RULE vec2 jitterOffset(uint index) {
  // Multiples of 1/g and 1/g^2 (g = plastic number) as 32-bit fixed point wrap without rounding.
  uint x = index * 3242174889u;
  uint y = index * 2447445414u;
  vec2 unit = vec2(float(x >> 8u), float(y >> 8u)) * (1.0f / 16777216.0f) + vec2(0.5f, 0.5f);
  return unit - floor(unit) - vec2(0.5f, 0.5f);
}

RULES_END

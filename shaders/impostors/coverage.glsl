// Reads coverage of an atlas: what textureLod() of its shape gives, at a quarter of the fetches.
#include "shared/bindings.h"
#include "shared/coverage.h"

layout(r32ui, binding = kImpostorCoverageImage) readonly uniform uimage2D atlas_coverage;

// `at`: texture coordinates times coverageSteps(); `from`: coverageFrom().
float coverageAt(vec2 at, float steps, vec2 from) {
  uvec2 bits = floatBitsToUint(clamp(at, 128.0, steps - 128.0) + from);
  uint word = imageLoad(atlas_coverage, ivec2(bits >> 8u & 0x7fffu)).r;
  return float(coverageBetween(word, bits & 255u)) * (1.0 / 255.0);
}

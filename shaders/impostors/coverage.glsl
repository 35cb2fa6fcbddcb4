// Reads coverage of an atlas: what textureLod() of its shape gives, at a quarter of the fetches.
#include "shared/bindings.h"
#include "shared/coverage.h"

layout(r32ui, binding = kImpostorCoverageImage) readonly uniform uimage2D atlas_coverage;

// `at`: texture coordinates times coverageSteps(); `from`: coverageFrom().
uvec2 coverageStep(vec2 at, float steps, vec2 from) { return floatBitsToUint(clamp(at, 128.0, steps - 128.0) + from); }
ivec2 coverageTexel(uvec2 step) { return ivec2(step >> 8u & 0x7fffu); }
float coverageAt(vec2 at, float steps, vec2 from) {
  uvec2 step = coverageStep(at, steps, from);
  uint word = imageLoad(atlas_coverage, coverageTexel(step)).r;
  return float(coverageBetween(word, step & 255u)) * (1.0 / 255.0);
}

// The map of the sun's depth into the shadow map.
#include "shared/bindings.h"
#include "shared/shadow.h"

layout(std430, binding = kSunDepthBinding) readonly buffer SunDepth { uint depth[]; };

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy), size = ivec2(shadow_view.size_px);
  uint key = all(lessThan(texel, size)) ? depth[texel.y * size.x + texel.x] : 0u;
  if (key == 0u) discard;
  gl_FragDepth = uintBitsToFloat(key);
}

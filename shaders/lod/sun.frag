// The map of the sun's depth into the shadow map.
#include "shared/bindings.h"
#include "shared/shadow.h"

layout(std430, binding = kSunDepthBinding) readonly buffer SunDepth { uint depth[]; };

void main() {
  ivec2 texel = ivec2(gl_FragCoord.xy);
  uint key = depth[texel.y * int(shadow_view.size_px.x) + texel.x];
  if (key == 0u) discard;
  gl_FragDepth = uintBitsToFloat(key);
}

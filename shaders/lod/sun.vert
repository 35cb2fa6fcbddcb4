// The tiles of the shadow map that some disc touches, six vertices each, at depth 0.
#include "shared/bindings.h"
#include "shared/shadow.h"
#include "shared/tiles.h"

layout(std430, binding = kSunDepthBinding) readonly buffer SunDepth { uint depth[]; };

void main() {
  int tile = gl_VertexID / 6;
  ivec2 size = ivec2(shadow_view.size_px), tiles = tileCount(size);
  vec2 texel = tileCorner(ivec2(tile % tiles.x, tile / tiles.x), uint(gl_VertexID % 6));
  vec2 clip = min(texel, shadow_view.size_px) * (2.0 / float(kShadowMapSize)) - 1.0;
  gl_Position = depth[size.x * size.y + tile] != 0u ? vec4(clip, 0.0, 1.0) : vec4(2.0, 2.0, 0.0, 1.0);
}

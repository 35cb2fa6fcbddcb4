// Notes which grains the picture shows: they are drawn first in the next frame.
#include "lib/swarm.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = kSwarmSeenBinding) buffer Seen { uint seen[]; };
layout(binding = kPassTextureUnit) uniform usampler2D visible_grains;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, ivec2(view.size_px)))) return;
  uint number = texelFetch(visible_grains, pixel, 0).r;
  uint grain = number - 1u - swarm.first;
  if (number == 0u || grain >= swarm.count) return;
  uint at = grain / 32u, bit = 1u << (grain & 31u);
  if ((seen[at] & bit) == 0u) atomicOr(seen[at], bit);
}

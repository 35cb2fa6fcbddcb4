// The foremost of the points in each pixel.
#include "lib/mark_tiles.glsl"
#include "points/splat.glsl"

layout(std430, binding = kPointKeysBinding) buffer Keys { uint keys[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint grain = run * kRunGrains;
  for (uint word = run * kRunWords; word < (run + 1u) * kRunWords; ++word, grain += 8u) {
    uint all = representations[word];
    for (uint k = 0u; all != 0u; all >>= 4u, ++k) {
      if ((all & 15u) != kPoint) continue;
      Seen seen = seenOf(records[grain + k]);
      if (seen.along == 0.0) continue;
      uint at = uint(seen.pixel_px.y) * uint(view.size_px.x) + uint(seen.pixel_px.x);
      uint key = pointKey(seen.front);
      if (keys[at] >= key) continue;
      // The first of a pixel: points add to the pixels around theirs, too.
      if (keys[at] == 0u) markTiles(ivec2(seen.pixel_px) - 1, ivec2(seen.pixel_px) + 1);
      atomicMax(keys[at], key);
    }
  }
}

// The discs of the grains that are nearest to the sun in their cells, into a map of the sun's depth.
#include "lib/swarm.glsl"
#include "lod/sun.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kSunCellsBinding) readonly buffer SunCells { uint cells[]; };
layout(std430, binding = kSunDepthBinding) buffer SunDepth { uint depth[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint end = min((run + 1u) * kRunGrains, swarm.count);
  ivec2 last = ivec2(shadow_view.size_px) - 1;
  for (uint grain = run * kRunGrains; grain < end; ++grain) {
    Caster caster = casterOf(records[grain]);
    if (caster.key == 0u || cells[sunCell(caster.texel)] != caster.key) continue;
    // Less than a texel wide it takes the one it is in.
    float reach = max(caster.radius, 0.5);
    ivec2 low = max(ivec2(ceil(caster.texel - reach - 0.5)), ivec2(0));
    ivec2 high = min(ivec2(floor(caster.texel + reach - 0.5)), last);
    for (int y = low.y; y <= high.y; ++y)
      for (int x = low.x; x <= high.x; ++x) {
        vec2 off = vec2(x, y) + 0.5 - caster.texel;
        if (dot(off, off) > reach * reach) continue;
        uint at = uint(y * (last.x + 1) + x);
        if (depth[at] < caster.key) atomicMax(depth[at], caster.key);
      }
  }
}

// Discs into the map of the sun's depth; after lod/sun.glsl. Large ones are listed behind the cells, to be drawn by a
// work group each: a single invocation would take too long, and software GL ends it after 65,535 rounds of its loops.
#include "shared/tiles.h"

layout(location = 3) uniform float large_texels;  // a larger radius is large
layout(location = 4) uniform uint list_at;        // in `cells`: the dispatch's work groups, count, discs

layout(std430, binding = kSunCellsBinding) buffer SunCells { uint cells[]; };
layout(std430, binding = kSunDepthBinding) buffer SunDepth { uint depth[]; };  // by texel; then 1 for each tile that is touched

// False if there is no room.
bool list(Caster caster) {
  uint at = atomicAdd(cells[list_at + 3u], 1u);
  if (at >= kMostWorkGroups) return false;
  atomicMax(cells[list_at], at + 1u);
  cells[list_at + 1u] = 1u;
  cells[list_at + 2u] = 1u;
  uint words = list_at + 4u + 4u * at;
  cells[words] = floatBitsToUint(caster.texel.x);
  cells[words + 1u] = floatBitsToUint(caster.texel.y);
  cells[words + 2u] = floatBitsToUint(caster.radius);
  cells[words + 3u] = caster.key;
  return true;
}
Caster listed(uint at) {
  uint words = list_at + 4u + 4u * at;
  Caster caster;
  caster.texel = vec2(uintBitsToFloat(cells[words]), uintBitsToFloat(cells[words + 1u]));
  caster.radius = uintBitsToFloat(cells[words + 2u]);
  caster.key = cells[words + 3u];
  return caster;
}

void markSunTiles(ivec2 low, ivec2 high, ivec2 size) {
  for (int y = low.y; y <= high.y; ++y)
    for (int x = low.x; x <= high.x; ++x) depth[size.x * size.y + y * tileCount(size).x + x] = 1u;
}

// Every `step`th row, from `first` on: texels with their middles in the disc, and that which its own middle is in. A disc
// so small that it holds no texel's middle would otherwise be lost, and with it what it casts for: its cell.
void drawDisc(Caster caster, int first, int step) {
  // The middle of that texel is nearer than any other's. And a little more than floats round.
  vec2 to_own = floor(caster.texel) + 0.5 - caster.texel;
  float reach2 = max(caster.radius * caster.radius, 1.001 * dot(to_own, to_own)), reach = sqrt(reach2) + 0.001;
  ivec2 last = ivec2(shadow_view.size_px) - 1;
  ivec2 low = ivec2(max(ceil(caster.texel - reach - 0.5), vec2(0.0)));
  ivec2 high = ivec2(min(floor(caster.texel + reach - 0.5), vec2(last)));
  if (first == 0) markSunTiles(low / kTilePx, high / kTilePx, last + 1);
  for (int y = low.y + first; y <= high.y; y += step)
    for (int x = low.x; x <= high.x; ++x) {
      vec2 off = vec2(x, y) + 0.5 - caster.texel;
      if (dot(off, off) > reach2) continue;
      uint at = uint(y * (last.x + 1) + x);
      if (depth[at] < caster.key) atomicMax(depth[at], caster.key);
    }
}

// The foremost of the points in each pixel.
#include "lib/mark_tiles.glsl"
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) buffer Keys { uint keys[]; };

#include "points/run_hidden.glsl"

void main() {
  if (gl_GlobalInvocationID.x >= swarm.run_count) return;
  uint run = order[gl_GlobalInvocationID.x], grain = run * kRunGrains, word = run * kRunWords, end = word + kRunWords;
  SwarmRun bounds = runs[run];
  RunSeen place = runSeenOf(bounds);
  float front = max(place.nearest - kMeanFront * bounds.most_radius, view.near_m) * (1.0 - kRunSlack);
  if (allNearer(place, pointKey(front))) word = end;
  for (; word < end; ++word, grain += 8u)
    for (uint points = pointsOf(representations[word]); points != 0u; points &= points - 1u) {
      Seen seen = seenOf(records[grain + (uint(findLSB(points)) >> 2u)]);
      if (seen.along == 0.0) continue;
      uint at = uint(seen.pixel_px.y) * uint(view.size_px.x) + uint(seen.pixel_px.x);
      uint key = pointKey(seen.front);
      if (keys[at] >= key) continue;
      // The first of a pixel: points add to the pixels around theirs, too.
      if (keys[at] == 0u) markTiles(ivec2(seen.pixel_px) - 1, ivec2(seen.pixel_px) + 1);
      atomicMax(keys[at], key);
    }
}

// The foremost of the points in each pixel. Forgets which points were seen before, in a frozen frame too: points.list
// enters them.
#include "lib/mark_tiles.glsl"
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) buffer Keys { uint keys[]; };

#include "points/runs.glsl"

layout(std430, binding = kSwarmCommandsBinding) buffer Commands { SwarmCommands commands; };

void main() {
  if (gl_GlobalInvocationID.x == 0u) {
    commands.seen_points = 0u;
    commands.seen_groups = uint[3](0u, 1u, 1u);
  }
  if (gl_GlobalInvocationID.x >= swarm.run_count) return;
  uint run = order[gl_GlobalInvocationID.x], w = 0u;
  SwarmRun bounds = runs[run];
  RunSeen place = runSeenOf(bounds);
  float rank_bound = rankBound(bounds, place);
  float front = max(place.nearest - kMeanFront * bounds.most_radius, view.near_m) * (1.0 - kRunSlack);
  if (allNearer(place, pointKey(front))) w = kRunWords;
  for (; w < kRunWords; ++w)
    for (uint points = drawnPoints(run, w, rank_bound); points != 0u; points &= points - 1u) {
      uint grain = run * kRunGrains + 8u * w + (uint(findLSB(points)) >> 2u);
      Seen seen = seenOf(records[grain], grain);
      if (seen.along == 0.0) continue;
      uint at = pixelAt(seen);
      uint key = pointKey(seen.front);
      if (keys[at] >= key) continue;
      // The first of a pixel: points add to the pixels around theirs, too.
      if (keys[at] == 0u) markTiles(ivec2(seen.pixel_px) - 1, ivec2(seen.pixel_px) + 1);
      atomicMax(keys[at], key);
    }
}

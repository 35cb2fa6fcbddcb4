// Lists the points that are not hidden: at most a band behind the foremost of their pixel. Their order differs between
// frames, and nothing depends on it.
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) readonly buffer Keys { uint keys[]; };
layout(std430, binding = kSwarmListBinding) writeonly buffer List { uint list[]; };

#include "points/runs.glsl"

layout(std430, binding = kSwarmCommandsBinding) buffer Commands { SwarmCommands commands; };

void main() {
  if (gl_GlobalInvocationID.x >= swarm.run_count) return;
  uint run = order[gl_GlobalInvocationID.x], w = 0u;
  SwarmRun bounds = runs[run];
  RunSeen place = runSeenOf(bounds);
  float rank_bound = rankBound(bounds, place), most_band = pointBand(bounds.most_radius, place.farthest / view.pixels_at_1m);
  float front = (place.nearest - kMeanFront * bounds.most_radius) * (1.0 - kRunSlack) - most_band * (1.0 + kRunSlack);
  if (front > 0.0 && allNearer(place, pointKey(front) + 1u)) w = kRunWords;
  uvec2 visible = uvec2(0u);
  for (; w < kRunWords; ++w)
    for (uint points = drawnPoints(run, w, rank_bound); points != 0u; points &= points - 1u) {
      uint k = 8u * w + (uint(findLSB(points)) >> 2u), grain = run * kRunGrains + k;
      Seen seen = seenOf(records[grain], grain);
      if (seen.along == 0.0) continue;
      uint at = pixelAt(seen);
      if (seen.front > alongOf(keys[at]) + pointBand(seen.radius, seen.along / view.pixels_at_1m)) continue;
      if (k < 32u) visible.x |= 1u << k;
      else visible.y |= 1u << (k - 32u);
    }
  uint count = uint(bitCount(visible.x) + bitCount(visible.y));
  if (count == 0u) return;
  uint before = atomicAdd(commands.seen_points, count), at = swarm.count - before;
  atomicMax(commands.seen_groups[0], min((before + count + 63u) / 64u, kMostWorkGroups));
  for (; (visible.x | visible.y) != 0u;) {
    bool low = visible.x != 0u;
    uint bits = low ? visible.x : visible.y;
    list[--at] = run * kRunGrains + uint(findLSB(bits)) + (low ? 0u : 32u);
    if (low) visible.x &= visible.x - 1u;
    else visible.y &= visible.y - 1u;
  }
}

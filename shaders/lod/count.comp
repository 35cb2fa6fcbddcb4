// How many grains of each representation a run has. On the way, the first count of a frame chooses what is drawn
// first: what was seen in the last frame, or is the nearest in its cell of the candidate map. The second, LATE, is of
// the rest, and drops of it what the depth pyramid hides.
#define SWARM_ROUTES
#include "lib/occlusion.glsl"
#include "lib/swarm.glsl"
#include "shared/candidate.h"
#include "shared/swarm_run.h"

layout(local_size_x = 64) in;

// A byte each; a run has at most 64.
layout(std430, binding = kSwarmCountsBinding) writeonly buffer Counts { uint counts[]; };
#ifndef LATE
layout(std430, binding = kCandidateMapBinding) readonly buffer CandidateMap { uint nearest[]; };
layout(std430, binding = kSwarmSeenBinding) buffer Seen { uint seen[]; };

bool isCandidate(vec3 center, float radius) {
  float distance = length(center);
  float size_px = sizePx(radius, distance, view.pixels_at_1m);
  uint cell = candidateCell(pixelOf(view, center), size_px, swarm.candidate_cell, ivec2(view.size_px));
  return nearest[cell] == candidateKey(distance);
}
#endif

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint grain = run * kRunGrains, word = run * kRunWords, end = word + kRunWords;
  uint count[kCountWords] = uint[kCountWords](0u, 0u, 0u, 0u);
  bool more = false;
  for (uint k = word; k < end; ++k) {
    uint eight = representations[k];
    count[0] += uint(bitCount(pointsOf(eight))) << 8u * kPoint;
    more = more || laterOf(eight) != 0u;
  }
#ifdef LATE
  OcclusionView eye = occlusionView();
#else
  uvec2 was_seen = uvec2(seen[run * kRunSeenWords], seen[run * kRunSeenWords + 1u]);
  if (was_seen.x != 0u) seen[run * kRunSeenWords] = 0u;
  if (was_seen.y != 0u) seen[run * kRunSeenWords + 1u] = 0u;
#endif
  // A loop, which is left where no run has more: what an `if` leaves out may cost as much as what it does not.
  for (word = more ? word : end; word < end; ++word, grain += 8u) {
    uint before = representations[word], now = before;
    for (uint later = laterOf(before); later != 0u; later &= later - 1u) {
      uint k = uint(findLSB(later)) >> 2u, r = before >> 4u * k & 15u;
      SwarmRecord record = records[grain + k];
      vec3 center = centerOf(record);
      float radius = radiusOf(record);
#ifdef LATE
      uint drawn = r == kSmallImpostor ? kAsImage : r == kImpostor ? kAsTriangle : kAsSolid;
      float reach_px = drawn == kAsSolid ? kReachTouched : kReachCenters;
      if (swarm.cull != 0u &&
          occluded(ellipsoidBounds(eye, center, radius, unpackRotation(record.rotation), swarm.bound, reach_px, drawn)))
        r = kHidden;
#else
      uint in_run = grain + k - run * kRunGrains;
      bool known = ((in_run < 32u ? was_seen.x : was_seen.y) >> (in_run & 31u) & 1u) != 0u;
      if (known || isCandidate(center, radius)) r += kFirst;
#endif
      now ^= ((before >> 4u * k & 15u) ^ r) << 4u * k;
      if (r != kNotDrawn && r != kHidden) count[r >> 2u] += 1u << 8u * (r & 3u);
    }
    if (now != before) representations[word] = now;
  }
  for (uint k = 0u; k < kCountWords; ++k) counts[run * kCountWords + k] = count[k];
}

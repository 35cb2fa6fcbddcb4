// How many grains of each representation a run has. On the way, the first count of a frame turns impostors that
// were seen in the last frame, or are the nearest in their cell of the candidate map, into occluders; the second, LATE, drops the impostors that
// the depth pyramid hides.
#define SWARM_ROUTES
#include "lib/occlusion.glsl"
#include "lib/swarm.glsl"
#include "shared/candidate.h"

layout(local_size_x = 64) in;

// A byte each; a run has at most 64.
layout(std430, binding = kSwarmCountsBinding) writeonly buffer Counts { uvec2 counts[]; };
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
  uint grain = run * kRunGrains;
  uvec2 count = uvec2(0u);
#ifdef LATE
  OcclusionView eye = occlusionView();
#else
  uvec2 was_seen = uvec2(seen[run * kRunSeenWords], seen[run * kRunSeenWords + 1u]);
  if (was_seen.x != 0u) seen[run * kRunSeenWords] = 0u;
  if (was_seen.y != 0u) seen[run * kRunSeenWords + 1u] = 0u;
#endif
  for (uint word = run * kRunWords; word < (run + 1u) * kRunWords; ++word, grain += 8u) {
    uint before = representations[word], now = before;
    for (uint k = 0u, rest = before; rest != 0u; ++k, rest >>= 4u) {
      uint r = rest & 15u;
      if (r == kImpostor) {
        SwarmRecord record = records[grain + k];
        vec3 center = centerOf(record);
        float radius = radiusOf(record);
#ifdef LATE
        if (occluded(sphereBounds(eye, center, radius, kReachCenters, true))) r = kNotDrawn;
#else
        uint in_run = grain + k - run * kRunGrains;
        bool known = ((in_run < 32u ? was_seen.x : was_seen.y) >> (in_run & 31u) & 1u) != 0u;
        if (known || isCandidate(center, radius)) r = kOccluder;
#endif
        now ^= (kImpostor ^ r) << 4u * k;
      }
      uint one = r == kNotDrawn ? 0u : 1u << 8u * (r & 3u);
      count += r < 4u ? uvec2(one, 0u) : uvec2(0u, one);
    }
    if (now != before) representations[word] = now;
  }
  counts[run] = count;
}

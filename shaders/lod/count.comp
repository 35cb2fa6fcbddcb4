// How many grains of each representation a run has. On the way, OCCLUDERS: impostors that are the nearest
// in their cell of the candidate map become occluders.
#ifdef OCCLUDERS
#define SWARM_ROUTES
#endif
#include "lib/swarm.glsl"
#include "shared/candidate.h"

layout(local_size_x = 64) in;

// A byte each; a run has at most 64.
layout(std430, binding = kSwarmCountsBinding) writeonly buffer Counts { uvec2 counts[]; };
#ifdef OCCLUDERS
layout(std430, binding = kCandidateMapBinding) readonly buffer CandidateMap { uint nearest[]; };

bool isOccluder(SwarmRecord grain) {
  vec3 center = centerOf(grain);
  float distance = length(center);
  float size_px = sizePx(radiusOf(grain), distance, view.pixels_at_1m);
  uint cell = candidateCell(pixelOf(view, center), size_px, ivec2(view.size_px));
  return nearest[cell] == candidateKey(distance);
}
#endif

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint grain = run * kRunGrains;
  uvec2 count = uvec2(0u);
  for (uint word = run * kRunWords; word < (run + 1u) * kRunWords; ++word, grain += 8u) {
    uint all = representations[word];
    if (all == 0u) continue;
#ifdef OCCLUDERS
    for (uint k = 0u; k < 8u; ++k)
      if ((all >> 4u * k & 15u) == kImpostor && isOccluder(records[grain + k])) all += (kOccluder - kImpostor) << 4u * k;
    representations[word] = all;
#endif
    for (uint rest = all; rest != 0u; rest >>= 4u) {
      uint r = rest & 15u;
      uint one = r == kNotDrawn ? 0u : 1u << 8u * (r & 3u);
      count += r < 4u ? uvec2(one, 0u) : uvec2(0u, one);
    }
  }
  counts[run] = count;
}

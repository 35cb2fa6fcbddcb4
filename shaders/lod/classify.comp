// How each grain is drawn: what lies outside of the view is not, the rest by its size. All but points
// leave the mark of the nearest of them in the map of occluder candidates; if the last frame tells of this one, only
// those that it neither showed nor hid.
#define SWARM_ROUTES
#include "lib/swarm.glsl"
#include "shared/candidate.h"
#include "shared/swarm_run.h"

layout(local_size_x = 64) in;

layout(std430, binding = kSwarmRunsBinding) readonly buffer Runs { SwarmRun runs[]; };
layout(std430, binding = kCandidateMapBinding) buffer CandidateMap { uint nearest[]; };
layout(std430, binding = kSwarmSeenBinding) readonly buffer Seen { uint seen[]; };

uint representationNow(SwarmRecord grain, uint before, bool may_be_candidate) {
  vec3 center = centerOf(grain);
  float radius = radiusOf(grain);
  for (int k = 0; k < 5; ++k)
    if (dot(view.frustum_planes[k].xyz, center) + view.frustum_planes[k].w < -radius) return kNotDrawn;
  float distance = length(center);
  float size_px = sizePx(radius, distance, view.pixels_at_1m);
  uint now = representationOf(size_px, ownShare(grain.look, grain.size), before, swarm);
  if (now > kPoint && may_be_candidate) {
    uint cell = candidateCell(pixelOf(view, center), size_px, swarm.candidate_cell, ivec2(view.size_px));
    uint key = candidateKey(distance);
    if (nearest[cell] < key) atomicMax(nearest[cell], key);
  }
  return now;
}

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint grain = run * kRunGrains, end = min(grain + kRunGrains, swarm.count);
  uint word = run * kRunWords, end_word = word + kRunWords;
  uint all = routeOfRun(runs[run], swarm, view);
  if (all != kUnlike)
    for (; word < end_word; ++word, grain += 8u) {
      uint now = eightOf(all, end > grain ? end - grain : 0u);
      if (representations[word] != now) representations[word] = now;
    }
  for (; word < end_word; ++word) {
    uint before = representations[word], now = 0u;
    for (uint shift = 0u; shift < 32u && grain < end; shift += 4u, ++grain) {
      uint was = before >> shift & 15u;
      bool told = was == kHidden || (seen[grain / 32u] >> (grain & 31u) & 1u) != 0u;
      now |= representationNow(records[grain], was, swarm.candidate_cell == kCandidateCell || !told) << shift;
    }
    representations[word] = now;
  }
}

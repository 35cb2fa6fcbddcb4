// How each grain of the walked runs is drawn. All but points leave the mark of the nearest of them in the map of occluder
// candidates; if the last frame tells of this one, only those that it neither showed nor hid.
#define SWARM_ROUTES
#include "lod/walked.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kCandidateMapBinding) buffer CandidateMap { uint nearest[]; };
layout(std430, binding = kSwarmSeenBinding) readonly buffer Seen { uint seen[]; };

void main() {
  WalkedWord w = walkedWord();
  if (!w.exists) return;
  uint before = representations[w.word], now = representationsOf(w, before);
  if (now != before) representations[w.word] = now;
  bool known = swarm.candidate_cell != kCandidateCell;
  uint told = known ? hiddenOf(before) | bitsOfEight(seen[w.grain / 32u] >> (w.grain & 31u) & 255u) : 0u;
  uint untold = laterOf(now) & ~told;
  walked[untoldAt(w)] = untold;
  for (; untold != 0u; untold &= untold - 1u) {
    Candidate candidate = candidateOf(records[w.grain + (uint(findLSB(untold)) >> 2u)]);
    if (nearest[candidate.cell] < candidate.key) atomicMax(nearest[candidate.cell], candidate.key);
  }
}

// Chooses what is drawn first: what was seen in the last frame, or is the nearest in its cell of the candidate map. And
// counts the grains of the walked runs by representation.
#define SWARM_ROUTES
#include "lod/walked.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kCandidateMapBinding) readonly buffer CandidateMap { uint nearest[]; };
layout(std430, binding = kSwarmSeenBinding) readonly buffer Seen { uint seen[]; };

void main() {
  WalkedWord w = walkedWord();
  if (!w.exists) return;
  uint before = representations[w.word];
  uint first = laterOf(before) & bitsOfEight(seen[w.grain / 32u] >> (w.grain & 31u) & 255u);
  for (uint untold = walked[untoldAt(w)]; untold != 0u; untold &= untold - 1u) {
    uint shift = uint(findLSB(untold));
    Candidate candidate = candidateOf(records[w.grain + (shift >> 2u)]);
    if (nearest[candidate.cell] == candidate.key) first |= 1u << shift;
  }
  uint now = before | first * kFirst;
  if (now != before) representations[w.word] = now;
  addCounts(w.run, countsOf(now));
}

// Runs of which each grain is looked at: eight grains an invocation, so that the invocations of a run, which lies in one
// place, go the same ways. Their order differs between frames, and nothing depends on it. They are kept where the prefix
// sums are made afterwards.
#include "lib/swarm.glsl"
#include "shared/candidate.h"
#include "shared/swarm_run.h"

// How one grain is drawn: not at all outside of the view, else by its size on the screen.
uint representationOf(SwarmRecord grain, uint before) {
  vec3 center = centerOf(grain);
  float radius = radiusOf(grain);
  for (int k = 0; k < 5; ++k)
    if (dot(view.frustum_planes[k].xyz, center) + view.frustum_planes[k].w < -radius) return kNotDrawn;
  return representationOf(sizePx(radius, length(center), view.pixels_at_1m), ownShare(grain.look, grain.size), before, swarm);
}

layout(std430, binding = kSwarmCommandsBinding) buffer Commands { SwarmCommands commands; };
layout(std430, binding = kSwarmPrefixBinding) buffer Walked { uint walked[]; };

const uint kWalkedRunBits = 24u;       // a buffer has fewer runs
const uint kWalkedAsleep = 1u << 31u;  // all that is known of its grains is that they were hidden
const uint kWalkedRunsAGroup = 8u;     // of 64 invocations

// `all`: see routeOfRun().
void walk(uint run, uint all, bool asleep) {
  uint at = atomicAdd(commands.walked, 1u);
  walked[at] = run | all << kWalkedRunBits | (asleep ? kWalkedAsleep : 0u);
  if (at % kWalkedRunsAGroup == 0u) atomicAdd(commands.walked_groups[0], 1u);
}

// The grains of an invocation.
struct WalkedWord {
  bool exists;
  bool asleep;
  uint run;
  uint all;    // how each is drawn, or kUnlike
  uint word;   // of representations
  uint grain;  // the first
  uint end;
};
WalkedWord walkedWord() {
  WalkedWord w = WalkedWord(false, false, 0u, 0u, 0u, 0u, 0u);
  uint at = gl_GlobalInvocationID.x / kRunWords;
  if (at >= commands.walked) return w;
  uint run = walked[at];
  w.exists = true;
  w.asleep = (run & kWalkedAsleep) != 0u;
  w.all = run >> kWalkedRunBits & 127u;
  w.run = run & (1u << kWalkedRunBits) - 1u;
  w.word = w.run * kRunWords + gl_GlobalInvocationID.x % kRunWords;
  w.grain = 8u * w.word;
  w.end = min(w.grain + 8u, swarm.count);
  return w;
}

// The representations of its grains, each by itself only where they may differ. `before`: those of the last frame.
uint representationsOf(WalkedWord w, uint before) {
  uint now = w.all == kUnlike ? 0u : eightOf(w.all, w.end > w.grain ? w.end - w.grain : 0u);
  for (uint grain = w.all == kUnlike ? w.grain : w.end; grain < w.end; ++grain) {
    uint shift = 4u * (grain - w.grain);
    now |= representationOf(records[grain], before >> shift & 15u) << shift;
  }
  return now;
}

// Bits of grains that the last frame neither showed nor hid, as laterOf() has them; behind the walked runs.
uint untoldAt(WalkedWord w) { return swarm.run_count + w.word; }

// Where an occluder candidate is entered, and as what.
struct Candidate {
  uint cell;
  uint key;
};
Candidate candidateOf(SwarmRecord grain) {
  vec3 center = centerOf(grain);
  float distance = length(center), size_px = sizePx(radiusOf(grain), distance, view.pixels_at_1m);
  return Candidate(candidateCell(pixelOf(view, center), size_px, swarm.candidate_cell, ivec2(view.size_px)), candidateKey(distance));
}

layout(std430, binding = kSwarmCountsBinding) buffer Counts { uint counts[]; };

uvec4 countsOfRun(uint run) {
  uint at = kCountWords * run;
  return uvec4(counts[at], counts[at + 1u], counts[at + 2u], counts[at + 3u]);
}
void setCounts(uint run, uvec4 count) {
  for (uint k = 0u; k < kCountWords; ++k) counts[kCountWords * run + k] = count[k];
}
// Adds an invocation's to its run's.
void addCounts(uint run, uvec4 count) {
  for (uint k = 0u; k < kCountWords; ++k)
    if (count[k] != 0u) atomicAdd(counts[kCountWords * run + k], count[k]);
}

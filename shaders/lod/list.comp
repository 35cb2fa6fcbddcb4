// Enters the grains in the lists of their representations: those of the nearest run first, in a run in their order.
#include "lib/swarm.glsl"
#include "lib/swarm_lists.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kSwarmCountsBinding) readonly buffer Counts { uint counts[]; };
layout(std430, binding = kSwarmOrderBinding) readonly buffer Order { uint order[]; };
layout(std430, binding = kSwarmPrefixBinding) readonly buffer Prefix { uint prefix[]; };
layout(std430, binding = kSwarmCommandsBinding) readonly buffer Commands { SwarmCommands commands; };
layout(std430, binding = kSwarmListBinding) writeonly buffer List { uint list[]; };

void main() {
  if (gl_GlobalInvocationID.x >= swarm.run_count) return;
  uint run = order[gl_GlobalInvocationID.x], block = gl_GlobalInvocationID.x / kBlockRuns;
  for (uint r = 0u; r < kRepresentations; ++r) {
    uint left = counts[run * kCountWords + (r >> 2u)] >> 8u * (r & 3u) & 255u;
    if (left == 0u || (swarm.listed >> r & 1u) == 0u) continue;
    uint at = commands.begin[r] + prefix[prefixOfBlock(block, swarm.run_count) + r] + prefix[prefixOfRun(run) + r];
    uint grain = run * kRunGrains;
    for (uint word = run * kRunWords; left != 0u; ++word, grain += 8u) {
      uint all = representations[word];
      for (uint k = 0u; k < 8u; ++k)
        if ((all >> 4u * k & 15u) == r) {
          list[at] = grain + k;
          ++at;
          --left;
        }
    }
  }
}

// Sums of the runs' counts within each block of them, in the order of their distance: one invocation a
// representation, one group a block.
#include "lib/swarm.glsl"
#include "lib/swarm_lists.glsl"

layout(local_size_x = kRepresentations) in;

layout(std430, binding = kSwarmCountsBinding) readonly buffer Counts { uint counts[]; };
layout(std430, binding = kSwarmOrderBinding) readonly buffer Order { uint order[]; };
layout(std430, binding = kSwarmPrefixBinding) writeonly buffer Prefix { uint prefix[]; };

void main() {
  uint block = gl_WorkGroupID.x, representation = gl_LocalInvocationID.x;
  uint word = representation >> 2u, shift = 8u * (representation & 3u);
  uint end = min((block + 1u) * kBlockRuns, swarm.run_count);
  uint sum = 0u;
  for (uint k = block * kBlockRuns; k < end; ++k) {
    uint run = order[k];
    prefix[prefixOfRun(run) + representation] = sum;
    sum += counts[kCountWords * run + word] >> shift & 255u;
  }
  prefix[prefixOfBlock(block, swarm.run_count) + representation] = sum;
}

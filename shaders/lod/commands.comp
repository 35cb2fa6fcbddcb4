// Sums of the blocks' counts, where the lists begin, and the commands that draw them: one group, one
// invocation a representation. FIRST: of the first lists in the frame.
#include "lib/swarm.glsl"
#include "lib/swarm_lists.glsl"

layout(local_size_x = kRepresentations) in;

layout(std430, binding = kSwarmPrefixBinding) buffer Prefix { uint prefix[]; };
layout(std430, binding = kSwarmCommandsBinding) buffer Commands { SwarmCommands commands; };

shared uint total[kRepresentations];

void main() {
  uint representation = gl_LocalInvocationID.x;
  bool listed = (swarm.listed >> representation & 1u) != 0u;
  uint sum = 0u, blocks = blockCount(swarm.run_count);
  for (uint block = 0u; block < blocks; ++block) {
    uint at = prefixOfBlock(block, swarm.run_count) + representation;
    uint count = prefix[at];
    prefix[at] = sum;
    sum += count;
  }
  total[representation] = listed ? sum : 0u;
#ifdef FIRST
  uint begin = 0u;
#else
  uint begin = commands.listed;
#endif
  barrier();
  uint end = begin;
  for (uint k = 0u; k < kRepresentations; ++k) {
    if (k < representation) begin += total[k];
    end += total[k];
  }
  if (listed) {
    commands.begin[representation] = begin;
    commands.count[representation] = sum;
    commands.impostors[representation] = DrawArraysCommand(3u * sum, 1u, 3u * begin, 0u);
    if ((representation & kMesh) != 0u)
      for (uint part = 0u; part < kMeshParts; ++part) {
        commands.meshes[meshCommand(representation, part)].instances = sum;
        commands.meshes[meshCommand(representation, part)].base_instance = begin;
      }
  }
  if (representation == 0u) commands.listed = end;
#ifdef FIRST
  if (representation == kPoint)
    commands.point_groups = uint[3](sum > 0u ? (swarm.run_count + 63u) / 64u : 0u, 1u, 1u);
#endif
}

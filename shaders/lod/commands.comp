// Sums of the blocks' counts, where the lists begin, and the commands that draw them: one group, one
// invocation a representation. FIRST: of the first lists in the frame.
#include "lib/swarm.glsl"
#include "lib/swarm_lists.glsl"

layout(local_size_x = kRepresentations) in;

layout(std430, binding = kSwarmPrefixBinding) buffer Prefix { uint prefix[]; };
layout(std430, binding = kSwarmCommandsBinding) buffer Commands { SwarmCommands commands; };

shared uint total[kRepresentations];
shared uint found[kRepresentations];

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
  found[representation] = sum;
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
    uint vertices = verticesOf(representation);
    commands.impostors[representation] = DrawArraysCommand(vertices * sum, 1u, vertices * begin, 0u);
    if ((representation & kMesh) != 0u)
      for (uint part = 0u; part < kMeshParts; ++part) {
        commands.meshes[meshCommand(representation, part)].instances = sum;
        commands.meshes[meshCommand(representation, part)].base_instance = begin;
      }
  }
  if (representation == 0u) {
    commands.listed = end;
    commands.walked = 0u;
    commands.walked_groups[0] = 0u;
  }
#ifdef FIRST
  if (representation != 0u) return;
  uint groups = (swarm.run_count + 63u) / 64u, rest = found[kHidden];
  for (uint k = kSmallImpostor; k < kFirst; ++k) rest += found[k];
  uvec2 tiles = rest + end > 0u ? (uvec2(view.size_px) + 7u) / 8u : uvec2(0u);
  commands.point_groups = uint[3](found[kPoint] > 0u ? groups : 0u, 1u, 1u);
  commands.first_groups = uint[3](end > 0u ? groups : 0u, 1u, 1u);
  commands.late_groups = uint[3](rest > 0u ? groups : 0u, 1u, 1u);
  commands.seen_groups = uint[3](0u, 1u, 1u);
  commands.see_groups = uint[3](tiles.x, tiles.y, 1u);
#endif
}

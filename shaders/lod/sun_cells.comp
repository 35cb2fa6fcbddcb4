// Of the grains of about one size that cast shadows, the nearest to the sun in each cell of its map.
#include "lib/swarm.glsl"
#include "lod/sun.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kSunCellsBinding) buffer SunCells { uint cells[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint end = min((run + 1u) * kRunGrains, swarm.count);
  for (uint grain = run * kRunGrains; grain < end; ++grain) {
    Caster caster = casterOf(records[grain]);
    if (caster.key == 0u) continue;
    uint at = sunCell(caster);
    if (cells[at] < caster.key) atomicMax(cells[at], caster.key);
  }
}

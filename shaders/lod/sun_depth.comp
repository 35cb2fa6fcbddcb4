// The discs of the grains that are nearest to the sun in their cells, into a map of the sun's depth. LIST: large
// ones are listed; a scene without them does not pay for that.
#include "lib/swarm.glsl"
#include "lod/sun.glsl"
#include "lod/sun_disc.glsl"

layout(local_size_x = 64) in;

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint end = min((run + 1u) * kRunGrains, swarm.count);
  for (uint grain = run * kRunGrains; grain < end; ++grain) {
    Caster caster = casterOf(records[grain]);
    if (caster.key == 0u || cells[sunCell(caster)] != caster.key) continue;
#ifdef LIST
    if (caster.radius > large_texels && list(caster)) continue;
#endif
    drawDisc(caster, 0, 1);
  }
}

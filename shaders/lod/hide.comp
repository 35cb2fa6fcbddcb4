// Hides the runs, as far as they were not drawn first, that the depth pyramid hides as a whole. Where something of one
// may show, it is walked through.
#define SWARM_ROUTES
#include "lib/occlusion.glsl"
#include "lod/walked.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kSwarmRunsBinding) readonly buffer Runs { SwarmRun runs[]; };

bool isHidden(SwarmRun run) {
  vec3 low = lowOf(run, swarm.origin.xyz), high = highOf(run, swarm.origin.xyz);
  return swarm.cull != 0u && occludedFinely(boxBounds(occlusionView(), low, high, reachOfRun(run, swarm), kReachTouched));
}

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uvec4 count = countsOfRun(run);
  uint later = laterCount(count), hidden = hiddenCount(count);
  if (later + hidden == 0u) return;
  SwarmRun bounds = runs[run];
  bool hide = isHidden(bounds);
  uvec4 left = withoutLater(count);
  left[kHidden >> 2u] += hide ? later + hidden : 0u;
  setCounts(run, left);
  if (!hide) walk(run, hidden != 0u ? routeOfRun(bounds, swarm, view) : kUnlike, hidden != 0u);
  uint end = (run + 1u) * kRunWords;
  for (uint word = hide && later != 0u ? run * kRunWords : end; word < end; ++word) representations[word] = hideLater(representations[word]);
}

// How each run of grains is drawn, where that is the same for all of it: not at all outside of the view, as points far
// away. A run of which the last frame hid all that was in the view sleeps until the depth pyramid shows it. The rest
// is walked through.
#define SWARM_ROUTES
#include "lod/walked.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = kSwarmRunsBinding) readonly buffer Runs { SwarmRun runs[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  SwarmRun bounds = runs[run];
  uint all = routeOfRun(bounds, swarm, view), grain = run * kRunGrains;
  bool known = swarm.candidate_cell != kCandidateCell, is_walked = all > kPoint;
  if (is_walked && known && onlyHidden(countsOfRun(run)) && !mayHavePoints(bounds, swarm, view)) return;
  setCounts(run, uvec4(all == kPoint ? min(kRunGrains, swarm.count - grain) << 8u * kPoint : 0u, 0u, 0u, 0u));
  if (is_walked) walk(run, all, false);
  uint end = (run + 1u) * kRunWords;
  for (uint word = is_walked ? end : run * kRunWords; word < end; ++word, grain += 8u) {
    uint now = eightOf(all, swarm.count > grain ? swarm.count - grain : 0u);
    if (representations[word] != now) representations[word] = now;
  }
}

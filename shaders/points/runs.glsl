// Which grains of a run need a look: none if points that were drawn before hide the run, as they do most of a heap whose
// runs are of one place; and those that may be drawn.
#include "points/splat.glsl"
#include "shared/swarm_run.h"

layout(std430, binding = kSwarmRunsBinding) readonly buffer Runs { SwarmRun runs[]; };

// The pixels that the run's centres may lie in, and how far they are along the view axis.
struct RunSeen {
  ivec2 first;
  ivec2 last;
  float nearest;
  float farthest;
};

RunSeen runSeenOf(SwarmRun run) {
  vec3 low = lowOf(run, swarm.origin.xyz), high = highOf(run, swarm.origin.xyz);
  RunSeen seen = RunSeen(ivec2(0), ivec2(0), 1e30, 0.0);
  vec2 least = vec2(1e30), most = vec2(-1e30);
  for (int k = 0; k < 8; ++k) {
    vec4 clip = view.clip_from_relative * vec4((k & 1) != 0 ? high.x : low.x, (k & 2) != 0 ? high.y : low.y, (k & 4) != 0 ? high.z : low.z, 1.0);
    vec2 ndc = clip.xy / max(clip.w, view.near_m);
    least = min(least, ndc), most = max(most, ndc);
    seen.nearest = min(seen.nearest, clip.w), seen.farthest = max(seen.farthest, clip.w);
  }
  // In pixels, a little wider for what rounding moves.
  vec2 a = clamp((least * 0.5 + 0.5) * view.size_px - 0.1, vec2(0.0), view.size_px - 1.0);
  vec2 b = clamp((most * 0.5 + 0.5) * view.size_px + 0.1, vec2(0.0), view.size_px - 1.0);
  seen.first = ivec2(a), seen.last = ivec2(b);
  return seen;
}

// Pixels that are read at most to know.
const int kMostRunPixels = 256;

// Whether each pixel of it shows a point with at least this key.
bool allNearer(RunSeen seen, uint key) {
  ivec2 size = seen.last - seen.first + 1;
  if (!(seen.nearest > view.near_m) || size.x * size.y > kMostRunPixels) return false;
  int stride = int(view.size_px.x), at = seen.first.y * stride + seen.first.x, end = at + size.y * stride;
  bool nearer = true;
  for (int x = 0; nearer && at < end;) {
    nearer = (keys[at + x] & ~kPointMark) >= key;
    if (++x == size.x) x = 0, at += stride;
  }
  return nearer;
}

// Bit 4 k: whether grain k of word w may be a point that is drawn. `bound`: leastHiddenRank() of the run's largest.
uint drawnPoints(uint run, uint w, float bound) {
  return pointsOf(representations[run * kRunWords + w]) & bitsOfEight(ranksBelow(bound, ranksOfRun(run, swarm.rank_seed), w));
}
float rankBound(SwarmRun run, RunSeen seen) {
  float most_px = run.most_radius * swarm.albedo.a * view.pixels_at_1m / max(seen.nearest, view.near_m);
  return leastHiddenRank(min(most_px, kLargestPointPx)) * (1.0 + kRunSlack);
}

// What the depth pyramid hides of the walked runs, as far as it was not drawn first, is not drawn; grains of runs that
// slept are routed before. And counts the rest by representation.
#define SWARM_ROUTES
#include "lib/occlusion.glsl"
#include "lod/walked.glsl"

layout(local_size_x = 64) in;

bool isHidden(OcclusionView eye, SwarmRecord grain, uint representation) {
  uint drawn = representation == kSmallImpostor ? kAsImage : representation == kImpostor ? kAsTriangle : kAsSolid;
  float reach_px = drawn == kAsSolid ? kReachTouched : kReachCenters;
  SphereBounds bounds = ellipsoidBounds(eye, centerOf(grain), radiusOf(grain), unpackRotation(grain.rotation), swarm.bound, reach_px, drawn);
  return swarm.cull != 0u && (drawn == kAsImage ? occluded(bounds) : occludedFinely(bounds));
}

void main() {
  WalkedWord w = walkedWord();
  if (!w.exists) return;
  uint before = representations[w.word], now = before;
  if (w.asleep) now = representationsOf(w, 0u);
  OcclusionView eye = occlusionView();
  uint rest = laterOf(now);
  for (uint later = rest; later != 0u; later &= later - 1u) {
    uint shift = uint(findLSB(later)), r = now >> shift & 15u;
    if (isHidden(eye, records[w.grain + (shift >> 2u)], r)) now ^= (r ^ kHidden) << shift;
  }
  if (now != before) representations[w.word] = now;
  addCounts(w.run, countsOf(now & rest * 15u));
}

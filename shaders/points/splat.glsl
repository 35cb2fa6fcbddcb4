// Where a grain that is drawn as a point is seen, and the targets of points by pixel.
#include "lib/swarm.glsl"
#include "shared/points.h"

layout(local_size_x = 64) in;

// The runs, the nearest to the eye first: they hide the others.
layout(std430, binding = kSwarmOrderBinding) readonly buffer Order { uint order[]; };

struct Seen {
  vec2 pixel_px;
  float along;   // distance along the view axis, m; 0: not in the picture
  float front;   // of the side that is seen, in the mean
  float radius;  // m
  float shown_px;  // radius of a ball with its mean shadow
};

Seen seenOf(SwarmRecord grain) {
  Seen seen;
  vec3 center = centerOf(grain);
  vec4 clip = view.clip_from_relative * vec4(center, 1.0);
  seen.pixel_px = (clip.xy / clip.w * 0.5 + 0.5) * view.size_px;
  seen.radius = radiusOf(grain);
  bool inside = clip.w > view.near_m && all(greaterThanEqual(seen.pixel_px, vec2(0.0))) &&
                all(lessThan(seen.pixel_px, view.size_px));
  seen.along = inside ? clip.w : 0.0;
  seen.shown_px = min(seen.radius * swarm.albedo.a * view.pixels_at_1m / clip.w, kLargestPointPx);
  seen.front = max(clip.w - kMeanFront * seen.radius, view.near_m);
  return seen;
}

float weightOf(Seen seen, uint grain) {
  return pointWeight(pointRank(grain % kRunGrains, firstRank(grain / kRunGrains)), leastHiddenRank(seen.shown_px));
}

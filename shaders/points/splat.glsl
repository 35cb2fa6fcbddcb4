// Where a grain that is drawn as a point is seen, and the targets of points by pixel.
#include "lib/swarm.glsl"
#include "shared/points.h"

layout(local_size_x = 64) in;

// The runs, the nearest to the eye first: they hide the others.
layout(std430, binding = kSwarmOrderBinding) readonly buffer Order { uint order[]; };

struct Seen {
  vec2 pixel_px;
  float along;     // distance along the view axis, m; 0: not in the picture, or others stand for it
  float front;     // of the side that is seen, in the mean, as far as the point is drawn in full
  float radius;    // m
  float shown_px;  // radius of a ball with its mean shadow
  float area;      // that it is drawn with, pixels
};

// The same to the bit in all programs: distances are compared between them.
Seen seenOf(SwarmRecord grain, uint index) {
  Seen seen;
  precise vec4 clip = view.clip_from_relative * vec4(centerOf(grain), 1.0);
  precise vec2 pixel_px = (clip.xy / clip.w * 0.5 + 0.5) * view.size_px;
  seen.pixel_px = pixel_px;
  seen.radius = radiusOf(grain);
  seen.shown_px = min(seen.radius * swarm.albedo.a * view.pixels_at_1m / clip.w, kLargestPointPx);
  float least_hidden = leastHiddenRank(seen.shown_px);
  float fullness = pointFullness(rankOf(index % kRunGrains, ranksOfRun(index / kRunGrains, swarm.rank_seed)), least_hidden);
  bool inside = clip.w > view.near_m && all(greaterThanEqual(pixel_px, vec2(0.0))) && all(lessThan(pixel_px, view.size_px));
  seen.along = inside && fullness > 0.0 ? clip.w : 0.0;
  precise float front = max(clip.w - kMeanFront * seen.radius, view.near_m) + (1.0 - fullness) * pointBand(seen.radius, clip.w / view.pixels_at_1m);
  seen.front = front;
  seen.area = 3.14159265 * seen.shown_px * seen.shown_px * fullness * pointWeight(least_hidden);
  return seen;
}

uint pixelAt(Seen seen) { return uint(seen.pixel_px.y) * uint(view.size_px.x) + uint(seen.pixel_px.x); }

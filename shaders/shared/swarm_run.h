// What the grains of a run have in common, and what follows from it for all of them at once: one test in place
// of 64, where grains that are near each other in the list are so in space.
#pragma once
#include "shared/swarm.h"
#include "shared/view.h"
RULES_BEGIN

// std430, 32 bytes. The box around the centres, relative to the swarm's origin, m; outer radii, m.
struct SwarmRun {
  float low_x;
  float low_y;
  float low_z;
  float least_radius;
  float high_x;
  float high_y;
  float high_z;
  float most_radius;
};

// Bounds are widened by this share of what they are computed from: more than floats round on the way.
const float kRunSlack = 1e-5f;

RULE vec3 lowOf(SwarmRun run, vec3 origin) { return origin + vec3(run.low_x, run.low_y, run.low_z); }
RULE vec3 highOf(SwarmRun run, vec3 origin) { return origin + vec3(run.high_x, run.high_y, run.high_z); }

// How each grain of the run is drawn, whatever it was before: kNotDrawn or kPoint; kUnlike if they differ, or
// something else comes of it.
const uint kUnlike = kRepresentations;
RULE uint routeOfRun(SwarmRun run, SwarmBlock swarm, ViewBlock view) {
  vec3 low = lowOf(run, vec3(swarm.origin)), high = highOf(run, vec3(swarm.origin));
  vec3 middle = 0.5f * (low + high), half_size = 0.5f * (high - low);
  vec3 size = abs(middle) + half_size;
  bool inside = true;
  for (int k = 0; k < 5; ++k) {
    vec3 n = vec3(view.frustum_planes[k]);
    float at = dot(n, middle) + view.frustum_planes[k].w, reach = dot(abs(n), half_size);
    float slack = kRunSlack * (size.x + size.y + size.z + abs(view.frustum_planes[k].w) + run.most_radius);
    if (at + reach < -run.most_radius - slack) return kNotDrawn;
    if (at - reach < slack) inside = false;
  }
  if (!inside) return kUnlike;
  vec3 nearest = max(max(low, -high), vec3(0.0f, 0.0f, 0.0f));
  float most_px = sizePx(run.most_radius, length(nearest) * (1.0f - kRunSlack), view.pixels_at_1m);
  return most_px < swarm.point_px * (1.0f - kPointSpread) * (1.0f - swarm.band) * (1.0f - kRunSlack) ? kPoint : kUnlike;
}

// Eight grains that are all drawn so, of which the first `count` exist.
RULE uint eightOf(uint representation, uint count) {
  return 0x11111111u * representation & (count < 8u ? (1u << 4u * count) - 1u : 0xffffffffu);
}

// Bit 4 k: whether grain k of eight is drawn as more than a point, and has not been chosen to be drawn first.
RULE uint laterOf(uint eight) { return (eight >> 1u | eight >> 2u) & ~(eight >> 3u) & 0x11111111u; }
// Bit 4 k: whether it is a point.
RULE uint pointsOf(uint eight) {
  return eight & ~(eight >> 1u | eight >> 2u | eight >> 3u) & 0x11111111u;
}

RULES_END

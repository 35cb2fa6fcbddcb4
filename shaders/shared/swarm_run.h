// What the grains of a run have in common, and what follows from it for all of them at once: one test in place
// of 64, where grains that are near each other in the list are so in space.
#pragma once
#include "shared/swarm.h"
#include "shared/view.h"
#ifdef __cplusplus
#include <glm/integer.hpp>
#endif
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

// How grains of sizes between these are drawn, whatever they were before; kUnlike if they may differ. A threshold is
// surely passed if it is so with the band to either side.
const uint kUnlike = kRepresentations;
RULE uint routeOfSizes(float least_px, float most_px, SwarmBlock swarm) {
  float least = least_px * (1.0f - kRunSlack), most = most_px * (1.0f + kRunSlack);
  float low = 1.0f - swarm.band, high = 1.0f + swarm.band;
  if (most < swarm.point_px * (1.0f - kPointSpread) * low) return kPoint;
  if (!(least >= swarm.point_px * high)) return kUnlike;
  bool below = most < swarm.impostor_px * low, above = least >= swarm.impostor_px * high;
  bool from = least >= swarm.impostor_from_px * high, short_of = most < swarm.impostor_from_px * low;
  if (below && from)
    return most < swarm.small_px * low ? kSmallImpostor : least >= swarm.small_px * high ? kImpostor : kUnlike;
  if (!(above || short_of)) return kUnlike;
  for (uint level = kMeshLevels - 1u; level > 0u; --level) {
    if (most < swarm.mesh_px[int(level)] * low) return kMesh + level;
    if (!(least >= swarm.mesh_px[int(level)] * high)) return kUnlike;
  }
  return kMesh;
}

// Sizes of the run's grains on the screen: the least and the most, px.
RULE vec2 sizesOfRun(SwarmRun run, SwarmBlock swarm, ViewBlock view) {
  vec3 low = lowOf(run, vec3(swarm.origin)), high = highOf(run, vec3(swarm.origin));
  vec3 nearest = max(max(low, -high), vec3(0.0f, 0.0f, 0.0f)), farthest = max(abs(low), abs(high));
  return vec2(sizePx(run.least_radius, length(farthest) * (1.0f + kRunSlack), view.pixels_at_1m),
              sizePx(run.most_radius, length(nearest) * (1.0f - kRunSlack), view.pixels_at_1m));
}

// How each grain of the run is drawn, whatever it was before, kNotDrawn included; kUnlike if they may differ.
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
  vec2 sizes = sizesOfRun(run, swarm, view);
  return routeOfSizes(sizes.x, sizes.y, swarm);
}

// Whether some grain of the run may be a point, wherever it was drawn before.
RULE bool mayHavePoints(SwarmRun run, SwarmBlock swarm, ViewBlock view) {
  return sizesOfRun(run, swarm, view).x < swarm.point_px * (1.0f + swarm.band) * (1.0f + kRunSlack);
}

// How far from the centre a grain of the run may be drawn, m: its ellipsoid may reach out of the outer sphere, and where
// rays are taken as parallel it is drawn up to 1.25 reach / distance, at most 0.15, farther out.
RULE float reachOfRun(SwarmRun run, SwarmBlock swarm) { return 1.25f * run.most_radius * max(swarm.bound.center.w, 1.0f); }

// Eight grains that are all drawn so, of which the first `count` exist.
RULE uint eightOf(uint representation, uint count) {
  return 0x11111111u * representation & (count < 8u ? (1u << 4u * count) - 1u : 0xffffffffu);
}

// Bits of eight grains, one each -> bit 4 k.
RULE uint bitsOfEight(uint bits) {
  uint apart = (bits | bits << 12u) & 0x000f000fu;
  apart = (apart | apart << 6u) & 0x03030303u;
  return (apart | apart << 3u) & 0x11111111u;
}
// How often a representation occurs among eight; by representation, a byte each, in the form of a run's counts. What is
// not drawn is not counted.
RULE uint countIn(uint eight, uint representation) {
  uint other = eight ^ 0x11111111u * representation;
  return uint(bitCount(~(other | other >> 1u | other >> 2u | other >> 3u) & 0x11111111u));
}
RULE uint countWord(uint eight, uint first) {
  return countIn(eight, first) | countIn(eight, first + 1u) << 8u | countIn(eight, first + 2u) << 16u | countIn(eight, first + 3u) << 24u;
}
RULE uvec4 countsOf(uint eight) {
  return uvec4(countWord(eight, 0u) & ~255u, countWord(eight, 4u), countWord(eight, 8u), countWord(eight, 12u));
}

// Bit 4 k: whether grain k of eight is drawn as more than a point, and has not been chosen to be drawn first.
RULE uint laterOf(uint eight) { return (eight >> 1u | eight >> 2u) & ~(eight >> 3u) & 0x11111111u; }
// Bit 4 k: whether it is a point.
RULE uint pointsOf(uint eight) {
  return eight & ~(eight >> 1u | eight >> 2u | eight >> 3u) & 0x11111111u;
}
// Bit 4 k: whether it is hidden.
RULE uint hiddenOf(uint eight) { return eight >> 3u & ~(eight | eight >> 1u | eight >> 2u) & 0x11111111u; }
// The same eight; what laterOf() tells is hidden.
RULE uint hideLater(uint eight) {
  uint later = laterOf(eight);
  return (eight & ~(15u * later)) | 8u * later;
}

// Of a run's counts, a byte a representation: grains of which only is known that they were hidden, and those that
// laterOf() tells. No more than kRunGrains together.
RULE bool onlyHidden(uvec4 count) {
  return count.x == 0u && count.y == 0u && count.z != 0u && count.z < 256u && count.w == 0u;
}
RULE uint hiddenCount(uvec4 count) { return count.z & 255u; }
RULE uint laterCount(uvec4 count) {
  return (count.x >> 16u & 255u) + (count.x >> 24u) + (count.y & 255u) + (count.y >> 8u & 255u) + (count.y >> 16u & 255u) + (count.y >> 24u);
}
// Without either.
RULE uvec4 withoutLater(uvec4 count) { return uvec4(count.x & 65535u, 0u, count.z & 0xffffff00u, count.w); }

RULES_END

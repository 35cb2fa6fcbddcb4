// What the points that are not hidden add to the pixels around them: area, and colour times area; and the mark of those
// in which they show. IDS: the foremost point's id. SURFACES: roughness and metalness times area, where swarms differ in
// them. OVERDRAW: nothing of that, but how many are added.
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) buffer Keys { uint keys[]; };
#ifdef OVERDRAW
layout(r32ui, binding = kOverdrawImage) uniform uimage2D overdraw;
#endif

#include "points/run_hidden.glsl"

layout(std430, binding = kPointSumsBinding) buffer Sums { uint sums[]; };  // r, g, b, area a pixel
layout(std430, binding = kPointCarriesBinding) buffer Carries { uint carries[]; };
layout(std430, binding = kPointRadiiBinding) buffer Radii { uint radii[]; };  // of the foremost
#ifdef SURFACES
layout(std430, binding = kPointSurfacesBinding) buffer Surfaces { uint surfaces[]; };  // roughness, metalness
#endif
#ifdef IDS
layout(std430, binding = kPointIdsBinding) buffer Ids { uint ids[]; };
#endif

// What does not fit in a sum is carried to bits of the pixel's own: a number, too, that no order changes.
uint carryOf(uint at, uint value, uint one) {
  uint before = atomicAdd(sums[at], value);
  return before + value < before ? one : 0u;
}

void add(ivec2 pixel, float area, vec3 color, vec2 surface, bool shows) {
  if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, ivec2(view.size_px)))) return;
  uint steps = uint(area * kPointAreaSteps + 0.5);
  if (shows) steps = max(steps, 1u);  // it has a colour
  if (steps == 0u) return;
#ifdef OVERDRAW
  imageAtomicAdd(overdraw, pixel, 1u);
#else
  uint pixel_at = uint(pixel.y) * uint(view.size_px.x) + uint(pixel.x), at = 4u * pixel_at;
  uvec3 code = uvec3(color * 255.0 + 0.5) * steps;
  uint carry = carryOf(at, code.r, 1u) + carryOf(at + 1u, code.g, 1u << 10u) + carryOf(at + 2u, code.b, 1u << 20u) +
               carryOf(at + 3u, steps, 1u << 30u);
  if (carry != 0u) atomicAdd(carries[pixel_at], carry);
  if (shows && (keys[pixel_at] & kPointMark) == 0u) atomicOr(keys[pixel_at], kPointMark);
#ifdef SURFACES
  uvec2 surface_code = uvec2(surface * 255.0 + 0.5) * steps;
  atomicAdd(surfaces[2u * pixel_at], surface_code.x);
  atomicAdd(surfaces[2u * pixel_at + 1u], surface_code.y);
#endif
#endif
}

void main() {
  if (gl_GlobalInvocationID.x >= swarm.run_count) return;
  uint run = order[gl_GlobalInvocationID.x], first = run * kRunGrains, word = run * kRunWords, end = word + kRunWords;
  SwarmRun bounds = runs[run];
  RunSeen place = runSeenOf(bounds);
  float most_band = pointBand(bounds.most_radius, place.farthest / view.pixels_at_1m);
  float front = (place.nearest - kMeanFront * bounds.most_radius) * (1.0 - kRunSlack) - most_band * (1.0 + kRunSlack);
  if (front > 0.0 && allNearer(place, pointKey(front) + 1u)) word = end;
  // First which grains are seen, then what they add: adding is much dearer, even where it is left out for most.
  uvec2 visible = uvec2(0u);
  for (uint in_run = 0u; word < end; ++word, in_run += 8u)
    for (uint points = pointsOf(representations[word]); points != 0u; points &= points - 1u) {
      uint k = in_run + (uint(findLSB(points)) >> 2u);
      Seen seen = seenOf(records[first + k]);
      if (seen.along == 0.0) continue;
      uint at = uint(seen.pixel_px.y) * uint(view.size_px.x) + uint(seen.pixel_px.x);
      float pixel_m = seen.along / view.pixels_at_1m;
      if (seen.front > alongOf(keys[at] & ~kPointMark) + pointBand(seen.radius, pixel_m)) continue;
      if (k < 32u) visible.x |= 1u << k;
      else visible.y |= 1u << (k - 32u);
    }
  while ((visible.x | visible.y) != 0u) {
    bool low = visible.x != 0u;
    uint bits = low ? visible.x : visible.y, grain = first + uint(findLSB(bits)) + (low ? 0u : 32u);
    if (low) visible.x &= visible.x - 1u;
    else visible.y &= visible.y - 1u;
    SwarmRecord record = records[grain];
    Seen seen = seenOf(record);
    float pixel_m = seen.along / view.pixels_at_1m, radius_px = min(seen.radius * swarm.albedo.a / pixel_m, kLargestPointPx);
#ifndef OVERDRAW
    uint at = uint(seen.pixel_px.y) * uint(view.size_px.x) + uint(seen.pixel_px.x);
    if (pointKey(seen.front) == (keys[at] & ~kPointMark)) {
      atomicMax(radii[at], packPointRadii(vec2(seen.radius / pixel_m, radius_px)));
#ifdef IDS
      atomicMax(ids[at], idOf(grain));
#endif
    }
#endif
    vec2 corner = seen.pixel_px - 0.5;
    ivec2 base = ivec2(floor(corner));
    vec2 fraction = corner - vec2(base);
    float area = 3.14159265 * radius_px * radius_px;
    vec4 shares = pointShares(fraction) * area;
    // Not the number by which it became a point: those of one size have that in common.
    uint pixels = pointPixels(area, ownShare(record.look ^ 0x68bc21ebu, record.size));
    vec3 color = tintOf(record.look) * swarm.albedo.rgb;
    vec2 surface = vec2(roughnessOf(record.look) * swarm.roughness, swarm.metallic);
    for (uint k = 0u; k < 4u; ++k)
      add(base + ivec2(k & 1u, k >> 1u), shares[k], color, surface, pointRank(fraction, k) < pixels);
  }
}

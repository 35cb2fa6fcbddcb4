// What the points that are not hidden add to the pixels around them: area, and colour times area; the mark of those in
// which they show; and what a pixel knows of its foremost point. IDS: that one's id. SURFACES: roughness and metalness times area, where swarms differ in
// them. OVERDRAW: nothing of that, but how many are added.
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) buffer Keys { uint keys[]; };
#ifdef OVERDRAW
layout(r32ui, binding = kOverdrawImage) uniform uimage2D overdraw;
#endif

#define SWARM_LISTED
#include "points/splat.glsl"

layout(std430, binding = kSwarmCommandsBinding) readonly buffer Commands { SwarmCommands commands; };
layout(std430, binding = kPointSumsBinding) buffer Sums { uint sums[]; };  // r, g, b, area a pixel
layout(std430, binding = kPointCarriesBinding) buffer Carries { uint carries[]; };
layout(std430, binding = kPointForemostBinding) buffer ForemostPoints { uint foremost[]; };
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

void addGrain(uint grain) {
  SwarmRecord record = records[grain];
  Seen seen = seenOf(record, grain);
  if (seen.along == 0.0) return;
#ifndef OVERDRAW
  uint at = pixelAt(seen);
  if (pointKey(seen.front) == (keys[at] & ~kPointMark)) {
    atomicMax(foremost[at], packForemost(Foremost(seen.radius * view.pixels_at_1m / seen.along, seen.shown_px, fract(seen.pixel_px))));
#ifdef IDS
    atomicMax(ids[at], idOf(grain));
#endif
  }
#endif
  vec2 corner = seen.pixel_px - 0.5;
  ivec2 base = ivec2(floor(corner));
  vec2 fraction = corner - vec2(base);
  vec4 shares = pointShares(fraction) * seen.area;
  // Not the number by which it became a point: those of one size have that in common.
  uint pixels = pointPixels(seen.area, ownShare(record.look ^ 0x68bc21ebu, record.size));
  vec3 color = tintOf(record.look) * swarm.albedo.rgb;
  vec2 surface = vec2(roughnessOf(record.look) * swarm.roughness, swarm.metallic);
  for (uint k = 0u; k < 4u; ++k)
    add(base + ivec2(k & 1u, k >> 1u), shares[k], color, surface, shownInOrder(fraction, k) < pixels);
}

void main() {
  uint step = 64u * gl_NumWorkGroups.x;
  for (uint k = gl_GlobalInvocationID.x; k < commands.seen_points; k += step) addGrain(list[swarm.count - 1u - k]);
}

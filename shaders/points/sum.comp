// What the points that are not hidden add to the pixels around them: area, and colour times area. IDS: the
// foremost point's id. SURFACES: roughness and metalness times area, where swarms differ in them.
#include "points/splat.glsl"

layout(std430, binding = kPointKeysBinding) readonly buffer Keys { uint keys[]; };
layout(std430, binding = kPointSumsBinding) buffer Sums { uint sums[]; };  // r, g, b, area a pixel
layout(std430, binding = kPointCarriesBinding) buffer Carries { uint carries[]; };
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

void add(ivec2 pixel, float area, vec3 color, vec2 surface) {
  if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, ivec2(view.size_px)))) return;
  uint steps = uint(area * kPointAreaSteps + 0.5);
  if (steps == 0u) return;
  uint pixel_at = uint(pixel.y) * uint(view.size_px.x) + uint(pixel.x), at = 4u * pixel_at;
  uvec3 code = uvec3(color * 255.0 + 0.5) * steps;
  uint carry = carryOf(at, code.r, 1u) + carryOf(at + 1u, code.g, 1u << 10u) + carryOf(at + 2u, code.b, 1u << 20u) +
               carryOf(at + 3u, steps, 1u << 30u);
  if (carry != 0u) atomicAdd(carries[pixel_at], carry);
#ifdef SURFACES
  uvec2 surface_code = uvec2(surface * 255.0 + 0.5) * steps;
  atomicAdd(surfaces[2u * pixel_at], surface_code.x);
  atomicAdd(surfaces[2u * pixel_at + 1u], surface_code.y);
#endif
}

void main() {
  uint run = gl_GlobalInvocationID.x;
  if (run >= swarm.run_count) return;
  uint grain = run * kRunGrains;
  for (uint word = run * kRunWords; word < (run + 1u) * kRunWords; ++word, grain += 8u) {
    uint all = representations[word];
    for (uint k = 0u; all != 0u; all >>= 4u, ++k) {
      if ((all & 15u) != kPoint) continue;
      SwarmRecord record = records[grain + k];
      Seen seen = seenOf(record);
      if (seen.along == 0.0) continue;
      uint at = uint(seen.pixel_px.y) * uint(view.size_px.x) + uint(seen.pixel_px.x);
      float pixel_m = seen.along / view.pixels_at_1m;
      if (seen.front > alongOf(keys[at]) + pointBand(seen.radius, pixel_m)) continue;
#ifdef IDS
      if (pointKey(seen.front) == keys[at]) atomicMax(ids[at], idOf(grain + k));
#endif
      float radius_px = min(seen.radius * swarm.albedo.a / pixel_m, kLargestPointPx);
      vec2 corner = seen.pixel_px - 0.5;
      ivec2 base = ivec2(floor(corner));
      vec4 shares = pointShares(corner - vec2(base)) * (3.14159265 * radius_px * radius_px);
      vec3 color = tintOf(record.look) * swarm.albedo.rgb;
      vec2 surface = vec2(roughnessOf(record.look) * swarm.roughness, swarm.metallic);
      add(base, shares.x, color, surface);
      add(base + ivec2(1, 0), shares.y, color, surface);
      add(base + ivec2(0, 1), shares.z, color, surface);
      add(base + ivec2(1, 1), shares.w, color, surface);
    }
  }
}

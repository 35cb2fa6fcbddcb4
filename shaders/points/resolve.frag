// The pixels that points cover, into the G-buffer; their sums are emptied.
#include "lib/gbuffer.glsl"
#include "shared/bed.h"
#include "shared/points.h"

layout(std430, binding = kPointKeysBinding) readonly buffer Keys { uint keys[]; };
layout(std430, binding = kPointSumsBinding) buffer Sums { uvec4 sums[]; };
layout(std430, binding = kPointCarriesBinding) buffer Carries { uint carries[]; };
layout(std430, binding = kPointForemostBinding) readonly buffer ForemostPoints { uint foremost_points[]; };
#ifdef SURFACES
layout(std430, binding = kPointSurfacesBinding) buffer Surfaces { uvec2 surfaces[]; };
#endif
#ifdef IDS
layout(std430, binding = kPointIdsBinding) readonly buffer Ids { uint ids[]; };
#endif

layout(location = 0) uniform vec2 surface;      // roughness, metalness
layout(location = 1) uniform float facing;      // mean cosine between a face of the grains and its normals
layout(location = 2) uniform float least_area;  // share of a pixel

in vec3 ray;

uint at(ivec2 pixel) {
  ivec2 p = clamp(pixel, ivec2(0), ivec2(view.size_px) - 1);
  return uint(p.y) * uint(view.size_px.x) + uint(p.x);
}

// How 1 / distance along the axis changes from pixel to pixel, over the foremost points around one.
vec2 changeAround(ivec2 pixel, float inverse) {
  PlaneSums sums = PlaneSums(0.0, 0.0, vec2(0.0), vec3(0.0), vec2(0.0));
  float most = kMostSlope / view.pixels_at_1m * inverse;
  ivec2 middle = clamp(pixel, ivec2(1), max(ivec2(view.size_px) - 2, ivec2(1)));  // as many at the picture's edge
  for (int k = 0; k < 9; ++k) {
    ivec2 offset = middle - pixel + ivec2(k % 3 - 1, k / 3 - 1);
    uint there = at(pixel + offset);
    float other = uintBitsToFloat(keys[there] & ~kPointMark), change = other - inverse;
    if (other == 0.0 || abs(change) > most) continue;  // none, or of another surface
    if (any(greaterThanEqual(uvec2(pixel + offset), uvec2(view.size_px)))) continue;
    sums = addToPlane(sums, vec2(offset) + unpackForemost(foremost_points[there]).place_px, change);
  }
  return planeChange(sums);
}

vec3 surfaceNormal(float inverse, vec2 change) {
  vec3 ray_x = view.relative_from_clip[0].xyz * (2.0 / view.size_px.x);
  vec3 ray_y = view.relative_from_clip[1].xyz * (2.0 / view.size_px.y);
  vec3 forward = normalize(cross(ray_y, ray_x));
  return planeNormal(ray, ray_x, ray_y, forward, inverse, change);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  uint here = at(pixel);
  uvec4 stored = sums[here];
  uint carry = carries[here];
  // Zero again for the next frame: nothing is added beyond the tiles that are drawn here.
  if (stored.w != 0u || carry != 0u) sums[here] = uvec4(0u);
  if (carry != 0u) carries[here] = 0u;
  vec4 sum = vec4(stored) + 4294967296.0 * vec4(uvec4(carry, carry >> 10u, carry >> 20u, carry >> 30u) & 1023u);
#ifdef SURFACES
  uvec2 surface_sum = surfaces[here];
  if (stored.w != 0u || carry != 0u) surfaces[here] = uvec2(0u);
#endif
  float area = sum.w / kPointAreaSteps;
  bool shows = (keys[here] & kPointMark) != 0u;
  if (!shows && area < least_area) discard;
  // The point that the pixel shows in its middle: that of the pixel itself, or a nearer one that covers the middle; else the
  // foremost of those around it, which cover it together.
  uint own_key = keys[here] & ~kPointMark, key = own_key, around = 0u;
  int centers = 0;
  ivec2 shown = pixel, other_shown = pixel, first = max(pixel - 1, ivec2(0)), last = min(pixel + 1, ivec2(view.size_px) - 1);
  bool covered = false;
  for (int y = first.y; y <= last.y; ++y)
    for (int x = first.x; x <= last.x; ++x) {
      uint there = at(ivec2(x, y)), other = keys[there] & ~kPointMark;
      if (other == 0u) continue;
      ++centers;
      Foremost point = unpackForemost(foremost_points[there]);
      vec2 aside = vec2(x, y) + point.place_px - gl_FragCoord.xy;
      bool covers = dot(aside, aside) < point.shown_px * point.shown_px;
      if (covers && other >= key) key = other, shown = ivec2(x, y), covered = true;
      if (other > around) around = other, other_shown = ivec2(x, y);
    }
  if (key == 0u) key = around, shown = other_shown;
  uint id_at = at(shown);
  bool lone = centers <= kLonePoints;
  if (key == 0u || (lone && !shows && area < kLoneArea)) discard;
  float foremost = uintBitsToFloat(key);
  Foremost point = unpackForemost(foremost_points[id_at]);
  vec2 radii_px = vec2(point.outer_px, point.shown_px), change = changeAround(pixel, foremost);
  // A point that covers the middle of the pixel is what is there; another is carried there along the plane.
  vec2 aside = covered ? vec2(0.0) : vec2(shown) + point.place_px - gl_FragCoord.xy;
  float inverse = clamp(foremost - dot(change, aside), 0.5 * foremost, 2.0 * foremost);
  vec3 to_eye = -normalize(ray), up = surfaceNormal(foremost, change);
  float steepness = lone ? 0.0 : bedSteepness(dot(to_eye, up), kBedPacking * min(area, 1.0));
  if (!lone) {
    float away = view.pixels_at_1m, receded = away * (foremost / inverse - 1.0);  // in pixels as wide as they are there
    float packing = 4.0 / 3.0 * radii_px.y * area / max(pointBand(radii_px.x, 1.0) - receded, radii_px.y);
    inverse /= 1.0 + bedSeenDepth(packing, radii_px, receded) * (covered ? kCoveredDepth : 1.0) / away;
  }
  gl_FragDepth = min(view.near_m * inverse, 1.0);

  Surface s;
  s.albedo = sum.rgb / (255.0 * max(sum.w, 1.0));  // a sum too large to hold may read 0
#ifdef SURFACES
  // So much that these sums, which nothing is carried from, may not hold it: no bed, but grains in each other.
  vec2 look = sum.w < 4294967295.0 / 255.0 ? vec2(surface_sum) / (255.0 * max(sum.w, 1.0)) : surface;
#else
  vec2 look = surface;
#endif
  s.metallic = look.y;
  vec3 shares = bedShares(steepness);
  s.normal_ws = bedMeanNormal(to_eye, up, shares);
  s.spread = 1.0 - facing * length(s.normal_ws);
  s.roughness = look.x;
#ifdef MOTION
  vec3 previous = ray / inverse + view.camera_delta.xyz;
  s.motion_px = motionFromPrevious((view.previous_clip_from_relative * vec4(previous, 1.0)).xyw, gl_FragDepth);
#else
  s.motion_px = vec2(0.0);
#endif
#ifdef IDS
  s.id = ids[id_at];
#else
  s.id = 0u;
#endif
  writeGbuffer(s);
}

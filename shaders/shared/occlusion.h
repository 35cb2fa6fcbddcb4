// Is a sphere hidden behind what was drawn? Its bounds on the screen, and the texels of the depth
// pyramid that hold the farthest depth behind these bounds.
//
// A test that culls must never be wrong, whatever is rounded. So each bound contains its own error
// and that of the rasteriser. u = 2^-24 is half a unit in the last place of a float near 1; a GPU's
// division and square root may be off by 5u, its other operations by u.
//
//   kCenterError  64u  of the centre's distance. The rasteriser's silhouette disc (sphere.h) is off by
//                      17u + 2u, its projection by 3u, the axes below by 13u, a product with these 3u;
//                      the nearest point of the disc as computed here by 22u
//   kRadiusError 128u  of the radius: the disc's radius is off by 79u where the eye is no nearer to the
//                      sphere than kLeastGap, its axes by 8u, the sums by 8u
//   kPixelError   32u  of the picture's side: the bounds' own rounding (16u), the viewport's (8u)
//   kSnapPx            a vertex moves by so much when it is put on the rasteriser's grid, which has at
//                      least 16 steps a pixel
//   kDepthError   64u  of the depth, times 1 / cosine of the picture's corner: a rasteriser may take a
//                      triangle's depth from its plane's value at the picture's corner
#pragma once
#include "shared/prelude.h"
#ifdef __cplusplus
#include <glm/integer.hpp>
#endif
RULES_BEGIN

const float kCenterError = 3.814697265625e-06f;
const float kRadiusError = 7.62939453125e-06f;
const float kPixelError = 1.9073486328125e-06f;
const float kSnapPx = 0.03125f;
const float kDepthError = 3.814697265625e-06f;
// A sphere whose surface is nearer to the eye than this share of the centre's distance is never
// hidden: it covers 170 degrees of the view.
const float kLeastGap = 0.00390625f;
// The same for one farther away than this, m: squares of squares would overflow.
const float kMostDistance = 1e9f;
// A triangle seen on edge may get depths that are off by a part of its extent.
const float kEdgeOnShare = 0.015625f;

// Reach of a rasteriser, which fills the pixels whose centres it meets, and of what fills every pixel
// that it touches.
const float kReachCenters = 0.0f;
const float kReachTouched = 0.5f;

// The camera in the form that bounds need. Axes are unit vectors of relative space.
struct OcclusionView {
  vec4 right;      // w: pixels of one unit of (distance along right) / (distance along forward)
  vec4 up;         // likewise
  vec4 forward;    // w: distance of the near plane, m
  vec2 center_px;  // where forward meets the picture, jitter included
  vec2 last_px;    // the picture's last column and row
  float center_error;
  float margin_px;
  float depth_scale;  // 1 + the error of a rasterised depth
};
RULE OcclusionView occlusionView(mat4 clip_from_relative, vec2 size_px, float near_m) {
  mat4 m = clip_from_relative;
  vec3 row_x = vec3(m[0][0], m[1][0], m[2][0]);
  vec3 row_y = vec3(m[0][1], m[1][1], m[2][1]);
  vec3 row_w = vec3(m[0][3], m[1][3], m[2][3]);
  // Jitter adds a part of the view axis to the rows.
  vec2 shift = vec2(dot(row_x, row_w), dot(row_y, row_w));
  row_x = row_x - row_w * shift.x;
  row_y = row_y - row_w * shift.y;
  vec2 scale = vec2(sqrt(dot(row_x, row_x)), sqrt(dot(row_y, row_y)));
  OcclusionView v;
  v.right = vec4(row_x * (1.0f / scale.x), scale.x * size_px.x * 0.5f);
  v.up = vec4(row_y * (1.0f / scale.y), scale.y * size_px.y * 0.5f);
  v.forward = vec4(row_w, near_m);
  v.center_px = (shift + vec2(1.0f, 1.0f)) * size_px * 0.5f;
  v.last_px = size_px - vec2(1.0f, 1.0f);
  vec2 shift_share = abs(shift) / scale;
  v.center_error = kCenterError * (1.0f + max(shift_share.x, shift_share.y));
  v.margin_px = kSnapPx + kPixelError * max(size_px.x, size_px.y);
  vec2 corner = (vec2(1.0f, 1.0f) + abs(shift)) / scale;
  v.depth_scale = 1.0f + kDepthError * sqrt(1.0f + dot(corner, corner));
  return v;
}

// Least and greatest x / w over the points of a circle around (x, w), w > r > 0, seen from the
// origin; `product` = (w - r) (w + r). Both roots of the tangents' equation in the form that does not
// cancel: relative error 16u.
RULE vec2 slopeBounds(float x, float w, float r, float product) {
  float side = abs(x);
  float sum = side * w + r * sqrt(x * x + product);
  float outer = min(sum / product, 1e15f);
  float inner = (side - r) * (side + r) / sum;
  return x < 0.0f ? vec2(-outer, -inner) : vec2(inner, outer);
}

// Where a sphere, or what stands in its place, may show, and how near.
struct SphereBounds {
  bool known;  // false: too near to tell (or not finite); it counts as visible
  ivec2 first_px;
  ivec2 last_px;  // less than first_px in x or y: it meets no pixel of the screen
  float depth;    // nothing of it has a larger one; reversed, see view.h
};

// Between slopes (distance along right or up / distance along forward), no nearer than this depth.
RULE SphereBounds boundsBetween(OcclusionView v, vec2 least, vec2 most, float depth, float reach_px) {
  vec2 scale = vec2(v.right.w, v.up.w);
  vec2 low = v.center_px + scale * least - (v.margin_px + reach_px + 0.5f);
  vec2 high = v.center_px + scale * most + (v.margin_px + reach_px - 0.5f);
  SphereBounds b;
  b.known = true;
  b.first_px = ivec2(clamp(ceil(low), vec2(0.0f, 0.0f), v.last_px + vec2(1.0f, 1.0f)));
  b.last_px = ivec2(clamp(floor(high), vec2(-1.0f, -1.0f), v.last_px));
  b.depth = depth;
  return b;
}
RULE SphereBounds boundsUnknown() {
  SphereBounds b;
  b.known = false;
  b.first_px = ivec2(0, 0);
  b.last_px = ivec2(-1, -1);
  b.depth = 1.0f;
  return b;
}

// `disc`: it is drawn as its silhouette disc; otherwise as whatever lies in the sphere, triangles
// included. `reach_px`: pixels whose centres are so near to its silhouette count.
RULE SphereBounds sphereBounds(OcclusionView v, vec3 center, float radius, float reach_px, bool disc) {
  SphereBounds b = boundsUnknown();
  float x = dot(vec3(v.right), center), y = dot(vec3(v.up), center), w = dot(vec3(v.forward), center);
  float aside2 = x * x + y * y;
  float distance = sqrt(aside2 + w * w);
  float error = v.center_error * distance + kRadiusError * radius;
  float r = radius + error;
  float nearest = w - r;
  if (!(nearest >= v.forward.w && distance - r >= kLeastGap * distance && radius >= 0.0f &&
        distance <= kMostDistance))
    return b;

  float product = nearest * (w + r);
  if (disc) {
    float share = (distance - radius) * (distance + radius) / (distance * distance);
    float half_depth = radius * sqrt(share * aside2) / distance;  // of the disc, along the view axis
    nearest = w * share - half_depth - error;
    // The triangle around a disc reaches twice as far. Where it nears the eye's plane, its depth is
    // not precise enough.
    if (!(nearest >= 2.0f * half_depth)) return b;
  } else {
    nearest = max(nearest - kEdgeOnShare * radius, v.forward.w);
  }
  vec2 slope_x = slopeBounds(x, w, r, product), slope_y = slopeBounds(y, w, r, product);
  return boundsBetween(v, vec2(slope_x.x, slope_y.x), vec2(slope_x.y, slope_y.y), v.forward.w / nearest * v.depth_scale, reach_px);
}

// Where anything may show that lies within `reach` m of a box, however it is drawn: the picture of a box before the eye
// lies between those of its corners.
RULE SphereBounds boxBounds(OcclusionView v, vec3 low, vec3 high, float reach, float reach_px) {
  vec3 middle = 0.5f * (low + high), half_size = 0.5f * (high - low);
  vec3 size = abs(middle) + half_size;
  float distance = sqrt(dot(size, size)), around = reach + v.center_error * distance + kRadiusError * reach;
  half_size = half_size + around;
  float nearest = dot(vec3(v.forward), middle) - dot(abs(vec3(v.forward)), half_size);
  // Nearer, the triangles around discs may near the eye's plane.
  if (!(nearest >= max(v.forward.w, 4.0f * around) && distance <= kMostDistance)) return boundsUnknown();
  float depth = v.forward.w / max(nearest - kEdgeOnShare * around, v.forward.w) * v.depth_scale;

  vec2 least = vec2(1e30f, 1e30f), most = vec2(-1e30f, -1e30f);
  for (uint corner = 0u; corner < 8u; ++corner) {
    vec3 side = vec3(float(corner & 1u), float(corner >> 1u & 1u), float(corner >> 2u)) * 2.0f - 1.0f;
    vec3 p = middle + half_size * side;
    vec2 slope = vec2(dot(vec3(v.right), p), dot(vec3(v.up), p)) / dot(vec3(v.forward), p);
    least = min(least, slope);
    most = max(most, slope);
  }
  return boundsBetween(v, least, most, depth, reach_px);
}

// The pyramid. A texel of level k holds the farthest depth (the least: it is reversed) of the pixels
// (i << s) to (i + 1 << s) - 1 along x and y, s = kPyramidShift + k, as far as these are in the
// picture. The texture's sides are powers of two, so that every level halves without a rest; beyond
// pyramidTexels() its texels mean nothing.
const int kPyramidShift = 1;

RULE ivec2 pyramidTexels(ivec2 size_px, int level) {
  int shift = kPyramidShift + level;
  return (size_px + (1 << shift) - 1) >> shift;
}
// Texels along a side of level 0 of the texture.
RULE int pyramidSide(int side_px) {
  int texels = (side_px + (1 << kPyramidShift) - 1) >> kPyramidShift;
  return texels > 1 ? 2 << findMSB(texels - 1) : 1;
}

// Up to 2 x 2 texels that cover the pixels first_px to last_px: those of the finest level at which
// so few do.
struct PyramidFootprint {
  ivec2 first;
  ivec2 last;
  int level;
};
RULE PyramidFootprint pyramidFootprint(ivec2 first_px, ivec2 last_px) {
  PyramidFootprint f;
  f.first = first_px >> kPyramidShift;
  f.last = last_px >> kPyramidShift;
  ivec2 span = f.last - f.first;
  f.level = max(findMSB(max(span.x, span.y)), 0);
  ivec2 left = (f.last >> f.level) - (f.first >> f.level);
  if (max(left.x, left.y) > 1) ++f.level;
  f.first = f.first >> f.level;
  f.last = f.last >> f.level;
  return f;
}

// The one-candidate test of Michel and Boubekeur 2020, listing 2, in a form that is never wrong: does
// the inner sphere of one grain hide the outer sphere of another from the eye at the origin? True
// only if the second lies in the cone of rays that meet the first, and behind it.
//
// The distance of the second's centre to the cone's side, times |front|^2, is
//   r |front|^2 + r dot(front, step) - |cross(front, step)| sqrt(|front|^2 - r^2),
// step = back - front. Nothing cancels but what the positions themselves leave open; the error is less
// than 32u of the sum of the parts (listing 2 takes 1 - cosine^2 instead, whose error does not shrink
// with the angle).
RULE bool sphereHidesSphere(vec3 front, float inner_radius, vec3 back, float outer_radius) {
  const float kError = 1.9073486328125e-06f;
  float r0 = inner_radius, r1 = outer_radius;
  vec3 step_out = back - front;
  vec3 across = cross(front, step_out);
  float d0 = sqrt(dot(front, front)), d1 = sqrt(dot(back, back));
  float apart = sqrt(dot(step_out, step_out));
  if (!(r0 > 1e-9f && r1 >= 0.0f && d0 - r0 > kError * d0)) return false;  // the eye is in it
  // Length of the tangents to the first; whatever the first hides is as far away.
  float tangent = sqrt((d0 - r0) * (d0 + r0) + kError * d0 * d0);
  if (!(d1 - r1 >= tangent + kError * d1)) return false;
  float room = d0 * d0 * (r0 - r1) + r0 * dot(front, step_out) - sqrt(dot(across, across)) * tangent;
  return room > kError * d0 * (d0 * abs(r0 - r1) + (r0 + tangent) * apart);
}

RULES_END

// The camera of the frame, as every program reads it, and the rules that go with it.
//
// Space "relative": world axes, the camera at the origin, metres. No world position reaches the GPU,
// so 1e6 m from the origin looks like the origin. Clip depth is reversed with an infinite far plane:
// depth = near_m / distance along the view axis; 1 at the near plane, 0 at infinity.
#pragma once
#include "shaders/shared/bindings.h"
#include "shaders/shared/prelude.h"

RULES_BEGIN

// std140; the C++ copy has the same layout (asserted in modules/scene/view.cpp).
struct ViewBlock {
  mat4 clip_from_relative;           // with this sample's jitter: rasterise with this
  mat4 relative_from_clip;           // inverse of it
  mat4 steady_clip_from_relative;    // without jitter: motion vectors and reprojection use this
  mat4 previous_clip_from_relative;  // without jitter; takes positions relative to the previous camera
  vec4 camera_delta;      // xyz: camera - previous camera, m: previous_relative = relative + delta
                          // for what stands still
  vec4 frustum_planes[5]; // left, right, bottom, top, near: inside where dot(xyz, relative) + w >= 0;
                          // xyz is a unit vector, so the sum is a distance in m
  vec4 rotation;          // world from view, quaternion x, y, z, w; the camera looks along -Z
  vec2 size_px;
  vec2 jitter_px;         // the sample of a pixel is at its centre + jitter; +x right, +y up; 0
                          // outside truth mode
  float near_m;
  float pixels_at_1m;     // height in pixels of 1 m at a distance of 1 m
  float tan_half_fov_y;
  float tan_half_fov_x;
  uint frame;             // rendered frames so far
  uint sample_index;      // truth mode
  uint pad0;
  uint pad1;
};

// Normalised device coordinates of a point in pixels (pixel centres at +0.5, origin bottom left).
RULE vec2 ndcFromPixel(vec2 size_px, vec2 pixel_px) { return pixel_px / size_px * 2.0f - 1.0f; }

// Direction, not normalised, of the ray through normalised device coordinates; relative space.
// A point at depth 0 is at infinity, where the homogeneous coordinates are a direction.
RULE vec3 rayFromNdc(mat4 relative_from_clip, vec2 ndc) {
  return vec3(relative_from_clip * vec4(ndc, 0.0f, 1.0f));
}

// Relative position of a pixel with a depth > 0.
RULE vec3 relativeFromDepth(mat4 relative_from_clip, vec2 ndc, float depth) {
  vec4 point = relative_from_clip * vec4(ndc, depth, 1.0f);
  return vec3(point) / point.w;
}

// Distance along the view axis, m.
RULE float distanceFromDepth(float near_m, float depth) { return near_m / depth; }

RULES_END

#ifndef __cplusplus
layout(std140, binding = kViewBinding) uniform ViewUniforms { ViewBlock view; };
#endif

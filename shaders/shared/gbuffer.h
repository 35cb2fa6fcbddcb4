// What the G-buffer holds: rules that turn a surface into the values of its targets.
//
//   target            format          holds
//   gbuffer.albedo    RGBA8           square root of the linear base colour | metallic and spread of normals
//   gbuffer.normal    RGBA8           world normal, octahedral 12 + 12 bits | perceptual roughness of what has one
//                                     normal
//   gbuffer.emissive  R11F_G11F_B10F  emitted radiance
//   gbuffer.motion    RG16F           where the point is on the screen now, minus where it was one
//                                     frame ago, pixels, +x right, +y up, without jitter
//   gbuffer.id        R32UI           entity index + 1; 0 = nothing was drawn
//   gbuffer.depth     DEPTH32F        reversed: near / distance along the view axis; 0 = nothing
//
// 24 bytes a pixel, of which motion and id exist only where somebody reads them. Where depth is 0,
// only depth, id and emissive (0) are defined.
#pragma once
#include "shared/prelude.h"
#include "shared/spread.h"
RULES_BEGIN

// Longer motion is cut to this length, direction kept. Half a pixel of resolution in RG16F there.
const float kMaxMotionPx = 1024.0f;
// Largest finite value of R11F and G11F is 65024, of B10F 64512.
const float kMaxEmissive = 64512.0f;
// Largest radiance in the RGBA16F target; a brighter highlight is cut.
const float kMaxRadiance = 65000.0f;

// Base colour as stored, and back. The square root spreads 8 bits about as sRGB does, and its inverse
// is exact and cheap, where drivers approximate the decoding of sRGB textures (llvmpipe: by up to
// 1e-3, visible in dark colours).
RULE vec3 albedoCode(vec3 linear) { return sqrt(clamp(linear, 0.0f, 1.0f)); }
RULE vec3 albedoFromCode(vec3 code) { return code * code; }

// Metallic and spread (shared/spread.h) as stored, in [0, 1] of 8 bits, and back. Surfaces of one normal keep
// metallic in 128 steps, others in 5: nearly all are wholly of metal or not at all.
const float kMetallicSteps = 127.0f;
const float kSpreadMetallicSteps = 4.0f;
RULE float metallicSpreadCode(float metallic, float spread) {
  int steps = spreadCode(spread);
  float m = clamp(metallic, 0.0f, 1.0f);
  float first = kMetallicSteps + 1.0f + float(steps - 1) * (kSpreadMetallicSteps + 1.0f);
  float code = steps == 0 ? floor(m * kMetallicSteps + 0.5f) : first + floor(m * kSpreadMetallicSteps + 0.5f);
  return code * (1.0f / 255.0f);
}
RULE float metallicFromCode(float code) { return code * (255.0f / kMetallicSteps); }  // of one normal
struct MetallicSpread {
  float metallic;
  int spread;  // spreadFromCode()
};
RULE MetallicSpread metallicSpreadFromCode(float code) {
  int stored = int(code * 255.0f + 0.5f), beyond = stored - int(kMetallicSteps) - 1;
  bool spread = beyond >= 0;
  MetallicSpread s;
  s.metallic = spread ? float(beyond % (int(kSpreadMetallicSteps) + 1)) * (1.0f / kSpreadMetallicSteps) : metallicFromCode(code);
  s.spread = spread ? beyond / (int(kSpreadMetallicSteps) + 1) + 1 : 0;
  return s;
}

// Motion of a point at pixel `now_px` (of the picture without jitter) and distance `now_w` along the view axis,
// that one frame ago was at `previous_clip` (x, y, w of clip space, without jitter). Where the point
// was behind the near plane then, the way is followed back to that plane: the direction stays right
// and no division by w <= 0 happens.
RULE vec2 motionPx(vec2 now_px, float now_w, vec3 previous_clip, vec2 size_px, float near_m) {
  vec2 half_size = size_px * 0.5f;
  vec2 now_ndc = now_px / half_size - vec2(1.0f, 1.0f);
  vec3 p = previous_clip;
  if (!(p.z >= near_m)) {
    vec3 now = vec3(now_ndc * now_w, now_w);
    float t = (now_w - near_m) / max(now_w - p.z, 1e-20f);
    p = now + (p - now) * clamp(t, 0.0f, 1.0f);
    p.z = near_m;
  }
  vec2 motion = (now_ndc - vec2(p.x, p.y) / p.z) * half_size;
  float length2 = dot(motion, motion);
  if (!(length2 < 1e30f)) return vec2(0.0f, 0.0f);
  if (length2 > kMaxMotionPx * kMaxMotionPx) motion = motion * (kMaxMotionPx / sqrt(length2));
  return motion;
}

RULES_END

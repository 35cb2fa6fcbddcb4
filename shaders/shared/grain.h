// What the grain programs read, and the rules that place and colour a grain.
#pragma once
#include "shared/bindings.h"
#include "shared/prelude.h"
#include "shared/rotation.h"
RULES_BEGIN

// std430, 64 bytes. Positions are relative to the field's origin.
struct GrainRecord {
  vec3 position;  // at the current tick, m
  float radius;
  vec3 previous;  // at the previous tick
  uint look;      // packGrainLook() of shared/swarm.h: colour and roughness
  vec4 rotation;  // world from local at the current tick, quaternion x, y, z, w
  vec3 spin;      // rad/s
  uint id;        // entity index + 1
};

// std140: of one frame.
struct GrainFrame {
  vec4 origin;           // xyz: field's origin - camera, m
  vec4 previous_origin;  // xyz: the same one frame ago
  float alpha;           // time of the frame: 0 = previous tick, 1 = current tick
  float previous_alpha;  // of the frame before
  float tick_s;
  uint count;            // grains that are drawn
};

// Centre at a time between the ticks, relative to where `origin` is relative to.
RULE vec3 grainCenter(GrainRecord grain, vec3 origin, float alpha) {
  return origin + grain.previous + (grain.position - grain.previous) * alpha;
}

// Orientation `seconds` from the current tick, by the solver's own first-order rule.
RULE vec4 grainRotation(GrainRecord grain, float seconds) {
  vec3 h = grain.spin * (0.5f * seconds);
  vec4 q = grain.rotation;
  vec3 u = vec3(q.x, q.y, q.z);
  vec3 v = u + h * q.w + cross(h, u);
  float w = q.w - dot(h, u);
  vec4 turned = vec4(v.x, v.y, v.z, w);
  return turned * (1.0f / sqrt(dot(turned, turned)));
}

// Brightness of a grain's surface at a point of its unit sphere, local axes, around 1: a vein and
// two worn spots, by which its rolling is seen. `contrast` 0 to 1.
RULE float grainPattern(vec3 local, float contrast) {
  float vein = local.y + 0.35f * local.x * local.z;
  float dark = 1.0f - smoothstep(0.10f, 0.20f, abs(vein));
  float spot = smoothstep(0.82f, 0.90f, local.x);
  float pale = smoothstep(0.80f, 0.90f, -0.6f * local.x + 0.8f * local.z);
  return 1.0f + contrast * (0.25f * pale - 0.45f * dark - 0.3f * spot);
}
// Grains of few pixels show their mean colour: the pattern would only flicker.
RULE float grainContrast(float radius_px) { return clamp((radius_px - 2.0f) * 0.25f, 0.0f, 1.0f); }

RULES_END

#ifndef __cplusplus
layout(std430, binding = kGrainsBinding) readonly buffer Grains { GrainRecord grains[]; };
layout(std140, binding = kPassBinding) uniform GrainUniforms { GrainFrame frame; };
#endif

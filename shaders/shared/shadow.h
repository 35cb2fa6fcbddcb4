// The sun's shadow map: its view, as every program that draws into it or reads it sees it, and the
// filter's rules.
//
// Clip space of the map: xy in [-1, 1], depth reversed as everywhere: 1 at the caster plane nearest
// to the sun, 0 at the farthest, and 0 where nothing casts. A point is lit where its own depth is
// >= the stored one. Outside the map everything is lit.
//
// The target has kShadowMapSize^2 texels of 16 bits. Of these the lower left size_px are used, as
// many as the output's size deserves; clip_from_relative maps to these, so that whoever draws leaves
// viewport and scissor alone.
#pragma once
#include "shared/bindings.h"
#include "shared/prelude.h"
RULES_BEGIN

const int kShadowMapSize = 2048;
const float kShadowDepthSteps = 65535.0f;

// std140.
struct ShadowViewBlock {
  mat4 clip_from_relative;    // orthographic; `relative` as in view.h
  mat4 shadow_from_relative;  // to texels (xy in [0, size_px]) and depth
  vec4 axis_x;  // world axes of the map's +x (unit; w: half width of the map, m)
  vec4 axis_y;  // and +y (w: half height, m)
  vec4 to_sun;  // unit, towards the sun = towards greater depth (w: depth range 0 to 1, m)
  vec2 size_px;   // the part of the map that is used
  float texel_m;  // side of a texel
  float enabled;  // 1: there is a map; 0: nothing casts, read nothing
};

// Half the side, in texels, of the square that the filter below reads around a point: 3x3 bilinear
// comparisons with their weights folded into 2x2 fetches.
const float kShadowFilterTexels = 2.0f;

// How far a receiver with unit normal n is moved along n before it is compared, in m. In map axes the
// receiver's plane climbs towards the sun by -(n.x, n.y) / n.l a metre, so that over offsets of up to
// k texels along both axes the stored depth is above the plane by up to
// k texel (|n.x| + |n.y|) / n.l; moving by d along the normal gains d / n.l. Hence the bound below
// frees every plane of acne, and no smaller one does (normal offset: Holbert 2011; here with its
// constant derived). The constant part covers normals rounded to 12 bits, and the steps of the
// stored depth.
RULE float shadowNormalOffset(vec3 n, ShadowViewBlock shadow) {
  float tilt = abs(dot(n, vec3(shadow.axis_x))) + abs(dot(n, vec3(shadow.axis_y)));
  float step_m = shadow.to_sun.w / kShadowDepthSteps;
  return shadow.texel_m * (kShadowFilterTexels * tilt + 0.1f) + step_m;
}

// 3x3 tent of bilinear comparisons, as four bilinear fetches (the separable 1D filter
// (1 - f, 1, f) over texels i-1, i, i+1 with its two-sided bilinear footprint becomes two fetches).
// Along one axis: `f` in [0, 1) is the fractional position, in texels, from the texel centre to the
// left. Positions are in texels from that centre.
struct ShadowTaps {
  float weight0, weight1;      // sum 3
  float position0, position1;
};
RULE ShadowTaps shadowTaps(float f) {
  // Box of three bilinear samples at f - 1, f, f + 1: texel weights (1 - f, 1, 1, f) at -1, 0, 1, 2.
  ShadowTaps taps;
  taps.weight0 = 2.0f - f;
  taps.weight1 = 1.0f + f;
  taps.position0 = -1.0f + 1.0f / taps.weight0;
  taps.position1 = 1.0f + f / taps.weight1;
  return taps;
}

RULES_END

#ifndef __cplusplus
layout(std140, binding = kShadowViewBinding) uniform ShadowViewUniforms { ShadowViewBlock shadow_view; };
#endif

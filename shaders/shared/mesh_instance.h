// What the mesh programs read of an instance and of a material.
#pragma once
#include "shared/bindings.h"
#include "shared/prelude.h"
RULES_BEGIN

// std430, 112 bytes. Rows of 3x4 matrices: coordinate = dot(row.xyz, local) + row.w.
struct MeshInstanceRecord {
  vec4 relative_from_local[3];
  vec4 previous_relative_from_local[3];  // one frame ago, relative to the camera of that frame
  uint id;        // entity index + 1
  uint mirrored;  // 1: the transform turns the mesh inside out
  uint pad0;
  uint pad1;
};

// std430, 48 bytes: an instance in the shadow map; w is 1.
struct MeshCasterRecord {
  vec4 clip_from_local[3];
};

// std140.
struct MaterialConstants {
  vec4 base_color;  // linear; a = opacity
  vec4 emissive;    // rgb: radiance; a unused
  float metallic;
  float roughness;
  float normal_scale;
  float alpha_cutoff;
};

RULES_END

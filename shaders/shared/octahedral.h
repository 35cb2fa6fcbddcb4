// Unit vectors as points of a square: octahedral mapping, and its 24-bit form for 8-bit targets.
// Equations: Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
// Vectors", JCGT 3(2), listings 1 and 2.
#pragma once
#include "shared/prelude.h"
RULES_BEGIN

// Steps from 0 to 1 of one 12-bit coordinate. 0 and +-1 are among the codes, so the six axis
// directions survive packing exactly; 4095 of 4096 codes are used.
const float kOct12Steps = 2047.0f;

// Largest angle between a direction and its packed form: half a step along both coordinates, and the
// centre of an octahedron's face is 3 times as close to the origin as the square suggests.
const float kOct24MaxErrorRad = 1.04e-3f;

// +1 for -0, 0 and positive values. sign() would return 0 and collapse the border.
RULE float signNotZero(float x) { return x < 0.0f ? -1.0f : 1.0f; }

// Direction of any length -> [-1, 1]^2. What has no direction (zero, not finite) maps to (0, 0),
// which is +Z.
RULE vec2 octEncode(vec3 n) {
  float sum = abs(n.x) + abs(n.y) + abs(n.z);
  if (!(sum > 1e-30f && sum < 1e30f)) return vec2(0.0f, 0.0f);
  vec2 p = vec2(n.x, n.y) / sum;
  if (n.z < 0.0f) {
    p = vec2((1.0f - abs(p.y)) * signNotZero(p.x), (1.0f - abs(p.x)) * signNotZero(p.y));
  }
  return p;
}

// [-1, 1]^2 -> unit vector. The inverse of octEncode; (+-1, +-1) and the border's diamond edges
// meet at -Z and on z = 0 without a seam.
RULE vec3 octDecode(vec2 p) {
  float z = 1.0f - abs(p.x) - abs(p.y);
  float fold = max(-z, 0.0f);
  vec3 n = vec3(p.x - signNotZero(p.x) * fold, p.y - signNotZero(p.y) * fold, z);
  return n * (1.0f / sqrt(dot(n, n)));
}

// [-1, 1]^2 as 12 + 12 bits in three 8-bit unorm channels: (x high 8, x low 4 | y low 4, y high 8).
RULE vec3 octPack24(vec2 p) {
  float x = floor(clamp(p.x, -1.0f, 1.0f) * kOct12Steps + (kOct12Steps + 0.5f));  // 0 .. 4094
  float y = floor(clamp(p.y, -1.0f, 1.0f) * kOct12Steps + (kOct12Steps + 0.5f));
  float x_high = floor(x * (1.0f / 16.0f));
  float y_high = floor(y * (1.0f / 256.0f));
  float middle = (x - 16.0f * x_high) * 16.0f + y_high;
  return vec3(x_high, middle, y - 256.0f * y_high) * (1.0f / 255.0f);
}

// The inverse of octPack24, for channels read from a unorm target (or exact multiples of 1/255).
RULE vec2 octUnpack24(vec3 channels) {
  vec3 b = floor(channels * 255.0f + vec3(0.5f, 0.5f, 0.5f));
  float x_low = floor(b.y * (1.0f / 16.0f));
  float x = b.x * 16.0f + x_low;
  float y = (b.y - 16.0f * x_low) * 256.0f + b.z;
  return (vec2(x, y) - vec2(kOct12Steps, kOct12Steps)) * (1.0f / kOct12Steps);
}

RULES_END

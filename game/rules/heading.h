// Headings: unit vectors (x, z) seen from above, turned without transcendental functions, so that
// the result is the same on every machine.
#pragma once

#include <algorithm>
#include <cmath>

#include "engine/core/math.h"

namespace scree::hourglass {

inline vec2 normalizeOr(vec2 v, vec2 otherwise) {
  const float length = std::sqrt(v.x * v.x + v.y * v.y);
  return length > 1e-6f ? vec2{v.x / length, v.y / length} : otherwise;
}

// Turns by 2 atan(angle / 2), which is `angle` to third order; positive turns +Z towards +X.
inline vec2 turn(vec2 heading, float angle_rad) {
  const float t = 0.5f * angle_rad, scale = 1.0f / (1.0f + t * t);
  const float c = (1.0f - t * t) * scale, s = 2.0f * t * scale;
  return normalizeOr({c * heading.x + s * heading.y, c * heading.y - s * heading.x}, heading);
}

// Turns towards `goal` by at most `angle_rad`.
inline vec2 turnTowards(vec2 heading, vec2 goal, float angle_rad) {
  const float t = 0.5f * angle_rad;
  const float cos_angle = (1.0f - t * t) / (1.0f + t * t);
  if (heading.x * goal.x + heading.y * goal.y >= cos_angle) return goal;
  const float side = heading.y * goal.x - heading.x * goal.y;
  return turn(heading, side >= 0 ? angle_rad : -angle_rad);
}

// What is to the right of somebody who looks along `heading`.
inline vec2 rightOf(vec2 heading) { return {-heading.y, heading.x}; }

// Rotation about +Y that turns +Z into the heading.
inline quat rotationFromHeading(vec2 heading) {
  if (heading.y <= -0.999999f) return quat(0, 0, 1, 0);
  const float w = std::sqrt(std::max(0.0f, 0.5f * (1.0f + heading.y)));
  return glm::normalize(quat(w, 0, heading.x / (2.0f * w), 0));
}

}  // namespace scree::hourglass

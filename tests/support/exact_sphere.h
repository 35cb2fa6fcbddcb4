// Views and spheres for the tests of occlusion, and their bounds on the screen in double precision.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/random.h"
#include "engine/frame/frame.h"
#include "modules/scene/scene.h"

namespace scree::test {

using glm::dvec2;

struct Random {
  explicit Random(uint64_t seed_in) : seed(seed_in) {}
  uint64_t seed, drawn = 0;
  float unit() { return randomUnit(seed, drawn++, 0, 0); }
  float between(float low, float high) { return low + (high - low) * unit(); }
  float sign() { return unit() < 0.5f ? -1.0f : 1.0f; }
  dvec3 direction() {
    for (;;) {
      const dvec3 p(between(-1, 1), between(-1, 1), between(-1, 1));
      const double length2 = glm::dot(p, p);
      if (length2 > 0.01 && length2 < 1) return p / std::sqrt(length2);
    }
  }
};

inline quat lookingAlong(dvec3 direction, double roll = 0) {
  const dvec3 z = -glm::normalize(direction);
  const dvec3 x = glm::normalize(glm::cross(std::abs(z.y) < 0.9 ? dvec3(0, 1, 0) : dvec3(1, 0, 0), z));
  const dvec3 y = glm::cross(z, x);
  const double c = std::cos(roll), s = std::sin(roll);
  return quat(glm::quat_cast(glm::dmat3(x * c + y * s, y * c - x * s, z)));
}

inline View viewOf(dvec3 position, dvec3 direction, ivec2 size, float fov_y, float near_m, vec2 jitter = vec2(0),
                   double roll = 0) {
  Transform transform;
  transform.position = position;
  transform.rotation = lookingAlong(direction, roll);
  FrameInput input;
  input.size = size;
  input.jitter_px = jitter;
  return computeView(previousOf(transform), transform, {fov_y, near_m}, input);
}

inline View randomView(Random& random, ivec2 size, float fov_y, float near_m) {
  const vec2 jitter = random.unit() < 0.5f ? vec2(0) : vec2(random.between(-0.5f, 0.5f), random.between(-0.5f, 0.5f));
  return viewOf(dvec3(0), random.direction(), size, fov_y, near_m, jitter, random.between(-3, 3));
}

struct ExactBounds {
  dvec2 low{0}, high{0};    // of the silhouette, pixels
  double nearest = 0;       // least distance along the view axis of the sphere, m
  double disc_nearest = 0;  // of its silhouette disc
};

// The view that the rasteriser sees: the float matrix of the view block, in double precision.
struct ExactView {
  dvec3 right, up, forward;  // orthonormal
  dvec2 scale, center;       // pixels = center + scale * (along right or up) / (along forward)
  dvec2 tangent;             // of the half fields of view

  explicit ExactView(const View& view) {
    const glm::dmat4 rows = glm::transpose(glm::dmat4(view.block.clip_from_relative));
    const dvec2 size(view.block.size_px);
    forward = glm::normalize(dvec3(rows[3]));
    const dvec2 shift(glm::dot(dvec3(rows[0]), forward), glm::dot(dvec3(rows[1]), forward));
    right = dvec3(rows[0]) - forward * shift.x;
    up = dvec3(rows[1]) - forward * shift.y;
    tangent = dvec2(1 / glm::length(right), 1 / glm::length(up));
    right = glm::normalize(right);
    up = glm::normalize(up);
    scale = 0.5 * size / tangent;
    center = 0.5 * size * (1.0 + shift);
  }

  // A position at a distance along the view axis, aside by up to `spread` of the field of view.
  vec3 somewhere(Random& random, float along, double spread) const {
    const double x = tangent.x * spread * (double)random.between(-1, 1);
    const double y = tangent.y * spread * (double)random.between(-1, 1);
    return vec3((forward + right * x + up * y) * (double)along);
  }
  dvec3 aside(Random& random) const { return glm::normalize(right * (double)random.between(-1, 1) + up * 1.0); }

  // The sphere lies before the eye. Tangents by angles; the disc's nearest point by its plane.
  ExactBounds bounds(dvec3 c, double r) const {
    ExactBounds b;
    const double w = glm::dot(forward, c);
    for (int axis = 0; axis < 2; ++axis) {
      const double x = glm::dot(axis == 0 ? right : up, c);
      const double middle = std::atan2(x, w), half = std::asin(r / std::hypot(x, w));
      b.low[axis] = center[axis] + scale[axis] * std::tan(middle - half);
      b.high[axis] = center[axis] + scale[axis] * std::tan(middle + half);
    }
    b.nearest = w - r;
    const double distance2 = glm::dot(c, c), distance = std::sqrt(distance2);
    const dvec3 n = c / distance;
    const double sine = r / distance, cosine = std::sqrt((1 - sine) * (1 + sine));
    // Towards the eye's plane within the disc's plane.
    dvec3 down = n * glm::dot(n, forward) - forward;
    const double steep = glm::length(down);
    down = steep > 0 ? down / steep : dvec3(0);
    const dvec3 point = c * (cosine * cosine) + down * (r * cosine);
    b.disc_nearest = std::min(glm::dot(point, forward), w * cosine * cosine);
    return b;
  }
};

}  // namespace scree::test

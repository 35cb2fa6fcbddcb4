// Distance queries, poses and bounds of colliders.
#include "modules/grains/collider.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scree::grains {
namespace {

vec3 mix3(vec3 a, vec3 b, float t) { return a + (b - a) * t; }

// Normalised linear interpolation along the shorter arc; exact at the ends.
quat mixRotation(quat a, quat b, float t) {
  if (t <= 0) return a;
  if (t >= 1) return b;
  if (glm::dot(a, b) < 0) b = -b;
  return glm::normalize(a * (1 - t) + b * t);
}

SurfacePoint nearestOnBox(const PosedCollider& box, vec3 p) {
  const vec3 local = (p - box.position) * box.world_from_local;  // inverse rotation
  const vec3 clamped = glm::clamp(local, -box.half_extent, box.half_extent);
  const vec3 outside = local - clamped;
  const float square = glm::dot(outside, outside);
  if (square > 0) {
    const float distance = std::sqrt(square);
    const bool face = distance == std::max({std::abs(outside.x), std::abs(outside.y), std::abs(outside.z)});
    float flat = 0;
    if (face) {
      const vec3 slack = box.half_extent - glm::abs(local);
      flat = std::numeric_limits<float>::max();
      for (int k = 0; k < 3; ++k)
        if (slack[k] >= 0) flat = std::min(flat, slack[k]);
      flat = std::min(flat, distance);
    }
    // Below this a unit vector cannot be had from the difference; the nearest face does as well.
    if (distance > 1e-18f) return {box.world_from_local * (outside / distance), distance, flat};
  }
  const vec3 depth = glm::abs(local) - box.half_extent;
  int axis = 0;
  for (int k = 1; k < 3; ++k)
    if (depth[k] > depth[axis]) axis = k;
  vec3 normal(0);
  normal[axis] = local[axis] < 0 ? -1.0f : 1.0f;
  return {box.world_from_local * normal, depth[axis], 0};
}

SurfacePoint nearestOnCapsule(const PosedCollider& capsule, vec3 p) {
  const vec3 axis = capsule.b - capsule.a;
  const float square = glm::dot(axis, axis);
  const float t =
      square > 0 ? std::clamp(glm::dot(p - capsule.a, axis) / square, 0.0f, 1.0f) : 0.0f;
  const vec3 d = p - (capsule.a + axis * t);
  const float distance = std::sqrt(glm::dot(d, d));
  if (distance > 1e-18f) return {d / distance, distance - capsule.radius, 0};
  // On the axis: any direction across it.
  vec3 across = axis.y * axis.y <= 0.5f * square ? vec3(0, 1, 0) : vec3(1, 0, 0);
  if (square > 0) across -= axis * (glm::dot(across, axis) / square);
  return {glm::normalize(across), -capsule.radius, 0};
}

SurfacePoint nearestOnField(const PosedCollider& collider, vec3 p) {
  SurfacePoint near = collider.field->nearest((p - collider.position) * collider.world_from_local);
  near.normal = collider.world_from_local * near.normal;
  return near;
}

// The farthest that the field's surface is from its origin, m.
float reachOf(const DistanceField& field) {
  const auto [low, high] = field.bounds();
  return glm::length(glm::max(glm::abs(low), glm::abs(high)));
}

}  // namespace

PosedCollider poseCollider(const Collider& collider, float t0, float t1, float h) {
  PosedCollider posed;
  posed.shape = collider.shape;
  posed.half_extent = collider.half_extent;
  posed.radius = collider.radius;
  posed.field = collider.field.get();
  posed.position = mix3(collider.position0, collider.position1, t0);
  const quat rotation = mixRotation(collider.rotation0, collider.rotation1, t0);
  posed.world_from_local = glm::mat3_cast(rotation);
  posed.a = posed.position + posed.world_from_local * collider.a;
  posed.b = posed.position + posed.world_from_local * collider.b;
  posed.surface_velocity = posed.world_from_local * collider.surface_velocity;
  if (collider.moves() && h > 0) {
    const vec3 next = mix3(collider.position0, collider.position1, t1);
    posed.velocity = (next - posed.position) / h;
    quat turn = mixRotation(collider.rotation0, collider.rotation1, t1) * glm::conjugate(rotation);
    if (turn.w < 0) turn = -turn;
    posed.spin = vec3(turn.x, turn.y, turn.z) * (2 / h);  // sin(x) = x: 0.2 % short at 0.2 rad
  }
  return posed;
}

SurfacePoint nearestSurface(const PosedCollider& collider, vec3 p) {
  switch (collider.shape) {
    case Shape::Box:
      return nearestOnBox(collider, p);
    case Shape::Capsule:
      return nearestOnCapsule(collider, p);
    case Shape::Field:
      return nearestOnField(collider, p);
    case Shape::Plane:
      break;
  }
  const vec3 normal = collider.world_from_local[1];
  return {normal, glm::dot(normal, p - collider.position), std::numeric_limits<float>::max()};
}

float distanceTo(const PosedCollider& collider, vec3 p, float most) {
  if (collider.shape != Shape::Field) return nearestSurface(collider, p).distance;
  return collider.field->distance((p - collider.position) * collider.world_from_local, most);
}

float freeWay(const PosedCollider& collider, vec3 from, vec3 to, float distance, float core) {
  const vec3 way = to - from;
  const float length = glm::length(way);
  if (!(length + core >= distance)) return 1;
  // Each step goes as far as nothing can be. Along a surface steps stay as long as it is away; this
  // many are 48 radii for a grain that slides on one with a core of a quarter.
  constexpr int kMostSteps = 64;
  constexpr float kNear = 1.02f;
  float gone = 0;
  for (int step = 0; step < kMostSteps; ++step) {
    gone += distance - core;
    if (!(gone < length)) return 1;
    distance = distanceTo(collider, from + way * (gone / length), length - gone + 2 * core);
    if (!(distance > kNear * core)) {
      if (distance < core) gone -= core - distance;  // by rounding
      break;
    }
  }
  return std::max(gone / length, 0.0f);
}

float supportOffset(const PosedCollider& collider, vec3 n) {
  switch (collider.shape) {
    case Shape::Box: {
      const vec3 local = glm::abs(n * collider.world_from_local);
      return glm::dot(n, collider.position) + glm::dot(local, collider.half_extent);
    }
    case Shape::Capsule:
      return std::max(glm::dot(n, collider.a), glm::dot(n, collider.b)) + collider.radius;
    case Shape::Plane:
    case Shape::Field:
      break;
  }
  return glm::dot(collider.world_from_local[1], collider.position);
}

vec3 velocityAt(const PosedCollider& collider, vec3 p) {
  return collider.velocity + glm::cross(collider.spin, p - collider.position);
}

Bounds sweptBounds(const Collider& collider) {
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  if (collider.shape == Shape::Plane ||
      (collider.shape == Shape::Field && !(reachOf(*collider.field) < kInfinite)))
    return {vec3(-kInfinite), vec3(kInfinite)};
  Bounds bounds{vec3(std::numeric_limits<float>::max()), vec3(-std::numeric_limits<float>::max())};
  for (float t : {0.0f, 1.0f}) {
    const PosedCollider posed = poseCollider(collider, t, t, 0);
    vec3 low, high;
    if (collider.shape == Shape::Box) {
      const mat3& m = posed.world_from_local;
      const vec3 reach = glm::abs(m[0]) * posed.half_extent.x + glm::abs(m[1]) * posed.half_extent.y +
                         glm::abs(m[2]) * posed.half_extent.z;
      low = posed.position - reach;
      high = posed.position + reach;
    } else if (collider.shape == Shape::Field) {
      const auto [from, to] = collider.field->bounds();
      const mat3& m = posed.world_from_local;
      const vec3 half = 0.5f * (to - from);
      const vec3 middle = posed.position + m * (from + half);
      const vec3 reach = glm::abs(m[0]) * half.x + glm::abs(m[1]) * half.y + glm::abs(m[2]) * half.z;
      low = middle - reach;
      high = middle + reach;
    } else {
      low = glm::min(posed.a, posed.b) - posed.radius;
      high = glm::max(posed.a, posed.b) + posed.radius;
    }
    bounds.min = glm::min(bounds.min, low);
    bounds.max = glm::max(bounds.max, high);
  }
  // A turning shape bulges beyond the hull of its two end poses, by no more than it moves.
  if (collider.rotation0 != collider.rotation1 || collider.slack > 0) {
    const float bulge = motionBound(collider);
    bounds.min -= bulge;
    bounds.max += bulge;
  }
  return bounds;
}

float motionBound(const Collider& collider) {
  float reach = 0;
  if (collider.shape == Shape::Box) reach = glm::length(collider.half_extent);
  if (collider.shape == Shape::Capsule)
    reach = std::max(glm::length(collider.a), glm::length(collider.b)) + collider.radius;
  if (collider.shape == Shape::Field) reach = reachOf(*collider.field);
  // Chord of the turn by an angle: 2 sin(angle / 2), at most twice the quaternions' distance.
  const quat same = glm::dot(collider.rotation0, collider.rotation1) < 0 ? -collider.rotation1
                                                                         : collider.rotation1;
  const float turn = 2 * glm::length(same - collider.rotation0);
  const bool endless = collider.shape == Shape::Plane || !(reach < std::numeric_limits<float>::infinity());
  if (endless) reach = 0;
  const float tilt = endless && turn > 0 ? std::numeric_limits<float>::infinity() : 0.0f;
  return glm::length(collider.position1 - collider.position0) + turn * reach + tilt + collider.slack;
}

float thicknessOf(const Collider& collider) {
  switch (collider.shape) {
    case Shape::Box:
      return 2 * std::min({collider.half_extent.x, collider.half_extent.y, collider.half_extent.z});
    case Shape::Capsule:
      return 2 * collider.radius;
    case Shape::Field:
      return 0;
    case Shape::Plane:
      break;
  }
  return std::numeric_limits<float>::infinity();
}

}  // namespace scree::grains

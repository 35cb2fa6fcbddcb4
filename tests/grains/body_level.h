// A world of rigid bodies and grains, and what to ask of a body.
#pragma once

#include "tests/grains/level.h"

namespace scree::grains::test {

inline constexpr double kG = 9.81;

struct BodyLevel : Level {
  using Level::Level;

  Entity floor(float friction = 0.5f, vec3 half = {20, 0.5f, 20}) {
    return world.spawn(at({0, -static_cast<double>(half.y), 0}), BoxCollider{.half_extent = half, .friction = friction},
                       LoadSensor{});
  }
  Entity box(dvec3 place, vec3 half, RigidBody body = {}, float friction = 0.5f) {
    body.damping = 0;
    return world.spawn(at(place), BoxCollider{.half_extent = half, .friction = friction}, body);
  }
  const Transform& place(Entity e) { return *world.peek<Transform>(e); }
  const RigidBody& body(Entity e) { return *world.peek<RigidBody>(e); }
  bool sleeps(Entity e) { return body(e).asleep; }
  double load(Entity e) { return -static_cast<double>(world.peek<LoadSensor>(e)->impulse.y) * 60 / kG; }
};

}  // namespace scree::grains::test

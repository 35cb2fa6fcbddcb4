// Bodies that grains push back: rigid, with mass and spin, free or on a hinge or a slider. Part of
// grains.h, which includes it.
// The components go on an entity with a Transform and exactly one collider that has a volume: Box,
// Capsule, Sphere, Hull, solid Mesh or Sdf. The simulation writes the Transform; whoever writes it, or
// the velocity or spin, moves the body there and wakes it. Values that are not allowed are refused with
// one line in the log: the body then stands like a collider. A world with none of these pays nothing.
#pragma once

#include <string>

#include "engine/core/math.h"
#include "engine/ecs/world.h"

namespace scree {

// Mass, centre and moments of inertia are those of the collider's shape, filled evenly. A body that leaves
// GrainField's bounds is destroyed, and counted as lost.
struct RigidBody {
  float density = 500;  // more than 0
  float mass = 0;       // above 0: this instead of density x volume
  vec3 velocity{0};     // of the centre of mass
  vec3 spin{0};         // world axes
  float damping = 0.05f;  // fraction of velocity and spin lost a second
  bool asleep = false;    // kept by the simulation: at rest, its Transform stays to the bit
};
std::string fault(const RigidBody& value);
std::string faultIn(World& world, Entity entity, const RigidBody& value);
SCREE_COMPONENT(RigidBody, (density, "kg/m^3"), (mass, "kg"), (velocity, "m/s"), (spin, "rad/s"),
                (damping, "1/s"), (asleep, ""));

// The body only turns, about a line that is fixed in the world: where `axis` through `point` was when
// the simulation first saw it.
struct BodyHinge {
  vec3 point{0};       // local, scaled as the collider is
  vec3 axis{0, 0, 1};  // local
  float resistance = 0;  // torque against the turn, N m a rad/s
  // Kept by the simulation; `placed` = false: the Transform says anew where the line is.
  bool placed = false;
  dvec3 pivot{0};
  vec3 line{0, 0, 1};  // world axes
};
std::string fault(const BodyHinge& value);
std::string faultIn(World& world, Entity entity, const BodyHinge& value);
SCREE_COMPONENT(BodyHinge, (point, "m"), (axis, ""), (resistance, "N m s"), (placed, ""), (pivot, "m"),
                (line, ""));

// The body only slides along `axis`, from where the simulation first saw it, on a spring:
// force = -stiffness x travel - resistance x speed, and stops hard at the limits.
struct BodySlider {
  vec3 axis{0, 1, 0};  // world axes
  float stiffness = 0;
  float resistance = 0;
  float low = -1, high = 1;  // of the travel, -1e9 to 1e9
  float travel = 0;          // kept by the simulation: along the axis from home
  bool placed = false;       // false: the Transform says anew where home is
  dvec3 home{0};
};
std::string fault(const BodySlider& value);
std::string faultIn(World& world, Entity entity, const BodySlider& value);
SCREE_COMPONENT(BodySlider, (axis, ""), (stiffness, "N/m"), (resistance, "N s/m"), (low, "m"), (high, "m"),
                (travel, "m"), (placed, ""), (home, "m"));

// World singleton, of the last tick, for tests and overlays.
struct BodyStats {
  uint32_t bodies = 0;
  uint32_t asleep = 0;    // of them
  uint32_t contacts = 0;  // of bodies with colliders and each other that carry an impulse
  uint64_t solved = 0;    // substeps of bodies since the start: none for those asleep
};

}  // namespace scree

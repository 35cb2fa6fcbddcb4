// Clumps: 2 to 4 spheres joined rigidly, such as beans and bolts. Part of grains.h, which includes it.
//
// The spheres, its members, are grains of their own: contacts, forces, drag, blows, strikes, sensors and
// grids meet each of them. The joint is solved as one block (see the solver's clumps.h): members move and
// turn as one body, which falls asleep and wakes as a whole. A sink swallows it whole as soon as a
// member's centre is inside, and it is lost whole when a member leaves the bounds. A clump of which a
// member is destroyed, or refused, falls apart: the others are free grains from then on.
//
// Mass: density x volume of the spheres' union, by formula for two spheres, and to 1e-3 for more. It is
// shared by the spheres' volumes, so that a member's GrainMaterial::density is below the solid's where
// they overlap; region sensors and sinks add up to the whole. Centre of mass and inertia are those of the
// members as solid spheres of that density: exact where they do not overlap, else too small. Measured
// against points in the union: tetrapod 0.01 %, triangle 2 %, bolt 6 % (its centre of mass 0.05 radii off),
// bean 6 % along it and 12 % across, rod 9 % and 13 %.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/math.h"
#include "engine/ecs/world.h"

namespace scree {

inline constexpr uint32_t kMostMembers = 4;

// On each grain of a clump. Its GrainOrientation is the clump's rotation. A program may write position,
// velocity or spin of a member: the clump then takes them on by the member's share of its inertia.
struct GrainClump {
  Entity first = Entity::kNone;  // the clump's first member
  uint32_t member = 0;           // from 0 on
  uint32_t count = 0;            // members, 2 to kMostMembers
  vec3 arm{0};                   // from the centre of mass to the member, before the clump's rotation
};
std::string fault(const GrainClump& value);
SCREE_COMPONENT(GrainClump, (first, ""), (member, ""), (count, ""), (arm, "m"));

// On the entity of a GrainBlock or GrainEmitter: clumps instead of spheres, each turned at random. Lengths
// are in units of the block's or emitter's radius, and vary with it; both count clumps. A block's lattice
// has room for the sphere around a clump, of which `spacing` must be the diameter or more.
struct ClumpShape {
  // "bean", "bolt", "rod", "triangle", "tetrapod", or nothing: the members below.
  char name[16] = {};
  int32_t count = 2;  // members, 2 to kMostMembers
  std::array<vec3, kMostMembers> offset{vec3(-0.5f, 0, 0), vec3(0.5f, 0, 0), vec3(0), vec3(0)};
  std::array<float, kMostMembers> radius{1, 1, 1, 1};  // 0.01 to 10
};
std::string fault(const ClumpShape& value);
std::string faultIn(World& world, Entity entity, const ClumpShape& value);
SCREE_COMPONENT(ClumpShape, (name, ""), (count, ""), (offset, "radii"), (radius, "radii"));

}  // namespace scree

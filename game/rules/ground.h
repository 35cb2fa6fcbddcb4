// What a creature stands on and walks against: the level's static boxes and planes.
#pragma once

#include "engine/core/math.h"
#include "engine/ecs/world.h"

namespace scree::hourglass {

struct SphereContact {
  dvec3 center{0};        // moved out of all colliders
  vec3 ground_normal{0};  // of the steepest-up contact; zero: none
};

// Moves a sphere out of the boxes and planes of the world, at most a few corrections. Colliders
// that belong to a creature's plough are left out.
SphereContact pushOut(World& world, dvec3 center, double radius);

// True if some box or plane is within `reach` metres of the point.
bool isSupported(World& world, const dvec3& point, double reach);

}  // namespace scree::hourglass

// Forces and blows as the solver sees them: regions relative to the field's origin, and what they do
// to a grain. The equations are at GrainForce and GrainBlow.
#pragma once

#include <span>

#include "modules/grains/bodies.h"

namespace scree::grains {

struct Force {
  vec3 centre{0};
  mat3 world_from_local{1};
  vec3 half{0};
  vec3 low{0}, high{0};   // bounds of the box
  vec3 acceleration{0};   // world axes
  float attraction = 0, falloff = 1;
  float drag = 0;
  vec3 flow{0};           // world axes
  float swirl = 0;
  float wake_above = 1;   // m/s^2

  bool operator==(const Force&) const = default;
};

struct Blow {
  vec3 centre{0};
  float radius = 0;
  float strength = 0;  // N s/m^2
};

// Change of velocity within h seconds, beside `gravity_step`, of a grain that is at `position` in the
// middle of them (a leapfrog step: symplectic, second order) and had `velocity` at their begin. Drag takes
// 1 / (1 + x + x^2/2), x = drag h, for exp(-x): second order, and stable for every drag.
vec3 pushOf(std::span<const Force> forces, vec3 position, vec3 velocity, vec3 gravity_step, float h);

// Whether a force would wake a grain that rests there.
bool wakes(const Force& force, vec3 position);
bool wakesAny(std::span<const Force> forces, vec3 position);

// Change of velocity by a blow.
vec3 kickOf(const Blow& blow, vec3 position, float radius, float density);
// A blow that would make a sleeper faster wakes it, m/s.
inline constexpr float kStirred = 1e-3f;

}  // namespace scree::grains

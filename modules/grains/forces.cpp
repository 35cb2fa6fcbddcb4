// What forces and blows do to grains: pushes, kicks, and which sleepers they wake.
#include "modules/grains/forces.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

#include "engine/core/parallel.h"
#include "modules/grains/solver.h"

namespace scree::grains {
namespace {

using glm::length;

// A force's share at a point: acceleration whatever the velocity, and the air's velocity.
struct Share {
  vec3 acceleration{0}, air{0};
};

// False if the point is outside.
bool shareAt(const Force& force, vec3 position, Share& share) {
  const vec3 d = position - force.centre;
  const vec3 local = d * force.world_from_local;
  if (!(std::abs(local.x) <= force.half.x && std::abs(local.y) <= force.half.y &&
        std::abs(local.z) <= force.half.z))
    return false;
  share.acceleration = force.acceleration;
  share.air = force.flow;
  if (force.attraction != 0) {
    // In units of the falloff: no power of a length leaves float's range.
    const vec3 x = d / force.falloff;
    const float square = 1 + glm::dot(x, x);
    share.acceleration -= x * (force.attraction / (square * std::sqrt(square)));
  }
  if (force.swirl != 0) {
    const vec3 axis = force.world_from_local[1];
    const vec3 across = glm::cross(axis, d) / force.falloff;
    share.air += across * (2 * force.swirl / (1 + glm::dot(across, across)));
  }
  return true;
}

}  // namespace

vec3 pushOf(std::span<const Force> forces, vec3 position, vec3 velocity, vec3 gravity_step, float h) {
  vec3 acceleration(0), air(0);
  float drag = 0;
  for (const Force& force : forces) {
    Share share;
    if (!shareAt(force, position, share)) continue;
    acceleration += share.acceleration;
    air += force.drag * share.air;
    drag += force.drag;
  }
  if (!(drag > 0)) return h * acceleration;
  const float x = drag * h;
  return ((1 + 0.5f * x) / (1 + x + 0.5f * x * x)) *
             (gravity_step + h * (acceleration + air - drag * velocity)) -
         gravity_step;
}

bool wakes(const Force& force, vec3 position) {
  Share share;
  return shareAt(force, position, share) &&
         length(share.acceleration + force.drag * share.air) > force.wake_above;
}

bool wakesAny(std::span<const Force> forces, vec3 position) {
  for (const Force& force : forces)
    if (wakes(force, position)) return true;
  return false;
}

vec3 kickOf(const Blow& blow, vec3 position, float radius, float density) {
  const vec3 d = position - blow.centre;
  const float distance = length(d);
  if (!(distance < blow.radius) || !(distance > 0)) return vec3(0);
  // pi r^2 / mass
  const float speed = blow.strength * (1 - distance / blow.radius) * 0.75f / (radius * density);
  return d * (std::clamp(speed, -kMostBlow, kMostBlow) / distance);
}

// Sleepers that forces or blows move. What a force leaves asleep once it leaves asleep until it, or
// who sleeps, has changed.
void GrainSolver::findPushed(const StepParameters& parameters) {
  for (const Blow& blow : parameters.blows) {
    sleepers_.near(blow.centre - blow.radius, blow.centre + blow.radius, [&](uint32_t berth) {
      const Sleeper& sleeper = sleepers_[berth];
      const vec3 kick = kickOf(blow, sleeper.position, sleeper.radius, sleepers_.materialOf(berth).density);
      if (length(kick) >= kStirred) waking_.push_back(berth);
    });
  }
  if (parameters.forces.empty()) {
    forces_seen_.clear();
    return;
  }
  if (sleepers_.changes() == sleepers_seen_ &&
      std::equal(forces_seen_.begin(), forces_seen_.end(), parameters.forces.begin(),
                 parameters.forces.end()))
    return;
  const size_t before = waking_.size();
  for (const Force& force : parameters.forces) {
    sleepers_.near(force.low, force.high, [&](uint32_t berth) {
      if (wakes(force, sleepers_[berth].position)) waking_.push_back(berth);
    });
  }
  if (waking_.size() != before) return;
  forces_seen_.assign(parameters.forces.begin(), parameters.forces.end());
  sleepers_seen_ = sleepers_.changes();
}

void GrainSolver::strikeBlows(std::span<const Blow> blows) {
  for (const Blow& blow : blows) {
    for (uint32_t k = 0; k < bodies_.count; ++k) {
      if (!isAwake(bodies_, k)) continue;
      Body& body = bodies_.body[k];
      const vec3 kick = kickOf(blow, body.position, body.radius, bodies_.materialOf(k).density);
      body.velocity += kick;
    }
  }
}

}  // namespace scree::grains

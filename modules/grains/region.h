// Regions of the world that components span, in the field's coordinates, and the grains in them.
#pragma once

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <cmath>
#include <string>

#include "modules/grains/state.h"

namespace scree::grains {

// An oriented box, or a sphere, relative to the field's origin.
struct Region {
  vec3 centre{0};
  mat3 world_from_local{1};
  vec3 half{0};
  float radius = 0;        // above 0: a sphere
  vec3 low{0}, high{0};  // bounds, world axes

  vec3 local(vec3 position) const { return (position - centre) * world_from_local; }
  bool holds(vec3 position) const {
    if (radius > 0) {
      const vec3 d = position - centre;
      return glm::dot(d, d) <= radius * radius;
    }
    const vec3 at = local(position);
    return std::abs(at.x) <= half.x && std::abs(at.y) <= half.y && std::abs(at.z) <= half.z;
  }
};

Region regionOf(const Transform& transform, vec3 half_extent, float radius, const dvec3& origin);

// What is wrong with a Transform; empty: nothing. `origin`: the field's; `size`: what the scale multiplies.
std::string faultOf(const Transform& transform, const dvec3& origin, vec3 size);

// Says that a component is refused: the first of a system, when more than before are.
void refuse(Refusals& refusals, const World& world, const char* system, const char* component,
            Entity entity, const std::string& wrong);
void closeRefusals(Refusals& refusals);

// Whether the solver's bodies and sleepers are the world's grains, as they are now.
inline bool solverIsCurrent(const GrainsState& state) {
  return state.grains.version() == state.rows_seen && state.solver.current();
}

// Calls visit(berth) once for each sleeper whose sphere touches the box, and some others.
template <class Visit>
void eachSleeperNear(GrainsState& state, vec3 low, vec3 high, const Visit& visit) {
  std::vector<uint8_t>& met = state.berth_met;  // all 0 between calls
  std::vector<uint32_t>& berths = state.berths;
  berths.clear();
  // Of a region without bounds, all.
  constexpr float kFar = 4 * kMostDistance;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = low[axis] > -kFar ? low[axis] : -kFar;
    high[axis] = high[axis] < kFar ? high[axis] : kFar;
  }
  state.solver.sleepers().near(low, high, [&](uint32_t berth) {
    if (berth >= met.size()) met.resize(berth + 1 + berth / 4, 0);
    if (met[berth] != 0) return;
    met[berth] = 1;
    berths.push_back(berth);
  });
  for (const uint32_t berth : berths) {
    met[berth] = 0;
    visit(berth);
  }
}

// A grain as the world has it.
struct SeenGrain {
  Entity entity;
  vec3 position{0};
  float radius = 0;
  vec3 velocity{0};
  float density = 0;
};

// Calls visit(SeenGrain) for all grains whose spheres touch the box, and for others, each once and in
// no set order. Sleepers elsewhere are not looked at, as long as nobody but the solver has changed
// grains.
template <class Visit>
void eachGrainNear(GrainsState& state, vec3 low, vec3 high, const Visit& visit) {
  if (!solverIsCurrent(state)) {
    state.seen.each([&](Entity entity, const Grain& grain, const GrainVelocity& velocity,
                        const GrainMaterial& material) {
      visit(SeenGrain{entity, grain.position, grain.radius, velocity.linear, material.density});
    });
    return;
  }
  state.solver.eachAwake([&](Entity entity, const Body& body, const GrainMaterial& material) {
    visit(SeenGrain{entity, body.position, body.radius, body.velocity, material.density});
  });
  eachSleeperNear(state, low, high, [&](uint32_t berth) {
    const Sleeper& sleeper = state.solver.sleepers()[berth];
    visit(SeenGrain{sleeper.entity, sleeper.position, sleeper.radius, vec3(0),
                    state.solver.sleepers().materialOf(berth).density});
  });
}

// Mass and volume of a solid sphere in double precision.
inline double volumeOf(float radius) {
  const double r = radius;
  return 4.18879020478639098462 * r * r * r;
}

}  // namespace scree::grains

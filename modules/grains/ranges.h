// Ranges that several components of the module share.
#pragma once

#include <string>

#include "engine/ecs/range.h"
#include "modules/grains/grains.h"
#include "modules/grains/solver.h"

namespace scree::grains {

inline constexpr double kMostFriction = 1000;
inline constexpr double kMostSize = 1e9;  // m

inline std::string sizeFault(vec3 half_extent, double least = 0) {
  return firstFault({{"half_extent.x", half_extent.x, least, kMostSize},
                     {"half_extent.y", half_extent.y, least, kMostSize},
                     {"half_extent.z", half_extent.z, least, kMostSize}});
}

// Of what an emitter and a block say of their grains.
template <class Maker>
std::string kindFault(const Maker& m) {
  return firstFault({{"radius_jitter", m.radius_jitter, 0, 0.9f},
                     {"the smallest radius", m.radius * (1 - m.radius_jitter), kLeastRadius, kMostRadius},
                     {"the largest radius", m.radius * (1 + m.radius_jitter), kLeastRadius, kMostRadius},
                     {"density", m.density, kLeastDensity, kMostDensity},
                     {"friction", m.friction, 0, kMostFriction},
                     {"rolling_friction", m.rolling_friction, 0, kMostFriction},
                     {"restitution", m.restitution, 0, 1},
                     {"cohesion", m.cohesion, 0, kMostCohesion},
                     {"color.x", m.color.x, 0, 1},
                     {"color.y", m.color.y, 0, 1},
                     {"color.z", m.color.z, 0, 1},
                     {"roughness", m.roughness, 0, 1},
                     {"color_jitter", m.color_jitter, 0, 1}});
}

inline std::string firstOf(std::string a, const std::string& b) { return a.empty() ? b : a; }

}  // namespace scree::grains

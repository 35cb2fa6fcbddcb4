// Ranges that several components of the module share.
#pragma once

#include <string>

#include "engine/ecs/range.h"
#include "modules/grains/grains.h"

namespace scree::grains {

inline constexpr double kMostFriction = 1000;
inline constexpr double kMostSize = 1e9;  // m

inline std::string sizeFault(vec3 half_extent, double least = 0) {
  return firstFault({{"half_extent.x", half_extent.x, least, kMostSize},
                     {"half_extent.y", half_extent.y, least, kMostSize},
                     {"half_extent.z", half_extent.z, least, kMostSize}});
}

inline std::string firstOf(std::string a, const std::string& b) { return a.empty() ? b : a; }

}  // namespace scree::grains

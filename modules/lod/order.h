// The order of grains in which neighbours in the list are neighbours in space.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/math.h"

namespace scree::lod {

// Numbers of the points along a curve that fills the box around them (Morton 1966), 1,024 steps a side; those in one
// step in their own order. Positions must be finite.
std::vector<uint32_t> orderInSpace(std::span<const vec3> positions);

}  // namespace scree::lod

// The smallest ellipsoid around a grain's mesh.
#pragma once

#include <span>

#include "engine/core/math.h"
#include "shaders/shared/ellipsoid.h"

namespace scree::impostors {

// Holds all points; its volume is about 1 % above the least at most (Khachiyan 1996), but no half-axis is below half
// of kThinnestBound. The unit ball, where that is not much larger. Points in the grain's space: none is farther than
// 1 from the origin.
inline constexpr double kThinnestBound = 0.05;
rules::Ellipsoid boundingEllipsoid(std::span<const dvec3> points);

}  // namespace scree::impostors

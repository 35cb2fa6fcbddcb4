// How far two surfaces of triangles are apart.
#pragma once

#include <span>

#include "engine/assets/mesh_data.h"

namespace scree {

// A bound of the largest distance of a point of one from the other, both ways (Hausdorff), at most 5 % or 1e-4 of the
// largest extent above it. Of more than kMostPairs pairs of triangles some of the one are looked at, and their largest
// distance is raised by a quarter: no bound, then.
inline constexpr double kMostPairs = 2e8;
double surfaceDistance(std::span<const MeshData> a, std::span<const MeshData> b);

}  // namespace scree

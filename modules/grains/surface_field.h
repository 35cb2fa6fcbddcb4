// Hulls and meshes as distance fields.
#pragma once

#include <memory>
#include <span>

#include "engine/core/result.h"
#include "modules/grains/grains.h"

namespace scree::grains {

using SharedField = std::shared_ptr<const DistanceField>;

// The convex hull of points: exact inside and outside.
Result<SharedField> makeHull(std::span<const vec3> points);

// Triangles, three corners each, half of `thickness` thick on each side. Not solid: a sheet, whose
// distance is never negative (but by its thickness) and whose normal points to the side of p.
Result<SharedField> makeMesh(std::span<const vec3> corners, bool solid, float thickness);

// The signed distance to closed triangles, sampled with so many cells along the longest side.
Result<SharedField> bakeMesh(std::span<const vec3> corners, int resolution);

}  // namespace scree::grains

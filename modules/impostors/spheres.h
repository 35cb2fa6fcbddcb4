// The spheres around and inside a grain's mesh, and the ellipsoid that stands for its surface.
#pragma once

#include <span>
#include <vector>

#include "engine/core/math.h"
#include "shaders/shared/impostor.h"

namespace scree::impostors {

struct Sphere {
  dvec3 center{0};
  double radius = 0;
};
// The smallest sphere that holds all points (Welzl 1991); exact but for rounding, by which `radius`
// is grown, so that no point lies outside. Expected time linear in the number of points.
Sphere enclosingSphere(std::span<const dvec3> points);

// Triangles as three corners each.
using Corners = std::vector<dvec3>;

double distanceToTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c);
// Radius of the largest sphere around `center` that no triangle enters; 0 if the centre is not
// inside the surface (generalised winding number under 1/2; Jacobson et al. 2013).
double innerRadius(const Corners& corners, const dvec3& center);

// A centre with a large inner sphere for its outer one: searched from the enclosing sphere's
// centre, by steps that grow r / R, as long as R stays within kMostGrowth of the smallest. What is
// long or flat has many centres of nearly equal R, and what r is decides how much a grain hides.
inline constexpr double kMostGrowth = 1.04;
Sphere roomySphere(std::span<const dvec3> points, const Corners& corners);

// The ellipsoid with the volume's centroid and second moments, exact for meshes that are
// ellipsoids. What has no volume (open or inside out): the sphere around the origin with
// `fallback_radius`. Corners in the grain's space.
rules::ImpostorProxy proxyOf(const Corners& corners, double fallback_radius);

}  // namespace scree::impostors

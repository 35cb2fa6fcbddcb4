// The convex hull of points.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/core/math.h"

namespace scree::grains {

// The most points of which a hull is made; more are refused.
inline constexpr size_t kMostHullPoints = size_t{1} << 18;

// Triangles (three corners each, counter-clockwise seen from outside) of the convex hull, a closed
// surface whose corners are among the points; points nearer to a face than rounding in double are
// taken to be on it. Quickhull (Barber, Dobkin and Huhdanpaa, "The Quickhull Algorithm for Convex
// Hulls", 1996). Empty, or what is wrong: too many points, or points in a plane.
std::string convexHull(std::span<const vec3> points, std::vector<vec3>& corners);

}  // namespace scree::grains

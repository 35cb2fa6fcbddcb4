// What a rigid body's shape is to the solver: its mass when filled evenly, and the points and edges
// with which it touches others.
#pragma once

#include <span>
#include <vector>

#include "modules/grains/collider.h"

namespace scree::grains {

struct RigidForm {
  struct Edge {
    uint32_t a, b;  // points
  };
  std::vector<vec3> point;  // local
  std::vector<Edge> edge;   // only those that stand out
  float radius = 0;         // m, around all points and edges: those of a capsule are inside
  // Filled with 1 kg/m^3, local: mass, centre of mass, moments about that.
  double volume = 0;
  dvec3 centre{0};
  glm::dmat3 inertia{0};
  float reach = 0;  // of the surface from the local origin, m
  bool convex = false;  // the hull of the points, with the radius around it
};

// Twice what closed triangles hold over their area, m: of a plate its thickness, of a ball two thirds of its radius.
// Below 0: they are inside out.
double thicknessOf(std::span<const vec3> corners);

// Points of a field's surface that stand for the rest where it has more: those farthest out.
inline constexpr size_t kMostPoints = 96;

// Planes have no points and no volume, sheets no volume.
RigidForm formOf(const Collider& collider);
// The points and edges alone, of colliders that are no bodies: none if there are more than kMostPoints.
RigidForm outlineOf(const Collider& collider);

}  // namespace scree::grains

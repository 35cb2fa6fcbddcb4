// The point of a triangle that is nearest to a point, in double precision.
#pragma once

#include <glm/geometric.hpp>

#include <cstdint>

#include "engine/core/math.h"

namespace scree {

// Which part of the triangle abc is nearest: edges are ab, bc, ca.
enum class TriangleFeature : uint8_t { Face, Edge0, Edge1, Edge2, Vertex0, Vertex1, Vertex2 };

struct OnTriangle {
  dvec3 point{0};
  TriangleFeature feature = TriangleFeature::Face;
};

// By Voronoi regions (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5). The triangle
// has an area.
inline OnTriangle nearestOnTriangle(dvec3 p, dvec3 a, dvec3 b, dvec3 c) {
  const dvec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {a, TriangleFeature::Vertex0};
  const dvec3 bp = p - b;
  const double d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {b, TriangleFeature::Vertex1};
  const dvec3 cp = p - c;
  const double d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {c, TriangleFeature::Vertex2};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return {a + ab * (d1 / (d1 - d3)), TriangleFeature::Edge0};
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return {b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), TriangleFeature::Edge1};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return {a + ac * (d2 / (d2 - d6)), TriangleFeature::Edge2};
  const double inverse = 1 / (va + vb + vc);
  return {a + ab * (vb * inverse) + ac * (vc * inverse), TriangleFeature::Face};
}

}  // namespace scree

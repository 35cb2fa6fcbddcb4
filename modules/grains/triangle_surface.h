// A surface of triangles: what is nearest to a point, on which side it is, and where a sphere touches.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "modules/grains/grains.h"
#include "engine/assets/nearest_on_triangle.h"
#include "modules/grains/triangle_tree.h"

namespace scree::grains {

// The most triangles of a collider; more are refused.
inline constexpr size_t kMostTriangles = size_t{1} << 20;

// The most triangles of a mesh whose boxes hold one point: a search there looks at each, some 60 ns. More are refused.
inline constexpr uint32_t kMostInOnePlace = 1024;

class TriangleSurface {
 public:
  // Corners, three a triangle, counter-clockwise seen from outside. Corners at the same place are
  // one vertex. Triangles less than a millionth as high as long are skipped (but count for what is
  // closed, as fillings of cracks). Of triangles with the same corners and the same side outside, the first
  // stands for all. Empty, or what is wrong: nothing is left over, too many triangles, a number that is not
  // finite or is beyond 1e6 m.
  std::string build(std::span<const vec3> corners);

  // What is wrong if more than kMostInOnePlace are in one; else empty.
  std::string crowded() const;

  size_t triangles() const { return triangles_; }
  size_t skipped() const { return skipped_; }
  // Every edge has two triangles, which run along it in opposite directions.
  bool closed() const { return closed_; }
  vec3 low() const { return tree_.low(); }
  vec3 high() const { return tree_.high(); }
  std::span<const vec3> vertices() const { return vertex_; }
  std::span<const vec3> corners() const { return corner_; }  // three a triangle

  // The nearest point within `most` m; `square` is infinite if there is none. `outward` is the sum of
  // the normals around it, weighted by their angles: its side is the side of the surface where p is
  // (Baerentzen and Aanaes, "Signed Distance Computation Using the Angle Weighted Pseudonormal",
  // 2005). Not normalised.
  struct Nearest {
    dvec3 point{0};
    double square;  // of the distance, m^2
    dvec3 outward{0};
    float flat = 0;  // SurfacePoint::flat, without regard to p's own distance
  };
  Nearest nearest(vec3 p, double most) const;

  // Every point at which the distance to p, as a function on the surface, is the least of those
  // around it, and at most `reach`: where spheres that grow around p come to touch. Left out are those
  // that lie behind the plane through a nearer one (a sphere before that plane does not get there), in
  // nearly the same direction as a nearer one, and, with `front`, those that show p their back. So a
  // flat floor of many triangles has one, whatever edges and cracks lie in it; a groove has one on
  // each side. The `out.size()` nearest, nearest first; returns how many.
  uint32_t touches(vec3 p, double reach, bool front, std::span<Nearest> out) const;

  size_t memoryBytes() const;

 private:
  void weld();
  void connect();
  void normals();
  bool leastAround(uint32_t triangle, TriangleFeature feature, dvec3 d) const;
  dvec3 outwardAt(uint32_t triangle, TriangleFeature feature) const;
  float flatAt(uint32_t triangle, const OnTriangle& on) const;

  TriangleTree tree_;
  std::vector<vec3> corner_;      // three a triangle, in the tree's order; then needles
  std::vector<vec3> vertex_;
  std::vector<uint32_t> vertex_of_, edge_of_;  // three a triangle
  // By edge and by vertex: the corners opposite to the edge; the vertices at the other ends.
  std::vector<uint32_t> opposite_begin_, opposite_, other_begin_, other_;
  std::vector<vec3> face_normal_, edge_normal_, vertex_normal_;
  size_t triangles_ = 0, skipped_ = 0;
  bool closed_ = false;
};

}  // namespace scree::grains

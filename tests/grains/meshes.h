// Meshes for the tests of colliders, and the distance to them by brute force, in double.
#pragma once

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "tests/grains/field.h"

namespace scree::grains::test {

// Corners, three a triangle.
using Soup = std::vector<vec3>;

inline void addTriangle(Soup& soup, vec3 a, vec3 b, vec3 c) { soup.insert(soup.end(), {a, b, c}); }
inline void addQuad(Soup& soup, vec3 a, vec3 b, vec3 c, vec3 d) {
  addTriangle(soup, a, b, c);
  addTriangle(soup, a, c, d);
}

// A closed box of 12 triangles.
inline Soup boxSoup(vec3 low, vec3 high) {
  const auto at = [&](int k) {
    return vec3(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
  };
  Soup soup;
  for (const auto& q : {std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}, std::array{0, 1, 5, 4},
                        std::array{2, 6, 7, 3}, std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}})
    addQuad(soup, at(q[0]), at(q[1]), at(q[2]), at(q[3]));
  return soup;
}

// A floor of n x n squares of two triangles each, facing up, with y(x, z).
template <class Height>
Soup floorSoup(float half, int n, const Height& height) {
  Soup soup;
  const auto at = [&](int i, int k) {
    const float x = half * (2 * static_cast<float>(i) / static_cast<float>(n) - 1),
                z = half * (2 * static_cast<float>(k) / static_cast<float>(n) - 1);
    return vec3(x, height(x, z), z);
  };
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) {
      // Diagonals in both directions.
      if ((i + k) % 2 == 0) {
        addTriangle(soup, at(i, k), at(i, k + 1), at(i + 1, k + 1));
        addTriangle(soup, at(i, k), at(i + 1, k + 1), at(i + 1, k));
      } else {
        addTriangle(soup, at(i, k), at(i, k + 1), at(i + 1, k));
        addTriangle(soup, at(i + 1, k), at(i, k + 1), at(i + 1, k + 1));
      }
    }
  return soup;
}

// A closed surface r(direction) around the centre: a subdivided octahedron, 8 * 4^level triangles.
template <class Radius>
Soup starSoup(int level, const Radius& radius) {
  Soup soup;
  const vec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  for (const vec3 a : {x, -x})
    for (const vec3 b : {y, -y})
      for (const vec3 c : {z, -z})
        if (a.x * b.y * c.z > 0) {
          addTriangle(soup, a, b, c);
        } else {
          addTriangle(soup, a, c, b);
        }
  for (int k = 0; k < level; ++k) {
    Soup finer;
    for (size_t t = 0; t < soup.size(); t += 3) {
      const vec3 a = soup[t], b = soup[t + 1], c = soup[t + 2];
      const vec3 ab = glm::normalize(a + b), bc = glm::normalize(b + c), ca = glm::normalize(c + a);
      addTriangle(finer, a, ab, ca);
      addTriangle(finer, ab, b, bc);
      addTriangle(finer, ca, bc, c);
      addTriangle(finer, ab, bc, ca);
    }
    soup.swap(finer);
  }
  for (vec3& corner : soup) corner *= radius(corner);
  return soup;
}

// Bumps whose size only directions decide: corners at one place stay at one place.
inline Soup bumpySoup(int level, uint64_t seed, float size = 1) {
  const vec3 k1 = 6.0f * unitCube(seed, 1), k2 = 6.0f * unitCube(seed, 2);
  return starSoup(level, [=](vec3 d) {
    return size * (1 + 0.25f * std::sin(glm::dot(k1, d) * 1.7f) * std::cos(glm::dot(k2, d)));
  });
}

// Of a point to a segment, and to a triangle by its plane or its sides: no Voronoi regions.
inline double segmentDistance(dvec3 p, dvec3 a, dvec3 b) {
  const double t = std::clamp(glm::dot(p - a, b - a) / glm::dot(b - a, b - a), 0.0, 1.0);
  return glm::length(p - (a + (b - a) * t));
}
inline double triangleDistance(dvec3 p, dvec3 a, dvec3 b, dvec3 c) {
  const dvec3 n = glm::normalize(glm::cross(b - a, c - a));
  const dvec3 q = p - n * glm::dot(n, p - a);
  const bool inside = glm::dot(glm::cross(b - a, q - a), n) >= 0 &&
                      glm::dot(glm::cross(c - b, q - b), n) >= 0 &&
                      glm::dot(glm::cross(a - c, q - c), n) >= 0;
  return inside ? std::abs(glm::dot(n, p - a))
                : std::min({segmentDistance(p, a, b), segmentDistance(p, b, c), segmentDistance(p, c, a)});
}
inline double bruteDistance(const Soup& soup, dvec3 p) {
  double best = 1e300;
  for (size_t k = 0; k < soup.size(); k += 3) {
    const dvec3 a(soup[k]), b(soup[k + 1]), c(soup[k + 2]);
    if (glm::length(glm::cross(b - a, c - a)) == 0) continue;
    best = std::min(best, triangleDistance(p, a, b, c));
  }
  return best;
}

// Turns of the surface around p: 1 inside a closed one, 0 outside (Van Oosterom and Strackee, "The
// Solid Angle of a Plane Triangle", 1983).
inline double windingNumber(const Soup& soup, dvec3 p) {
  double sum = 0;
  for (size_t k = 0; k < soup.size(); k += 3) {
    const dvec3 a = dvec3(soup[k]) - p, b = dvec3(soup[k + 1]) - p, c = dvec3(soup[k + 2]) - p;
    const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
    const double volume = glm::dot(a, glm::cross(b, c));
    sum += 2 * std::atan2(volume, la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la +
                                      glm::dot(c, a) * lb);
  }
  return sum / (4 * kPi);
}

inline quat turnOf(uint64_t seed, uint64_t k) {
  const vec3 v = unitCube(seed, k) * 2.0f - 1.0f;
  return glm::normalize(quat(unit(seed, k, 3) + 0.1f, v.x, v.y, v.z));
}

inline Collider& addField(Field& field, std::shared_ptr<const DistanceField> shape, float friction) {
  Collider& c = field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), friction);
  c.shape = Shape::Field;
  c.field = std::move(shape);
  return c;
}

}  // namespace scree::grains::test

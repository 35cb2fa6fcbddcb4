// Khachiyan's ascent: weights of the points whose second moments span the ellipsoid.
#include "modules/impostors/bounding_ellipsoid.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <vector>

namespace scree::impostors {
namespace {

constexpr int kMostSteps = 2000;
constexpr double kSlack = 0.003;  // how far a point's squared distance may be beyond the ellipsoid's

// Weighted mean, and moments about it.
struct Moments {
  dvec3 mean{0};
  glm::dmat3 spread{0};
};

Moments momentsOf(std::span<const dvec3> points, std::span<const double> weights) {
  Moments m;
  for (size_t k = 0; k < points.size(); ++k) m.mean += weights[k] * points[k];
  for (size_t k = 0; k < points.size(); ++k) {
    const dvec3 off = points[k] - m.mean;
    m.spread += weights[k] * glm::outerProduct(off, off);
  }
  return m;
}

// Columns: perpendicular unit vectors that a symmetric matrix only scales (Jacobi's rotations).
glm::dmat3 principalAxes(glm::dmat3 a) {
  glm::dmat3 axes(1);
  for (int sweep = 0; sweep < 16; ++sweep)
    for (const auto& [p, q] : {std::pair{0, 1}, std::pair{0, 2}, std::pair{1, 2}}) {
      if (std::abs(a[p][q]) <= 1e-18) continue;
      const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
      const double c = 1 / std::sqrt(t * t + 1), s = t * c;
      glm::dmat3 turn(1);
      turn[p][p] = turn[q][q] = c;
      turn[q][p] = s;
      turn[p][q] = -s;
      a = glm::transpose(turn) * a * turn;
      axes = axes * turn;
    }
  return axes;
}

// With an octahedron, so that what is flat has a volume.
std::vector<dvec3> thickened(std::span<const dvec3> points) {
  std::vector<dvec3> all(points.begin(), points.end());
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-kThinnestBound, kThinnestBound}) {
      dvec3 corner(0);
      corner[axis] = side;
      all.push_back(corner);
    }
  return all;
}

}  // namespace

rules::Ellipsoid boundingEllipsoid(std::span<const dvec3> given) {
  const std::vector<dvec3> points = thickened(given);
  std::vector<double> weights(points.size(), 1.0 / static_cast<double>(points.size()));
  Moments m = momentsOf(points, weights);
  for (int step = 0; step < kMostSteps; ++step) {
    const glm::dmat3 inverse = glm::inverse(m.spread);
    size_t farthest = 0;
    double most = 0;
    for (size_t k = 0; k < points.size(); ++k) {
      const dvec3 off = points[k] - m.mean;
      const double distance2 = glm::dot(off, inverse * off);
      if (distance2 > most) most = distance2, farthest = k;
    }
    // All are within sqrt(3), but for the slack.
    if (most <= 3 * (1 + kSlack)) break;
    const double grow = (most - 3) / (4 * most);
    for (double& weight : weights) weight *= 1 - grow;
    weights[farthest] += grow;
    m = momentsOf(points, weights);
  }
  const glm::dmat3 axes = principalAxes(m.spread);
  double length2[3], most = 0;
  for (int k = 0; k < 3; ++k) length2[k] = std::max(glm::dot(axes[k], m.spread * axes[k]), 0.25 * kThinnestBound * kThinnestBound);
  for (const dvec3& p : points) {
    double distance2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double along = glm::dot(axes[k], p - m.mean);
      distance2 += along * along / length2[k];
    }
    most = std::max(most, distance2);
  }
  // What is as round as a ball gains nothing.
  constexpr double kWorthwhile = 0.97;
  if (std::sqrt(length2[0] * length2[1] * length2[2]) * most * std::sqrt(most) > kWorthwhile) return rules::unitBall();
  // Rounding to floats keeps all of them inside.
  const double scale = std::sqrt(most) * (1 + 1e-5);
  vec4 axis[3];
  double longest = 0;
  for (int k = 0; k < 3; ++k) {
    const double length = std::sqrt(length2[k]) * scale;
    axis[k] = vec4(vec3(axes[k] * length), static_cast<float>(1 / (length * length)));
    longest = std::max(longest, length);
  }
  return {vec4(vec3(m.mean), static_cast<float>(glm::length(m.mean) + longest)), axis[0], axis[1], axis[2]};
}

}  // namespace scree::impostors

// Enclosing sphere, inner sphere, and the ellipsoid of equal moments, in double precision.
#include "modules/impostors/spheres.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "engine/core/random.h"

namespace scree::impostors {
namespace {

using glm::cross;
using glm::dot;

// Spheres through 0 to 4 points, the smallest. Points of no new dimension are left out.
struct Support {
  dvec3 points[4];
  int count = 0;
};

Sphere through(const Support& s) {
  if (s.count == 0) return {dvec3(0), -1};
  const dvec3 o = s.points[0];
  if (s.count == 1) return {o, 0};
  const dvec3 a = s.points[1] - o;
  if (s.count == 2) return {o + a * 0.5, std::sqrt(dot(a, a)) * 0.5};
  const dvec3 b = s.points[2] - o;
  const dvec3 n = cross(a, b);
  dvec3 center(0);
  if (s.count == 3) {
    center = (cross(n, a) * dot(b, b) + cross(b, n) * dot(a, a)) / (2 * dot(n, n));
  } else {
    const dvec3 c = s.points[3] - o;
    center = (n * dot(c, c) + cross(c, a) * dot(b, b) + cross(b, c) * dot(a, a)) / (2 * dot(n, c));
  }
  return {o + center, std::sqrt(dot(center, center))};
}

bool holds(const Sphere& sphere, const dvec3& p) {
  if (sphere.radius < 0) return false;
  const dvec3 off = p - sphere.center;
  return dot(off, off) <= sphere.radius * sphere.radius * (1 + 1e-12);
}

// Smallest sphere of the first `count` points with the support on its surface.
Sphere smallest(std::span<const dvec3> points, size_t count, const Support& support) {
  Sphere sphere = through(support);
  if (support.count == 4) return sphere;
  for (size_t i = 0; i < count; ++i) {
    if (holds(sphere, points[i])) continue;
    Support more = support;
    more.points[more.count++] = points[i];
    const Sphere next = smallest(points, i, more);
    // Not finite: the point is of no new dimension (rounding), and all but on the sphere already.
    if (std::isfinite(next.radius) && finite(vec3(next.center))) sphere = next;
  }
  return sphere;
}

// Half the solid angle's tangent formula (Van Oosterom and Strackee 1983).
double solidAngle(const dvec3& a, const dvec3& b, const dvec3& c) {
  const double la = std::sqrt(dot(a, a)), lb = std::sqrt(dot(b, b)), lc = std::sqrt(dot(c, c));
  const double volume = dot(a, cross(b, c));
  const double rest = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  return 2 * std::atan2(volume, rest);
}

double distanceToSegment(const dvec3& p, const dvec3& a, const dvec3& b) {
  const dvec3 along = b - a, off = p - a;
  const double length2 = dot(along, along);
  const double t = length2 > 0 ? std::clamp(dot(off, along) / length2, 0.0, 1.0) : 0;
  const dvec3 rest = off - along * t;
  return std::sqrt(dot(rest, rest));
}

}  // namespace

Sphere enclosingSphere(std::span<const dvec3> points) {
  std::vector<dvec3> shuffled(points.begin(), points.end());
  for (size_t i = shuffled.size(); i > 1; --i)
    std::swap(shuffled[i - 1], shuffled[randomBits(1, i, 0, 0) % i]);
  Sphere sphere = smallest(shuffled, shuffled.size(), {});
  sphere.radius = std::max(sphere.radius, 0.0);
  for (const dvec3& p : points) {
    const dvec3 off = p - sphere.center;
    sphere.radius = std::max(sphere.radius, std::sqrt(dot(off, off)));
  }
  return sphere;
}

double distanceToTriangle(const dvec3& p, const dvec3& a, const dvec3& b, const dvec3& c) {
  const dvec3 n = cross(b - a, c - a);
  const double n2 = dot(n, n);
  if (n2 > 0 && dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 &&
      dot(cross(a - c, p - c), n) >= 0)
    return std::abs(dot(p - a, n)) / std::sqrt(n2);
  return std::min(
      {distanceToSegment(p, a, b), distanceToSegment(p, b, c), distanceToSegment(p, c, a)});
}

double innerRadius(const Corners& corners, const dvec3& center) {
  double angle = 0, nearest = std::numeric_limits<double>::infinity();
  for (size_t t = 0; t + 2 < corners.size(); t += 3) {
    nearest =
        std::min(nearest, distanceToTriangle(center, corners[t], corners[t + 1], corners[t + 2]));
    angle += solidAngle(corners[t] - center, corners[t + 1] - center, corners[t + 2] - center);
  }
  const bool inside = angle > 2 * std::numbers::pi;
  return inside && std::isfinite(nearest) ? nearest : 0;
}

Sphere roomySphere(std::span<const dvec3> points, const Corners& corners) {
  const Sphere least = enclosingSphere(points);
  const auto outerAt = [&](const dvec3& center) {
    double far2 = 0;
    for (const dvec3& p : points) far2 = std::max(far2, dot(p - center, p - center));
    return std::sqrt(far2);
  };
  Sphere best = least;
  double share = innerRadius(corners, best.center) / least.radius;
  for (double step = 0.25 * least.radius; step > 1e-3 * least.radius;) {
    bool better = false;
    for (int k = 0; k < 6; ++k) {
      Sphere next = best;
      next.center[k / 2] += k % 2 == 0 ? step : -step;
      next.radius = outerAt(next.center);
      if (!(next.radius <= kMostGrowth * least.radius)) continue;
      const double next_share = innerRadius(corners, next.center) / next.radius;
      if (!(next_share > share + 1e-6)) continue;
      best = next;
      share = next_share;
      better = true;
    }
    if (!better) step *= 0.5;
  }
  return best;
}

rules::ImpostorProxy proxyOf(const Corners& corners, double fallback_radius) {
  const auto sphere = [&] {
    const auto scale = static_cast<float>(1 / fallback_radius);
    return rules::ImpostorProxy{vec4(0), vec4(scale, scale, scale, 0), vec4(0)};
  };
  // Sums over signed tetrahedra with the origin: volume, first and second moments.
  double volume = 0, gross = 0;
  dvec3 first(0);
  double second[3][3] = {};
  for (size_t t = 0; t + 2 < corners.size(); t += 3) {
    const dvec3 &a = corners[t], &b = corners[t + 1], &c = corners[t + 2];
    const double v = dot(a, cross(b, c)) / 6;
    volume += v;
    gross += std::abs(v);
    const dvec3 sum = a + b + c;
    first += sum * (v / 4);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        second[i][j] += v / 20 * (sum[i] * sum[j] + a[i] * a[j] + b[i] * b[j] + c[i] * c[j]);
  }
  if (!(volume > 0.01 * gross) || !(volume > 1e-6)) return sphere();
  const dvec3 center = first / volume;
  // A = 5 x covariance has the squared semi-axes as eigenvalues; |T x| = 1 with T^T T = A^-1, that
  // is A = U U^T with U = T^-1 upper triangular.
  double a[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[i][j] = 5 * (second[i][j] / volume - center[i] * center[j]);
  constexpr double kThinnest = 1e-4;  // square of the least semi-axis
  for (int i = 0; i < 3; ++i) a[i][i] = std::max(a[i][i], kThinnest);
  const double zz = std::sqrt(a[2][2]);
  const double yz = a[1][2] / zz, xz = a[0][2] / zz;
  const double yy = std::sqrt(std::max(a[1][1] - yz * yz, kThinnest));
  const double xy = (a[0][1] - xz * yz) / yy;
  const double xx = std::sqrt(std::max(a[0][0] - xy * xy - xz * xz, kThinnest));
  // Of a surface that is turned inside out in parts the moments are those of nothing.
  constexpr double kLongest = 4;
  if (!(glm::length(center) <= 1) || !(std::max({xx, yy, zz}) <= kLongest)) return sphere();
  const double tx = 1 / xx, ty = 1 / yy, tz = 1 / zz;
  return {vec4(vec3(center), 0),
          vec4(static_cast<float>(tx), static_cast<float>(ty), static_cast<float>(tz), 0),
          vec4(static_cast<float>(-xy * tx * ty), static_cast<float>((xy * yz * ty - xz) * tx * tz),
               static_cast<float>(-yz * ty * tz), 0)};
}

}  // namespace scree::impostors

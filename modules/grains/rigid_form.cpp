// Mass and outline of the shapes of bodies: closed forms, sums over tetrahedra, quadrature of fields.
#include "modules/grains/rigid_form.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "modules/grains/saved.h"

namespace scree::grains {
namespace {

using glm::dmat3;

constexpr double kPi = 3.14159265358979323846;

dmat3 diagonal(double x, double y, double z) {
  dmat3 m(0.0);
  m[0][0] = x;
  m[1][1] = y;
  m[2][2] = z;
  return m;
}

// Second moments, integral of x x^T, to moments of inertia, and the shift of an axis.
dmat3 inertiaOf(const dmat3& second) {
  const double trace = second[0][0] + second[1][1] + second[2][2];
  return diagonal(trace, trace, trace) - second;
}

void boxOutline(const Collider& box, RigidForm& form) {
  for (uint32_t k = 0; k < 8; ++k)
    form.point.push_back(box.half_extent * vec3((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1));
  for (uint32_t k = 0; k < 8; ++k)
    for (const uint32_t bit : {1u, 2u, 4u})
      if ((k & bit) == 0) form.edge.push_back({k, k | bit});
}

void capsuleOutline(const Collider& capsule, RigidForm& form) {
  form.radius = capsule.radius;
  form.point.push_back(capsule.a);
  if (capsule.a == capsule.b) return;
  form.point.push_back(capsule.b);
  form.edge.push_back({0, 1});
}

void fillBox(const Collider& box, RigidForm& form) {
  const dvec3 h(box.half_extent), square = h * h;
  form.volume = 8 * h.x * h.y * h.z;
  form.inertia = inertiaOf(diagonal(square.x, square.y, square.z) * (form.volume / 3));
}

// A cylinder and two halves of a ball.
void fillCapsule(const Collider& capsule, RigidForm& form) {
  const dvec3 axis = dvec3(capsule.b) - dvec3(capsule.a);
  const double r = capsule.radius, length = glm::length(axis);
  const double tube = kPi * r * r * length, ball = 4.0 / 3 * kPi * r * r * r;
  form.volume = tube + ball;
  form.centre = 0.5 * (dvec3(capsule.a) + dvec3(capsule.b));
  const double across = tube * (r * r / 4) + ball * (r * r / 5);
  // Each half ball's centre of mass is 3/8 r beyond the cylinder's end.
  const double along = tube * length * length / 12 +
                       ball * (r * r / 5 + length * length / 4 + 3.0 / 8 * length * r);
  dmat3 second = diagonal(across, across, across);
  if (length > 0) second += glm::outerProduct(axis, axis) * ((along - across) / (length * length));
  form.inertia = inertiaOf(second);
}

// Signed tetrahedra between each triangle and the first corner (so that no digits are lost far out).
void fillTriangles(std::span<const vec3> corners, RigidForm& form) {
  const dvec3 from(corners[0]);
  double volume = 0;
  dvec3 first(0);
  dmat3 second(0.0);
  for (size_t k = 0; k + 3 <= corners.size(); k += 3) {
    const dvec3 a = dvec3(corners[k]) - from, b = dvec3(corners[k + 1]) - from, c = dvec3(corners[k + 2]) - from;
    const double v = glm::dot(a, glm::cross(b, c)) / 6;
    const dvec3 sum = a + b + c;
    volume += v;
    first += sum * (v / 4);
    second += (glm::outerProduct(a, a) + glm::outerProduct(b, b) + glm::outerProduct(c, c) + glm::outerProduct(sum, sum)) * (v / 20);
  }
  if (!(volume > 0)) return;
  const dvec3 centre = first / volume;
  form.volume = volume;
  form.centre = from + centre;
  form.inertia = inertiaOf(second - glm::outerProduct(centre, centre) * volume);
}

// Cells of a lattice count by how much of them is inside.
void fillField(const DistanceField& field, RigidForm& form) {
  constexpr int kCells = 48;
  const auto [low, high] = field.bounds();
  const dvec3 size = dvec3(high) - dvec3(low);
  const double cell = std::max({size.x, size.y, size.z}) / kCells;
  if (!(cell > 0) || !(cell < 1e9)) return;
  const glm::ivec3 count = glm::ivec3(glm::ceil(size / cell));
  const dvec3 middle = 0.5 * (dvec3(low) + dvec3(high));
  double volume = 0;
  dvec3 first(0);
  dmat3 second(0.0);
  for (int z = 0; z < count.z; ++z)
    for (int y = 0; y < count.y; ++y)
      for (int x = 0; x < count.x; ++x) {
        const dvec3 p = cell * (dvec3(x, y, z) + 0.5 - 0.5 * dvec3(count));
        const double distance = field.nearest(vec3(middle + p)).distance;
        const double v = std::clamp(0.5 - distance / cell, 0.0, 1.0);
        volume += v;
        first += v * p;
        second += glm::outerProduct(p, p) * v;
      }
  if (!(volume > 0)) return;
  const double whole = cell * cell * cell;
  const dvec3 centre = first / volume;
  form.volume = volume * whole;
  form.centre = middle + centre;
  // A cell's own second moment is that of a cube.
  const double own = cell * cell / 12 * volume;
  form.inertia = inertiaOf((second - glm::outerProduct(centre, centre) * volume + diagonal(own, own, own)) * whole);
}

// Takes the points that are farthest from those taken so far, from the farthest out on.
std::vector<vec3> spread(std::vector<vec3> points) {
  if (points.size() <= kMostPoints) return points;
  std::vector<double> apart(points.size());
  vec3 middle(0);
  for (const vec3 p : points) middle += p / static_cast<float>(points.size());
  for (size_t k = 0; k < points.size(); ++k) apart[k] = glm::dot(points[k] - middle, points[k] - middle);
  std::vector<vec3> taken;
  while (taken.size() < kMostPoints) {
    const size_t next = static_cast<size_t>(std::max_element(apart.begin(), apart.end()) - apart.begin());
    taken.push_back(points[next]);
    for (size_t k = 0; k < points.size(); ++k) {
      const vec3 d = points[k] - points[next];
      apart[k] = taken.size() == 1 ? glm::dot(d, d) : std::min(apart[k], double(glm::dot(d, d)));
    }
  }
  return taken;
}

// Welded corners, and the edges between faces that are not in one plane.
void triangleOutline(std::span<const vec3> corners, RigidForm& form) {
  const auto before = [](vec3 a, vec3 b) {
    return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z;
  };
  std::vector<vec3> all(corners.begin(), corners.end());
  std::sort(all.begin(), all.end(), before);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  if (all.size() > kMostPoints) {
    form.point = spread(std::move(all));
    return;
  }
  form.point = all;
  const auto number = [&](vec3 p) {
    return static_cast<uint32_t>(std::lower_bound(all.begin(), all.end(), p, before) - all.begin());
  };
  std::map<std::pair<uint32_t, uint32_t>, dvec3> normal;
  for (size_t k = 0; k + 3 <= corners.size(); k += 3) {
    const dvec3 n = glm::cross(dvec3(corners[k + 1]) - dvec3(corners[k]), dvec3(corners[k + 2]) - dvec3(corners[k]));
    const double size = glm::length(n);
    if (!(size > 0)) continue;
    for (size_t side = 0; side < 3; ++side) {
      const uint32_t a = number(corners[k + side]), b = number(corners[k + (side + 1) % 3]);
      const auto [at, fresh] = normal.try_emplace({std::min(a, b), std::max(a, b)}, n / size);
      constexpr double kFlat = 0.9998;  // one degree
      if (!fresh && glm::dot(at->second, n / size) < kFlat) form.edge.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

// Hulls touch a sphere at one point; what has too many points has not all of them in its form.
bool isConvex(const Collider& collider) {
  if (collider.shape != Shape::Field) return collider.shape != Shape::Plane;
  return collider.field != nullptr && collider.field->mostTouches() == 1 && !collider.field->corners().empty() &&
         collider.field->corners().size() <= 6 * kMostPoints;
}

// A field that has no triangles: where walks from a ball around it end on its surface.
void fieldOutline(const DistanceField& field, RigidForm& form) {
  const auto [low, high] = field.bounds();
  const vec3 middle = 0.5f * (low + high);
  const float around = glm::length(high - middle);
  if (!(around < 1e9f)) return;
  constexpr int kTurns = 96;
  double x = 1, y = 0;
  const double cosine = -0.73736887807831974, sine = 0.67549029426152385;  // of the golden angle
  for (int k = 0; k < kTurns; ++k) {
    const double z = 1 - (2.0 * k + 1) / kTurns, ring = std::sqrt(1 - z * z);
    vec3 p = middle + around * vec3(dvec3(ring * x, z, ring * y));
    for (int step = 0; step < 8; ++step) {
      const SurfacePoint near = field.nearest(p);
      p -= near.normal * near.distance;
    }
    if (std::abs(field.nearest(p).distance) < 0.01f * around) form.point.push_back(p);
    const double turned = x * cosine - y * sine;
    y = x * sine + y * cosine;
    x = turned;
  }
}

}  // namespace

double thicknessOf(std::span<const vec3> corners) {
  double volume = 0, area = 0;
  for (size_t k = 0; k + 3 <= corners.size(); k += 3) {
    const dvec3 from(corners[0]), a = dvec3(corners[k]) - from, b = dvec3(corners[k + 1]) - from,
                c = dvec3(corners[k + 2]) - from;
    volume += glm::dot(a, glm::cross(b, c)) / 6;
    area += glm::length(glm::cross(b - a, c - a)) / 2;
  }
  return area > 0 ? 2 * volume / area : 0;
}

RigidForm outlineOf(const Collider& collider) {
  RigidForm form;
  form.convex = isConvex(collider);
  if (collider.shape == Shape::Box) boxOutline(collider, form);
  if (collider.shape == Shape::Capsule) capsuleOutline(collider, form);
  if (collider.shape == Shape::Field && collider.field != nullptr) {
    // Three corners a triangle, each point in about six.
    const std::span<const vec3> corners = collider.field->corners();
    if (!corners.empty() && corners.size() <= 6 * kMostPoints) triangleOutline(corners, form);
  }
  return form;
}

RigidForm formOf(const Collider& collider) {
  RigidForm form;
  form.convex = isConvex(collider);
  switch (collider.shape) {
    case Shape::Box:
      boxOutline(collider, form);
      fillBox(collider, form);
      break;
    case Shape::Capsule:
      capsuleOutline(collider, form);
      fillCapsule(collider, form);
      break;
    case Shape::Field: {
      if (collider.field == nullptr) break;
      const std::span<const vec3> corners = collider.field->corners();
      if (corners.empty()) {
        fieldOutline(*collider.field, form);
        fillField(*collider.field, form);
      } else {
        triangleOutline(corners, form);
        fillTriangles(corners, form);
      }
      break;
    }
    case Shape::Plane:
      break;
  }
  for (const vec3 p : form.point) form.reach = std::max(form.reach, glm::length(p) + form.radius);
  if (collider.shape == Shape::Field && collider.field != nullptr) {
    const auto [low, high] = collider.field->bounds();
    form.reach = glm::length(glm::max(glm::abs(low), glm::abs(high)));
  }
  if (!(form.volume > 0)) {  // what has no inside moves like a ball
    Collider ball;
    ball.radius = form.reach;
    fillCapsule(ball, form);
  }
  return form;
}

}  // namespace scree::grains

// A handful of grains and colliders in plain arrays, for tests of the solver without the ECS.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/random.h"
#include "modules/grains/solver.h"

namespace scree::grains::test {

inline constexpr double kPi = 3.14159265358979323846;

struct Field {
  std::vector<Entity> entity;
  std::vector<Grain> grain;
  std::vector<GrainVelocity> velocity;
  std::vector<GrainSpin> spin;
  std::vector<GrainOrientation> orientation;
  std::vector<GrainPrevious> previous;
  std::vector<GrainMaterial> material;
  std::vector<Collider> colliders;
  GrainSolver solver;
  StepParameters parameters;
  uint32_t next = 0;

  // Returns the row.
  size_t add(vec3 position, float radius, GrainMaterial m = {}, vec3 v = vec3(0)) {
    entity.push_back({next++, 1});
    grain.push_back({position, radius});
    velocity.push_back({v});
    spin.push_back({});
    orientation.push_back({});
    previous.push_back({position});
    material.push_back(m);
    return grain.size() - 1;
  }
  Collider& addPlane(vec3 position, quat rotation, float friction, float restitution = 0) {
    Collider c;
    c.key = static_cast<uint32_t>(colliders.size());
    c.shape = Shape::Plane;
    c.position0 = c.position1 = position;
    c.rotation0 = c.rotation1 = rotation;
    c.friction = friction;
    c.restitution = restitution;
    colliders.push_back(c);
    return colliders.back();
  }
  Collider& addBox(vec3 position, vec3 half_extent, float friction) {
    Collider& c = addPlane(position, quat(1, 0, 0, 0), friction);
    c.shape = Shape::Box;
    c.half_extent = half_extent;
    return c;
  }
  // A box without a lid: five planes, inside [-w, w] x [0, oo) x [-w, w].
  void addBin(float w, float friction) {
    const float s = std::sqrt(0.5f);
    addPlane({0, 0, 0}, quat(1, 0, 0, 0), friction);
    addPlane({-w, 0, 0}, quat(s, 0, 0, -s), friction);
    addPlane({w, 0, 0}, quat(s, 0, 0, s), friction);
    addPlane({0, 0, -w}, quat(s, s, 0, 0), friction);
    addPlane({0, 0, w}, quat(s, -s, 0, 0), friction);
  }
  GrainRows rows() {
    return {entity, grain, velocity, spin, orientation, previous, material};
  }
  void step(int ticks = 1) {
    for (int k = 0; k < ticks; ++k) {
      const GrainRows all = rows();
      solver.step(std::span(&all, 1), colliders, parameters);
    }
  }

  double mass(size_t k) const {
    const double r = grain[k].radius;
    return 4.0 / 3 * kPi * r * r * r * static_cast<double>(material[k].density);
  }
  glm::dvec3 momentum() const {
    glm::dvec3 sum(0);
    for (size_t k = 0; k < grain.size(); ++k) sum += mass(k) * glm::dvec3(velocity[k].linear);
    return sum;
  }
  glm::dvec3 angularMomentum() const {
    glm::dvec3 sum(0);
    for (size_t k = 0; k < grain.size(); ++k) {
      const double r = grain[k].radius, m = mass(k);
      const glm::dvec3 x(grain[k].position), v(velocity[k].linear), w(spin[k].angular);
      sum += m * glm::dvec3(x.y * v.z - x.z * v.y, x.z * v.x - x.x * v.z, x.x * v.y - x.y * v.x) +
             0.4 * m * r * r * w;
    }
    return sum;
  }
  double kineticEnergy() const {
    double sum = 0;
    for (size_t k = 0; k < grain.size(); ++k) {
      const double r = grain[k].radius;
      const glm::dvec3 v(velocity[k].linear), w(spin[k].angular);
      sum += 0.5 * mass(k) * (v.x * v.x + v.y * v.y + v.z * v.z) +
             0.2 * mass(k) * r * r * (w.x * w.x + w.y * w.y + w.z * w.z);
    }
    return sum;
  }
  // Kinetic and potential, J.
  double energy() const {
    double sum = kineticEnergy();
    for (size_t k = 0; k < grain.size(); ++k) {
      const glm::dvec3 g(parameters.gravity), x(grain[k].position);
      sum -= mass(k) * (g.x * x.x + g.y * x.y + g.z * x.z);
    }
    return sum;
  }
  bool finite() const {
    for (size_t k = 0; k < grain.size(); ++k) {
      const vec3 x = grain[k].position, v = velocity[k].linear, w = spin[k].angular;
      if (!std::isfinite(x.x + x.y + x.z + v.x + v.y + v.z + w.x + w.y + w.z)) return false;
    }
    return true;
  }
  // The deepest overlap of two grains as a share of the smaller radius, by brute force, in double.
  double deepestOverlap() const {
    double worst = 0;
    for (size_t i = 0; i < grain.size(); ++i)
      for (size_t j = i + 1; j < grain.size(); ++j) {
        const glm::dvec3 d = glm::dvec3(grain[i].position) - glm::dvec3(grain[j].position);
        const double a = grain[i].radius, b = grain[j].radius;
        const double overlap = a + b - std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z);
        worst = std::max(worst, overlap / std::min(a, b));
      }
    return worst;
  }
  // Of everything that the solver moves, by entity: independent of the order of the rows.
  uint64_t hash() const {
    uint64_t sum = 0;
    for (size_t k = 0; k < grain.size(); ++k) {
      uint64_t h = entity[k].index;
      h = hashBytes(&grain[k], sizeof(Grain), h);
      h = hashBytes(&velocity[k], sizeof(GrainVelocity), h);
      h = hashBytes(&spin[k], sizeof(GrainSpin), h);
      h = hashBytes(&orientation[k], sizeof(GrainOrientation), h);
      sum += h;
    }
    return sum;
  }
};

inline float unit(uint64_t seed, uint64_t k, uint64_t which) { return randomUnit(seed, k, 0, which); }
inline vec3 unitCube(uint64_t seed, uint64_t k, uint64_t which = 0) {
  return {unit(seed, k, which), unit(seed, k, which + 1), unit(seed, k, which + 2)};
}

// A loose lattice of n^2 x height grains of radius r with jittered places, in a bin.
inline void pour(Field& field, int n, int height, float r, uint64_t seed, float radius_jitter = 0.2f,
                 GrainMaterial material = {}) {
  const float spacing = 2 * r * (1 + radius_jitter) * 1.1f;
  uint64_t k = 0;
  for (int y = 0; y < height; ++y)
    for (int z = 0; z < n; ++z)
      for (int x = 0; x < n; ++x, ++k) {
        const float radius = r * (1 + radius_jitter * (2 * unit(seed, k, 3) - 1));
        const vec3 cell(static_cast<float>(x) - 0.5f * static_cast<float>(n - 1),
                        static_cast<float>(y) + 0.6f,
                        static_cast<float>(z) - 0.5f * static_cast<float>(n - 1));
        const vec3 shake = (unitCube(seed, k) - 0.5f) * (0.1f * r);
        field.add(cell * spacing + shake, radius, material);
      }
  field.addBin(0.5f * spacing * static_cast<float>(n) + r * 0.1f, material.friction);
}

}  // namespace scree::grains::test

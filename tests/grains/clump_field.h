// Clumps in plain arrays, for tests of the solver without the ECS, and what they should do, in double.
#pragma once

#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <span>

#include "modules/grains/clump_shape.h"
#include "tests/grains/resting.h"

namespace scree::grains::test {

using glm::dmat3;
using glm::dquat;

inline std::vector<Sphere> rod(float length, float r) { return {{vec3(0), r}, {vec3(length, 0, 0), r}}; }
// Nothing is symmetric about it.
inline std::vector<Sphere> crooked(float r) {
  return {{vec3(0), r}, {vec3(1.6f * r, 0, 0), 0.8f * r}, {vec3(0.3f * r, 1.1f * r, 0), 0.6f * r},
          {vec3(0, 0.2f * r, 0.9f * r), 0.5f * r}};
}

struct ClumpField : RestingField {
  std::vector<GrainClump> clump;
  bool sleeps = false;
  std::vector<size_t> first;  // row of each clump's first member

  // Returns the row of its first member; `at`: of its centre of mass.
  size_t addClump(std::span<const Sphere> spheres, vec3 at, quat q = quat(1, 0, 0, 0), GrainMaterial m = {},
                  vec3 v = vec3(0), vec3 w = vec3(0)) {
    const ClumpForm form = formOf(spheres);
    const size_t row = grain.size();
    const Entity name{next, 1};
    m.density = std::max(kLeastDensity, m.density * form.density_share);
    clump.resize(row);
    for (uint32_t k = 0; k < form.count; ++k) {
      const vec3 reach = q * form.arm[k];
      add(at + reach, form.radius[k], m, v + glm::cross(w, reach));
      spin.back().angular = w;
      orientation.back().rotation = q;
      clump.push_back({name, k, form.count, form.arm[k]});
    }
    first.push_back(row);
    return row;
  }
  GrainRows rows() {
    clump.resize(grain.size());
    GrainRows all = RestingField::rows();
    all.clump = clump;
    if (!sleeps) all.rest = {};
    return all;
  }
  void step(int ticks = 1, RowsAre known = RowsAre::Unknown) {
    for (int k = 0; k < ticks; ++k) {
      const GrainRows all = rows();
      solver.step(std::span(&all, 1), colliders, parameters, known);
    }
  }
  void remove(size_t k) {
    RestingField::remove(k);
    clump.erase(clump.begin() + static_cast<long>(k));
  }
  uint32_t members(size_t row) const { return clump[row].count; }
  double massOf(size_t row) const {
    double sum = 0;
    for (size_t k = row; k < row + members(row); ++k) sum += mass(k);
    return sum;
  }
  dvec3 centreOf(size_t row) const {
    dvec3 sum(0);
    for (size_t k = row; k < row + members(row); ++k) sum += mass(k) * dvec3(grain[k].position);
    return sum / massOf(row);
  }
  dvec3 velocityOf(size_t row) const {
    dvec3 sum(0);
    for (size_t k = row; k < row + members(row); ++k) sum += mass(k) * dvec3(velocity[k].linear);
    return sum / massOf(row);
  }
  // About the centre of mass, in the world's axes.
  dmat3 inertiaOf(size_t row) const {
    dmat3 sum(0);
    for (size_t k = row; k < row + members(row); ++k) {
      const dvec3 arm = dvec3(grain[k].position) - centreOf(row);
      const double r = grain[k].radius;
      sum += mass(k) * (dmat3(glm::dot(arm, arm) + 0.4 * r * r) - glm::outerProduct(arm, arm));
    }
    return sum;
  }
  // Worst change of a distance between two members of a clump, and of a member's turn from the clump's,
  // as a share of the smaller radius, beyond what rounding two positions to floats does.
  double bent() const {
    double worst = 0;
    for (const size_t row : first)
      for (size_t i = row; i < row + members(row); ++i)
        for (size_t j = row; j < i; ++j) {
          const double now = glm::length(dvec3(grain[i].position) - dvec3(grain[j].position));
          const double meant = glm::length(dvec3(clump[i].arm) - dvec3(clump[j].arm));
          const double r = std::min(grain[i].radius, grain[j].radius);
          const double rounding = 2e-7 * glm::length(dvec3(grain[i].position));
          worst = std::max({worst, (std::abs(now - meant) - rounding) / r,
                            static_cast<double>(glm::length(spin[i].angular - spin[j].angular)) * 1e-3});
        }
    return worst;
  }
  uint64_t state() const {
    uint64_t sum = hash();
    for (size_t k = 0; k < rest.size(); ++k)
      sum += hashCombine(hashBytes(&rest[k].anchor, sizeof(vec3) + sizeof(float), entity[k].index),
                         rest[k].asleep ? 1 : 0);
    for (const Collider& c : colliders) sum = hashCombine(sum, hashBytes(&c.load, sizeof c.load, c.load_contacts));
    return sum;
  }
  // On all colliders, kg: walls bear some by friction.
  double weightBorne() const {
    double sum = 0;
    for (const Collider& c : colliders) sum += c.load.y;
    return sum / static_cast<double>(parameters.dt) / static_cast<double>(parameters.gravity.y);
  }
  double totalMass() const {
    double sum = 0;
    for (size_t k = 0; k < grain.size(); ++k) sum += mass(k);
    return sum;
  }
  // n^2 x height clumps of several forms, loosely above the floor of a bin.
  void pourClumps(int n, int height, float r, uint64_t seed, GrainMaterial m) {
    const float spacing = 5.2f * r;
    uint64_t k = 0;
    for (int y = 0; y < height; ++y)
      for (int z = 0; z < n; ++z)
        for (int x = 0; x < n; ++x, ++k) {
          const float size = r * (0.8f + 0.2f * unit(seed, k, 5));
          const std::vector<Sphere> form = k % 3 == 0   ? crooked(size)
                                           : k % 3 == 1 ? rod(size, size)
                                                        : rod(2 * size, size);
          const quat q = glm::normalize(quat(unit(seed, k, 1) + 0.01f, 2 * unit(seed, k, 2) - 1,
                                             2 * unit(seed, k, 3) - 1, 2 * unit(seed, k, 4) - 1));
          const float middle = 0.5f * static_cast<float>(n - 1);
          addClump(form, spacing * vec3(static_cast<float>(x) - middle, static_cast<float>(y) + 0.6f,
                                        static_cast<float>(z) - middle) + 0.2f * r * unitCube(seed, k, 7), q, m);
        }
    addBin(0.5f * spacing * static_cast<float>(n), m.friction);
    for (Collider& c : colliders) c.sensed = true;
  }
};

}  // namespace scree::grains::test

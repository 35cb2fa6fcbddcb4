// What the tests of cohesion share: the law's force, and grains that sleep.
#pragma once

#include "modules/grains/cohesion.h"
#include "tests/grains/law.h"

namespace scree::grains::test {

inline constexpr double kG = 9.81;
inline constexpr float kRadius = 0.05f;

// Derjaguin's force of radii a and b, N; of a wall b = 0.
inline double force(double cohesion, double a, double b = 0) {
  return 2 * kPi * cohesion * (b > 0 ? a * b / (a + b) : a);
}
// Cohesion by which a grain bears `weights` of its own on an equal one.
inline float cohesionFor(double weights, double radius = static_cast<double>(kRadius), double density = 1000) {
  const double weight = 4.0 / 3 * kPi * radius * radius * radius * density * kG;
  return static_cast<float>(weights * weight / (kPi * radius));
}

struct Bed : Field {
  std::vector<GrainRest> rest;
  void step(int ticks = 1) {
    for (int k = 0; k < ticks; ++k) {
      rest.resize(grain.size());
      const GrainRows all{entity, grain, velocity, spin, orientation, previous, material, rest};
      solver.step(std::span(&all, 1), colliders, parameters);
    }
  }
  uint32_t asleep() const { return solver.stats().asleep; }
};

}  // namespace scree::grains::test

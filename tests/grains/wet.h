// What the tests of cohesion share: the law's force.
#pragma once

#include "modules/grains/cohesion.h"
#include "tests/grains/law.h"
#include "tests/grains/resting.h"

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

}  // namespace scree::grains::test

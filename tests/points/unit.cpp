// The rules of points against brute force, without GL.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <cmath>

#include "engine/core/random.h"
#include "shaders/shared/points.h"

namespace scree::test {
namespace {

// Mean over the visible disc of max(0, n . l), by rays on a grid.
double phaseByRays(double cosine) {
  const dvec3 light(std::sqrt(1 - cosine * cosine), 0, cosine);
  constexpr int kSide = 1000;
  double sum = 0;
  int hits = 0;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i) {
      const double x = 2 * (i + 0.5) / kSide - 1, y = 2 * (j + 0.5) / kSide - 1, r2 = x * x + y * y;
      if (r2 > 1) continue;
      ++hits;
      sum += std::max(0.0, glm::dot(dvec3(x, y, std::sqrt(1 - r2)), light));
    }
  return sum / hits;
}

TEST(Balls, PhaseIsTheMeanOverTheDisc) {
  for (const double cosine : {-1.0, -0.7, -0.2, 0.0, 0.3, 0.8, 1.0})
    EXPECT_NEAR(static_cast<double>(rules::ballPhase(static_cast<float>(cosine))), phaseByRays(cosine), 2e-4) << cosine;
}

TEST(Balls, NormalReflectsAsTheBallDoes) {
  for (uint64_t k = 0; k < 10000; ++k) {
    const auto direction = [&](uint32_t at) {
      const float z = 2 * randomUnit(1, k, 0, at) - 1, a = 6.2831853f * randomUnit(1, k, 0, at + 1), s = std::sqrt(1 - z * z);
      return vec3(s * std::cos(a), s * std::sin(a), z);
    };
    const vec3 eye = direction(0), light = k % 10 == 0 ? eye : k % 10 == 1 ? -eye : direction(2);
    const vec3 n = rules::ballNormal(eye, light);
    EXPECT_NEAR(glm::length(n), 1, 1e-5);
    EXPECT_NEAR(glm::dot(n, light), rules::ballPhase(glm::dot(eye, light)), 1e-5);
  }
}

TEST(Shares, AreThoseOfATentAndMakeOne) {
  for (uint64_t k = 0; k < 1000; ++k) {
    const vec2 f(randomUnit(2, k, 0, 0), randomUnit(2, k, 0, 1));
    const vec4 shares = rules::pointShares(f);
    EXPECT_NEAR(shares.x + shares.y + shares.z + shares.w, 1, 1e-6);
    EXPECT_NEAR(shares.y + shares.w, f.x, 1e-6);
    EXPECT_NEAR(shares.z + shares.w, f.y, 1e-6);
  }
}

TEST(Keys, AreOrderedAndGoBack) {
  float last = 0;
  for (float along = 1e6f; along > 1e-3f; along *= 0.93f) {
    const uint32_t key = rules::pointKey(along);
    EXPECT_GT(key, rules::pointKey(along * 1.001f));
    EXPECT_NEAR(rules::alongOf(key) / along, 1, 1e-6);
    last = along;
  }
  EXPECT_GT(last, 0);
}

}  // namespace
}  // namespace scree::test

// Parts of the neighbour search: companies of grains, and which neighbours nearly touch.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <vector>

#include "modules/grains/company.h"
#include "modules/grains/grid.h"
#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

Body sphereAt(vec3 position, float radius) {
  Body body;
  body.position = position;
  body.radius = radius;
  return body;
}

TEST(Company, ReachesWhatAnyOfItsGrainsReaches) {
  constexpr float kMargin = 0.02f;
  int reached = 0, missed = 0;
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    Company company;
    std::vector<Body> grains;
    for (uint64_t k = 0;; ++k) {
      const Body grain = sphereAt(vec3(0.07f * static_cast<float>(k), 0, 0) + 0.1f * unitCube(seed, k),
                                  0.04f + 0.02f * unit(seed, k, 3));
      if (!company.admits(grain, kMargin)) break;
      grains.push_back(grain);
    }
    ASSERT_FALSE(grains.empty());
    company.close();
    for (const Body& grain : grains) {
      const float reach = grain.radius + kMargin;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(company.low()[axis], grain.position[axis] - reach);
        EXPECT_GE(company.high()[axis], grain.position[axis] + reach);
      }
    }
    for (uint64_t k = 0; k < 50; ++k) {
      const vec3 at = vec3(0.9f, 0.4f, 0.4f) * unitCube(seed, k, 5) - 0.15f;
      bool expected = false;
      for (const Body& grain : grains) {
        const double sum = double{grain.radius} + kMargin + 0.05;
        expected = expected || glm::length(glm::dvec3(at) - glm::dvec3(grain.position)) < sum;
      }
      EXPECT_EQ(company.reaches(at, 0.05f), expected) << "seed " << seed << ", sphere " << k;
      ++(expected ? reached : missed);
    }
  }
  EXPECT_GT(reached, 1000);
  EXPECT_GT(missed, 1000);
}

TEST(Company, StaysSlim) {
  Company company;
  EXPECT_TRUE(company.admits(sphereAt({0, 0, 0}, 0.05f), 0));
  EXPECT_FALSE(company.admits(sphereAt({1, 0, 0}, 0.05f), 0));
  EXPECT_FALSE(company.admits(sphereAt({0, 0.4f, 0}, 0.05f), 0));
  EXPECT_TRUE(company.admits(sphereAt({0.4f, 0, 0}, 0.05f), 0));
}

TEST(Search, SaysWhichNeighboursNearlyTouch) {
  constexpr uint32_t kCount = 1500;
  Bodies bodies, sorted;
  bodies.count = sorted.count = kCount;
  for (uint32_t k = 0; k < kCount; ++k) {
    bodies.body.push_back(sphereAt(1.8f * unitCube(3, k), 0.03f + 0.03f * unit(3, k, 3)));
    bodies.margin.push_back(0.02f);
    bodies.entity.push_back({k, 1});
  }
  for (const Lanes lanes : {Lanes::Baseline, Lanes::Avx2, Lanes::Avx512}) {
    const Kernels* kernels = kernelsOf(lanes);
    if (kernels == nullptr) continue;
    Grid grid;
    Workspace workspace;
    grid.use(*kernels);
    sorted.body.clear();
    sorted.margin.clear();
    for (const uint32_t from : grid.plan(bodies, workspace)) {
      sorted.body.push_back(bodies.body[from]);
      sorted.margin.push_back(bodies.margin[from]);
    }
    grid.read(sorted);
    int near = 0, apart = 0;
    for (uint32_t slot = 0; slot < kCount; ++slot) {
      std::vector<uint32_t> found;
      grid.neighbours(slot, found);
      for (const uint32_t neighbour : found) {
        const Body &a = sorted.body[slot], &b = sorted.body[neighbour & ~kNearBit];
        const double distance = glm::length(glm::dvec3(a.position) - glm::dvec3(b.position));
        const double border = double{kNearlyTouching} * (double{a.radius} + double{b.radius});
        if (std::abs(distance - border) < 1e-6) continue;  // either, by rounding
        EXPECT_EQ((neighbour & kNearBit) != 0, distance < border);
        ++(distance < border ? near : apart);
      }
    }
    EXPECT_GT(near, 500);
    EXPECT_GT(apart, 500);
  }
}

}  // namespace
}  // namespace scree::grains::test

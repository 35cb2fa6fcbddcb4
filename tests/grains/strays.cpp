// Grains that leave their margin far from all others: followed without a search, and still met by
// whatever they come to.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <vector>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

TEST(Strays, AFlightPastAHeapCallsForNoSearch) {
  Field field;
  field.parameters.gravity = vec3(0);
  for (uint64_t k = 0; k < 400; ++k) field.add(2.0f * unitCube(2, k), 0.05f);
  field.step(60);  // overlaps are undone
  const vec3 from(-5, 3, 1), velocity(25, 0, 0);
  const size_t flyer = field.add(from, 0.05f, {}, velocity);
  constexpr int kTicks = 40;
  uint32_t searches = 0;
  for (int tick = 0; tick < kTicks; ++tick) {
    field.step();
    searches += field.solver.stats().rebuilds;
  }
  EXPECT_LE(searches, 8u);  // four substeps a tick, and a margin of two of them: 80
  const vec3 expected = from + velocity * (kTicks / 60.0f);
  EXPECT_LT(glm::length(field.grain[flyer].position - expected), 1e-3f);
}

// Ticks until `hit`, while the flyer is followed: half as many searches as substeps, at most.
template <class Hit>
void flyUntil(Field& field, const Hit& hit, float metres) {
  uint32_t searches = 0;
  int tick = 0;
  for (; tick < 60 && !hit(); ++tick) {
    field.step();
    searches += field.solver.stats().rebuilds;
  }
  EXPECT_TRUE(hit()) << "from " << metres << " m";
  EXPECT_LT(searches, static_cast<uint32_t>(2 * tick)) << "from " << metres << " m";
}

constexpr float kSpeed = 25;  // m/s
constexpr GrainMaterial kHard{1000, 0.3f, 0, 1};
// Where flights begin: the impact falls anywhere in a substep, and on either side of a margin.
constexpr int kFlights = 40;
float flight(int k) { return 5 + 0.0173f * static_cast<float>(k); }

TEST(Strays, StrikeAGrainInTheirWay) {
  for (int k = 0; k < kFlights; ++k) {
    Field field;
    field.parameters.gravity = vec3(0);
    field.add({-flight(k), 0, 0}, 0.05f, kHard, {kSpeed, 0, 0});
    const size_t target = field.add({0, 0.02f, 0}, 0.05f, kHard);
    flyUntil(field, [&] { return field.velocity[target].linear.x > 0.8f * kSpeed; }, flight(k));
  }
}

TEST(Strays, StrikeEachOther) {
  for (int k = 0; k < kFlights; ++k) {
    Field field;
    field.parameters.gravity = vec3(0);
    field.add({-flight(k), 0, 0}, 0.05f, kHard, {kSpeed, 0, 0});
    field.add({5, 0.02f, 0}, 0.05f, kHard, {-kSpeed, 0, 0});
    flyUntil(field, [&] { return field.velocity[0].linear.x < -0.7f * kSpeed; }, flight(k));
  }
}

TEST(Strays, BounceOffAThinWall) {
  for (int k = 0; k < kFlights; ++k) {
    Field field;
    field.parameters.gravity = vec3(0);
    field.add({-flight(k), 0, 0}, 0.05f, kHard, {kSpeed, 0, 0});
    for (int n = 0; n < 60; ++n)  // so that the mean motion, which margins follow, is none
      field.add({50, 0, 0.2f * static_cast<float>(n)}, 0.05f);
    field.addBox({0.01f, 0, 0}, {0.01f, 1, 1}, 0.3f).restitution = 1;
    flyUntil(field, [&] { return field.velocity[0].linear.x < -0.9f * kSpeed; }, flight(k));
    EXPECT_LT(field.grain[0].position.x, 0);
  }
}

TEST(Strays, AreStoppedByASleeperInTheirWay) {
  for (int k = 0; k < kFlights; ++k) {
    Field field;
    field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0);
    const size_t target = field.add({0, 0.05f, 0}, 0.05f, kHard);
    std::vector<GrainRest> rest;
    uint32_t searches = 0;
    const auto step = [&] {
      rest.resize(field.grain.size());
      const GrainRows all{field.entity,      field.grain,    field.velocity, field.spin,
                          field.orientation, field.previous, field.material, rest};
      field.solver.step(std::span(&all, 1), field.colliders, field.parameters);
      searches += field.solver.stats().rebuilds;
    };
    for (int tick = 0; tick < 120; ++tick) step();
    ASSERT_TRUE(rest[target].asleep);
    // Along the ground, with which it is listed all the time. It passes its speed on, or bounces off
    // if the strike comes too fast to wake the sleeper.
    const size_t flyer = field.add({-flight(k), 0.05f, 0}, 0.05f, kHard, {kSpeed, 0, 0});
    searches = 0;
    int tick = 0;
    for (; tick < 60 && field.velocity[flyer].linear.x > 0.2f * kSpeed; ++tick) step();
    EXPECT_LT(tick, 60) << "from " << flight(k) << " m";
    EXPECT_LT(field.grain[flyer].position.x, 0.05f) << "from " << flight(k) << " m";
    EXPECT_LT(searches, static_cast<uint32_t>(2 * tick)) << "from " << flight(k) << " m";
  }
}

}  // namespace
}  // namespace scree::grains::test

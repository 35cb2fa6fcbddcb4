// What cohesion must not break: momentum, energy, bits, saves, sleep, and hostile numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include <glm/geometric.hpp>

#include "engine/core/parallel.h"
#include "tests/grains/wet.h"

namespace scree::grains::test {
namespace {

// Wet clumps that fly into each other.
void addClumps(Field& field, float cohesion, float restitution = 0) {
  field.parameters.gravity = vec3(0);
  for (uint64_t k = 0; k < 400; ++k) {
    const float side = k % 2 == 0 ? -1.0f : 1.0f;
    const float r = 0.03f * std::exp2(unit(3, k, 6));
    field.add(unitCube(3, k) * 0.8f + vec3(0.7f * side, 0.1f * side, 0), r, {1000, 0.5f, 0.02f, restitution, cohesion},
              vec3(-side, 0, 0) + (unitCube(3, k, 7) - 0.5f) * 0.5f);
  }
}

TEST(Cohesion, KeepsMomentum) {
  for (const float c : {0.1f, 10.0f, 1000.0f})
    for (const float e : {0.0f, 0.4f}) {
      Field field;
      addClumps(field, c, e);
      const glm::dvec3 linear = field.momentum(), angular = field.angularMomentum();
      double size = 0;
      for (size_t k = 0; k < field.grain.size(); ++k)
        size += field.mass(k) * static_cast<double>(glm::length(field.velocity[k].linear));
      field.step(120);
      EXPECT_LT(glm::length(field.momentum() - linear) / size, 1e-5) << c;
      EXPECT_LT(glm::length(field.angularMomentum() - angular) / size, 1e-3) << c;  // arm 1 m
    }
}

// How much the energy rises above the least that it had, at most, as a share of what it was at first.
double worstRise(Field& field, int ticks) {
  const double first = field.energy();
  double least = first, worst = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    field.step();
    const double now = field.energy();
    worst = std::max(worst, (now - least) / first);
    least = std::min(least, now);
  }
  return worst;
}

// Kept impulses of an impact are too large for the next substep; what a few passes leave of that is all
// that rises, and it grows with what contacts may pull.
TEST(Cohesion, EnergyNeverGrows) {
  struct Case {
    float cohesion;
    double most;
  };
  for (const Case& one : {Case{0, 1e-5}, Case{0.1f, 1e-5}, Case{10, 1e-4}, Case{1000, 1e-3}, Case{1e6f, 2e-2}}) {
    for (const float e : {0.0f, 0.4f}) {
      Field field;
      addClumps(field, one.cohesion, e);
      field.step();  // overlaps of the filling
      const double rise = worstRise(field, 240);
      std::printf("clumps of %g N/m, restitution %.1f: %.2g\n", static_cast<double>(one.cohesion),
                  static_cast<double>(e), rise);
      EXPECT_LT(rise, one.most) << one.cohesion << ' ' << e;
    }
    Field field;  // what falls, lies and hangs
    pour(field, 7, 7, kRadius, 6, 0.3f, {1000, 0.5f, 0.02f, 0, one.cohesion});
    for (Collider& collider : field.colliders) collider.cohesion = one.cohesion;
    const double rise = worstRise(field, 300);
    std::printf("falling, %g N/m: %.2g\n", static_cast<double>(one.cohesion), rise);
    EXPECT_LT(rise, one.most) << one.cohesion;
  }
}

// Sand of all sizes, wet and dry, that falls into a bin whose walls hold it.
void fillWet(Field& field, float restitution) {
  for (uint64_t k = 0; k < 500; ++k)
    field.add(unitCube(4, k) * vec3(1, 2, 1) - vec3(0.5f, -0.3f, 0.5f), 0.01f * std::exp2(3 * unit(4, k, 3)),
              {1000, 0.4f, 0.01f, restitution, k % 3 == 0 ? 0.0f : 0.5f * static_cast<float>(k % 7)});
  field.addBin(0.6f, 0.4f);
  for (Collider& collider : field.colliders) collider.cohesion = 2;
}

TEST(Cohesion, SameBitsByThreadsLanesAndRows) {
  for (const float e : {0.0f, 0.3f}) {
    uint64_t want = 0;
    for (const Lanes lanes : {Lanes::Widest, Lanes::Baseline})
      for (const int threads : {1, 2, 4}) {
        setThreadCount(threads);
        Field field;
        field.parameters.lanes = lanes;
        fillWet(field, e);
        if (threads == 2) {
          const auto turn = [](auto& rows) { std::reverse(rows.begin(), rows.end()); };
          turn(field.entity), turn(field.grain), turn(field.velocity), turn(field.spin);
          turn(field.orientation), turn(field.previous), turn(field.material);
        }
        field.step(150);
        if (want == 0) want = field.hash();
        EXPECT_EQ(field.hash(), want) << "threads " << threads;
      }
    setThreadCount(0);
  }
}

TEST(Cohesion, SavedGoesOnToTheBit) {
  for (const int saved_at : {40, 120, 400}) {
    RestingField bed;
    fillWet(bed, 0.3f);
    bed.step(saved_at);
    const std::string bytes = bed.solver.saved();
    Result<GrainSolver> solver = GrainSolver::restored(bytes, bed.next);
    ASSERT_TRUE(solver.ok()) << solver.error();
    RestingField again = bed;
    again.solver = std::move(solver).value();
    bed.step(60);
    again.step(60);
    EXPECT_EQ(again.hash(), bed.hash()) << saved_at;
  }
}

TEST(Cohesion, WhatHangsFallsAsleepAndWakesWhenItsHoldGoes) {
  for (const int change : {0, 1, 2, 3}) {
    RestingField bed;
    bed.addBox({0, 0.1f, 0}, {0.3f, 0.1f, 0.3f}, 0.5f).cohesion = 100;
    bed.colliders[0].sensed = true;
    for (int k = 0; k < 3; ++k)
      bed.add({0, -kRadius * static_cast<float>(1 + 2 * k), 0}, kRadius, {1000, 0.5f, 0.1f, 0, 200});
    bed.step(120);
    ASSERT_EQ(bed.solver.stats().asleep, 3u);
    EXPECT_NEAR(bed.grain[2].position.y, -5 * kRadius, 0.02f * kRadius);
    EXPECT_NEAR(-bed.colliders[0].load.y * 60 / kG / (3 * bed.mass(0)), 1, 0.01);
    bed.step(120);
    ASSERT_EQ(bed.solver.stats().asleep, 3u);
    if (change == 0) bed.colliders.clear();
    if (change == 1) bed.material[0].cohesion = 0;
    if (change == 2) removeRow(bed, 0), bed.rest.resize(2);
    if (change == 3) bed.colliders[0].cohesion = 0;
    bed.step(30);
    EXPECT_EQ(bed.solver.stats().asleep, 0u) << change;
    for (const Grain& g : bed.grain) EXPECT_LT(g.position.y, -1) << change;
  }
}

TEST(Cohesion, HangsOnAWallThatMoves) {
  Field field;
  Collider& box = field.addBox({0, 0.1f, 0}, {0.3f, 0.1f, 0.3f}, 0.5f);
  box.cohesion = 100;
  field.add({0, -kRadius, 0}, kRadius, {1000, 0.5f, 0.1f, 0, 200});
  for (int tick = 0; tick < 120; ++tick) {
    box.position0 = box.position1;
    box.position1 += vec3(1, 2, 0) * (static_cast<float>(tick + 1) / 3600);  // 1 and 2 m/s^2
    field.step();
  }
  EXPECT_NEAR(field.grain[0].position.x, box.position1.x, 0.2f * kRadius);
  EXPECT_NEAR(field.grain[0].position.y, box.position1.y - 0.1f - kRadius, 1e-3f);
}

TEST(Cohesion, BadNumbersAreRefused) {
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const float bad : {-1e-3f, 1.1e6f, inf, nan}) {
    GrainBlock block;
    block.cohesion = bad;
    EXPECT_NE(fault(block).find("cohesion"), std::string::npos) << bad;
    PlaneCollider plane;
    plane.cohesion = bad;
    EXPECT_NE(fault(plane).find("cohesion"), std::string::npos) << bad;
    GrainEmitter emitter;
    emitter.cohesion = bad;
    EXPECT_NE(fault(emitter).find("cohesion"), std::string::npos) << bad;
    Field field;
    field.add({0, 1, 0}, kRadius, {1000, 0.5f, 0, 0, bad});
    field.step();
    EXPECT_EQ(field.solver.refused().size(), 1u) << bad;
  }
}

TEST(Cohesion, HostileScenesStayFinite) {
  for (const float c : {1e-6f, 1e6f})
    for (const float dt : {0.0f, 1e-9f, 1.0f / 60, 10.0f}) {
      Field field;
      field.parameters.dt = dt;
      for (uint64_t k = 0; k < 300; ++k) {
        const float r = k % 20 == 0 ? 0.2f : 0.01f;  // 1:20
        field.add(unitCube(8, k), r, {k % 2 == 0 ? 1e-3f : 1e6f, 0.5f, 0.1f, 0.5f, c});
      }
      for (int k = 0; k < 50; ++k) field.add({0.5f, 0.5f, 0.5f}, 1e-5f, {1000, 0.5f, 0, 0, c});
      field.addBin(0.8f, 0.5f);
      for (Collider& collider : field.colliders) collider.cohesion = c;
      field.step(30);
      EXPECT_TRUE(field.finite()) << c << ' ' << dt;
    }
}

TEST(Cohesion, StepsOfChangingLengthHoldWhatHangs) {
  Field field;
  field.addPlane({0, 0, 0}, {0, 1, 0, 0}, 0.5f).cohesion = 1e6f;
  for (int k = 0; k < 3; ++k)
    field.add({0, -kRadius * static_cast<float>(1 + 2 * k), 0}, kRadius, {1000, 0.5f, 0, 0, cohesionFor(3)});
  for (int tick = 0; tick < 400; ++tick) {
    field.parameters.dt = tick % 3 == 0 ? 1.0f / 200 : tick % 3 == 1 ? 1.0f / 60 : 1.0f / 100;
    field.parameters.substeps = 3 + tick / 9 % 2;
    field.step();
  }
  EXPECT_NEAR(field.grain[2].position.y, -5 * kRadius, 0.02f * kRadius);
}

}  // namespace
}  // namespace scree::grains::test

// What must not break: a stirred heap for a million ticks, and 50,000 grains where 10,000 have room.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>
#include <vector>

#include "tests/grains/resting.h"

namespace scree::grains::test {
namespace {

struct Scatter {
  double mean = 0, error = 0;  // of the mean
};
Scatter scatterOf(std::span<const double> values) {
  Scatter s;
  const double n = static_cast<double>(values.size());
  for (const double v : values) s.mean += v / n;
  for (const double v : values) s.error += (v - s.mean) * (v - s.mean);
  s.error = std::sqrt(s.error / (n * (n - 1)));
  return s;
}

// A blade turns for 300 ticks and stands still for 200, again and again: the heap flows, comes to rest, falls
// asleep in parts and wakes. What a turn does scatters, and turns that follow each other are alike; so the
// energies of a tenth are taken as the means of 20 blocks of 10 turns, whose scatter says how well a tenth's
// mean is known.
TEST(Endurance, StirredHeapStaysWhole) {
  constexpr int kTicks = 1'000'000, kTenth = kTicks / 10, kTurn = 500, kTurning = 300, kBlock = kTenth / 20;
  constexpr float kRadius = 0.05f;
  RestingField field;
  pour(field, 5, 5, kRadius, 41, 0.4f, {1000, 0.5f, 0.02f, 0.2f});
  Collider& blade = field.addBox({0, 0.15f, 0}, {0.3f, 0.13f, 0.02f}, 0.5f);
  const float wall = std::abs(field.colliders[1].position0.x);
  const std::vector<Entity> entities = field.entity;
  std::vector<float> radii;
  for (const Grain& grain : field.grain) radii.push_back(grain.radius);
  const auto turned = [&](int tick) {
    const double angle = 0.02 * (tick / kTurn * kTurning + std::min(tick % kTurn, kTurning));  // 1.2 rad/s
    return quat(static_cast<float>(std::cos(0.5 * angle)), 0, static_cast<float>(std::sin(0.5 * angle)), 0);
  };
  std::vector<double> energy(kTicks / kBlock), overlap(kTicks / kBlock);
  double deepest = 0, fastest = 0;
  size_t most_asleep = 0;
  uint64_t woken = 0;
  for (int tick = 0; tick < kTicks; ++tick) {
    blade.rotation0 = turned(tick);
    blade.rotation1 = turned(tick + 1);
    field.step();
    ASSERT_TRUE(field.finite()) << "tick " << tick;
    const double now = field.kineticEnergy();
    energy[static_cast<size_t>(tick / kBlock)] += now / kBlock;
    fastest = std::max(fastest, now);
    woken += field.solver.stats().woken;
    if (tick % 20 != 0) continue;
    ASSERT_TRUE(field.solver.lost().empty() && field.solver.refused().empty()) << "tick " << tick;
    most_asleep = std::max(most_asleep, field.asleep());
    const double worst = field.deepestOverlap();
    overlap[static_cast<size_t>(tick / kBlock)] += worst * 20 / kBlock;
    if (tick >= kTenth) deepest = std::max(deepest, worst);
    for (size_t k = 0; k < field.grain.size(); ++k) {
      const vec3 p = field.grain[k].position;
      ASSERT_TRUE(std::abs(p.x) < wall && std::abs(p.z) < wall && p.y > 0 && p.y < 3)
          << "grain " << k << " at tick " << tick << ": " << p.x << ' ' << p.y << ' ' << p.z;
    }
  }
  EXPECT_EQ(field.entity, entities);
  for (size_t k = 0; k < radii.size(); ++k) EXPECT_EQ(field.grain[k].radius, radii[k]);
  size_t known = field.solver.sleepers().count();
  field.solver.eachAwake([&](Entity, const Body&, const GrainMaterial&) { ++known; });
  EXPECT_EQ(known, radii.size());
  EXPECT_GT(most_asleep, radii.size() / 2);
  EXPECT_GT(woken, 1000u);

  for (int k = 0; k < 10; ++k)
    std::printf("%.4f ", scatterOf(std::span(energy).subspan(static_cast<size_t>(20 * k), 20)).mean);
  std::printf("J: mean kinetic energy by tenths\n");
  const Scatter e1 = scatterOf(std::span(energy).subspan(20, 20)), e9 = scatterOf(std::span(energy).last(20));
  const Scatter o1 = scatterOf(std::span(overlap).subspan(20, 20)), o9 = scatterOf(std::span(overlap).last(20));
  std::printf("stirred, second tenth and last: kinetic energy %.4f +- %.4f and %.4f +- %.4f J (most %.1f); deepest "
              "overlap of a moment %.4f +- %.4f and %.4f +- %.4f radii, of all %.3f; most asleep %zu, woken %llu\n",
              e1.mean, e1.error, e9.mean, e9.error, fastest, o1.mean, o1.error, o9.mean, o9.error, deepest,
              most_asleep, static_cast<unsigned long long>(woken));
  // Three standard errors of the difference: chance alone exceeds them once in 700 times.
  const double e_margin = 3 * std::hypot(e1.error, e9.error), o_margin = 3 * std::hypot(o1.error, o9.error);
  EXPECT_LT(e_margin, 0.1 * e1.mean);  // or growth would hide in it
  EXPECT_LT(o_margin, 0.1 * o1.mean);
  EXPECT_LT(e9.mean, e1.mean + e_margin);
  EXPECT_LT(o9.mean, o1.mean + o_margin);
  // The blade never yields, and jams grains in the bin's corners; but no centre gets inside another grain.
  EXPECT_LT(deepest, 1);
}

// Overlap is undone by a share a pass, which spreads like heat: 50,000 that have room on all sides take some
// 8 s, and between walls, where each layer must lift those above, minutes.
TEST(Endurance, CrowdSeparatesWithoutExplosion) {
  RestingField field;
  constexpr float kRadius = 0.05f;
  constexpr uint64_t kCount = 50000;
  const float side = std::cbrt(10000.0f) * 2 * kRadius;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
  for (uint64_t k = 0; k < kCount; ++k)
    field.add((unitCube(51, k) - vec3(0.5f, 0, 0.5f)) * side + vec3(0, kRadius, 0), kRadius,
              {1000, 0.5f, 0.02f, 0});
  double fastest = 0;
  for (int tick = 0; tick < 600; ++tick) {
    field.step();
    ASSERT_TRUE(field.finite()) << "tick " << tick;
    for (const GrainVelocity& v : field.velocity)
      fastest = std::max(fastest, static_cast<double>(glm::length(v.linear)));
  }
  float highest = 0;
  for (const Grain& g : field.grain) highest = std::max(highest, g.position.y);
  // What a fall from the height of all of them in one column of that side gives.
  const double height = 5 * static_cast<double>(side);
  EXPECT_LT(fastest, std::sqrt(2 * 9.81 * height));
  EXPECT_LT(highest, height);
  const double overlap = field.deepestOverlap();
  std::printf("crowd: fastest %.2f m/s, deepest overlap %.4f radii after 10 s\n", fastest, overlap);
  EXPECT_LT(overlap, 0.05);
}

}  // namespace
}  // namespace scree::grains::test

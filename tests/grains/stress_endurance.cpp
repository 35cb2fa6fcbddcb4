// What must not break: a stirred heap for 100,000 ticks, and 50,000 grains where 10,000 have room.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

TEST(Endurance, StirredHeapStaysWhole) {
  Field field;
  field.parameters.damping = 0.05f;
  pour(field, 6, 6, 0.05f, 41, 0.2f, {1000, 0.5f, 0.02f, 0.2f});
  Collider& paddle = field.addBox({0, 0.15f, 0}, {0.3f, 0.12f, 0.03f}, 0.5f);
  const float wall = std::abs(field.colliders[1].position0.x);
  constexpr int kTicks = 100000;
  double first = 0, last = 0;  // mean kinetic energy of the first and the last tenth
  for (int tick = 0; tick < kTicks; ++tick) {
    const auto turned = [&](int t) {
      const float angle = 0.02f * static_cast<float>(t % 31416);  // 1.2 rad/s
      return quat(std::cos(0.5f * angle), 0, std::sin(0.5f * angle), 0);
    };
    paddle.rotation0 = turned(tick);
    paddle.rotation1 = turned(tick + 1);
    field.step();
    if (tick % 10 == 0) {
      ASSERT_TRUE(field.finite()) << "tick " << tick;
    }
    const double energy = field.kineticEnergy();
    if (tick < kTicks / 10) first += energy / (kTicks / 10);
    if (tick >= kTicks - kTicks / 10) last += energy / (kTicks / 10);
    if (tick % 100 != 0) continue;
    for (size_t k = 0; k < field.grain.size(); ++k) {
      const vec3 p = field.grain[k].position;
      ASSERT_TRUE(std::abs(p.x) < wall && std::abs(p.z) < wall && p.y > 0 && p.y < 3)
          << "grain " << k << " at tick " << tick << ": " << p.x << ' ' << p.y << ' ' << p.z;
    }
  }
  std::printf("stirred: mean kinetic energy %.5f J at first, %.5f J at last\n", first, last);
  EXPECT_TRUE(field.solver.lost().empty() && field.solver.refused().empty());
  EXPECT_LT(last, 1.2 * first);
}

TEST(Endurance, CrowdSeparatesWithoutExplosion) {
  Field field;
  constexpr float kRadius = 0.05f;
  constexpr uint64_t kCount = 50000;
  const float side = std::cbrt(10000.0f) * 2 * kRadius;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
  for (uint64_t k = 0; k < kCount; ++k)
    field.add((unitCube(51, k) - vec3(0.5f, 0, 0.5f)) * side + vec3(0, kRadius, 0), kRadius,
              {1000, 0.5f, 0.02f, 0});
  double fastest = 0;
  for (int tick = 0; tick < 90; ++tick) {
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
}

}  // namespace
}  // namespace scree::grains::test

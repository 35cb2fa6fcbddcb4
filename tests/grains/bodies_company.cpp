// Rigid bodies in company: the same bits whatever runs them, saves, wheels, hostile worlds, what wakes them.
#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>

#include <filesystem>

#include "tests/grains/body_level.h"

namespace scree::grains::test {
namespace {

// A paddle wheel under a stream, loose boxes, a capsule, a scale.
void machine(BodyLevel& level) {
  level.floor(0.6f);
  level.world.spawn(at({0.25, 2.2, 0}), GrainEmitter{.rate = 120, .mouth = 0.1f, .velocity = {0, -2, 0}, .radius = 0.04f, .rolling_friction = 0.05f});
  RigidBody wheel;
  wheel.damping = 0;
  level.world.spawn(at({0, 1.2, 0}), BoxCollider{.half_extent = {0.5f, 0.04f, 0.3f}}, wheel, BodyHinge{.resistance = 0.2f});
  level.box({0.5, 0.15, 0}, {0.15f, 0.15f, 0.15f});
  level.box({0.52, 0.46, 0}, {0.15f, 0.15f, 0.15f});
  level.world.spawn(at({-0.6, 0.3, 0}), CapsuleCollider{.a = {0, 0, -0.2f}, .b = {0, 0, 0.2f}, .radius = 0.1f}, RigidBody{});
  level.world.spawn(at({1.2, 0.3, 0}), BoxCollider{.half_extent = {0.3f, 0.05f, 0.3f}}, RigidBody{}, BodySlider{.stiffness = 2000, .resistance = 50});
}

// Of bodies and grains, by entity.
std::map<uint32_t, std::vector<double>> stateOf(World& world) {
  std::map<uint32_t, std::vector<double>> by;
  world.query<const Transform, const RigidBody>().each([&](Entity e, const Transform& t, const RigidBody& b) {
    for (int k = 0; k < 3; ++k)
      for (const double v : {t.position[k], static_cast<double>(b.velocity[k]), static_cast<double>(b.spin[k])}) by[e.index].push_back(v);
    for (int k = 0; k < 4; ++k) by[e.index].push_back(static_cast<double>(t.rotation[k]));
    by[e.index].push_back(b.asleep);
  });
  world.query<const Grain, const GrainVelocity, const GrainSpin>().each(
      [&](Entity e, const Grain& g, const GrainVelocity& v, const GrainSpin& w) {
        for (int k = 0; k < 3; ++k)
          for (const float x : {g.position[k], v.linear[k], w.angular[k]}) by[e.index].push_back(static_cast<double>(x));
      });
  return by;
}

TEST(Body, SameBitsForThreadsAndRows) {
  std::map<uint32_t, std::vector<double>> first;
  for (const int threads : {1, 2, 4, 0}) {
    BodyLevel level(std::max(threads, 1));
    machine(level);
    for (int tick = 0; tick < 300; ++tick) {
      level.run();
      if (threads == 0 && tick % 7 == 0) level.turnRows();
    }
    if (first.empty()) first = stateOf(level.world);
    EXPECT_EQ(stateOf(level.world), first) << threads;
  }
  setThreadCount(1);
}

TEST(Body, SavedAndLoadedGoesOnToTheBit) {
  BodyLevel level;
  machine(level);
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "bodies.world";
  for (const int ticks : {1, 60, 120, 200, 400}) {
    level.run(ticks);
    ASSERT_TRUE(level.world.save(file).ok());
    BodyLevel other;
    const Status read = other.world.load(file);
    ASSERT_TRUE(read.ok()) << read.error();
    for (int k = 0; k < 60; ++k) {
      level.run();
      other.run();
      ASSERT_EQ(stateOf(level.world), stateOf(other.world)) << ticks << " + " << k;
    }
  }
  std::filesystem::remove(file);
}

TEST(Body, WheelTakesNoMoreThanTheStreamHas) {
  BodyLevel level;
  level.world.spawn(at({0.35, 2.2, 0}), GrainEmitter{.rate = 150, .mouth = 0.05f, .velocity = {0, -3, 0}, .radius = 0.03f});
  level.floor();
  RigidBody wheel;
  wheel.damping = 0;
  const float resistance = 0.5f;
  const Entity e = level.world.spawn(at({0, 1.2, 0}), BoxCollider{.half_extent = {0.5f, 0.03f, 0.3f}}, wheel, BodyHinge{.resistance = resistance});
  const double mass = 8.0 * 0.5 * 0.03 * 0.3 * 500, moment = mass / 3 * (0.25 + 0.0009);
  double taken = 0, turned = 0;
  for (int tick = 0; tick < 600; ++tick) {
    level.run();
    const double w = static_cast<double>(level.body(e).spin.z);
    taken += static_cast<double>(resistance) * w * w / 60;
    turned += w / 60;
    ASSERT_NEAR(glm::length(level.place(e).position - dvec3(0, 1.2, 0)), 0, 1e-6);
    ASSERT_NEAR(std::abs(glm::dot(level.place(e).rotation * vec3(0, 0, 1), vec3(0, 0, 1))), 1, 1e-6);
  }
  const double w = static_cast<double>(level.body(e).spin.z);
  taken += 0.5 * moment * w * w;
  double emitted = 0;
  level.world.query<const GrainEmitter>().each([&](const GrainEmitter& m) { emitted = static_cast<double>(m.emitted); });
  const double grain = static_cast<double>(grainMass(0.03f, 1500));
  const double had = emitted * grain * (0.5 * 9 + kG * (2.2 - 0.7));  // down to the paddle's lowest place
  std::printf("wheel turned %.2f rad, took %.2f J of %.2f\n", turned, taken, had);
  EXPECT_LT(turned, -3);  // with the stream
  EXPECT_LT(taken, had);
  EXPECT_GT(taken, 0.02 * had);
}

TEST(Body, RefusesBadValues) {
  EXPECT_NE(fault(RigidBody{.density = 0}), "");
  EXPECT_NE(fault(RigidBody{.mass = -1}), "");
  EXPECT_NE(fault(RigidBody{.velocity = {kNan, 0, 0}}), "");
  EXPECT_NE(fault(RigidBody{.spin = {0, kInf, 0}}), "");
  EXPECT_NE(fault(RigidBody{.damping = -1}), "");
  EXPECT_EQ(fault(RigidBody{}), "");
  EXPECT_NE(fault(BodyHinge{.axis = vec3(0)}), "");
  EXPECT_NE(fault(BodyHinge{.resistance = kNan}), "");
  EXPECT_EQ(fault(BodyHinge{}), "");
  EXPECT_NE(fault(BodySlider{.stiffness = -1}), "");
  EXPECT_NE(fault(BodySlider{.low = 2, .high = 1}), "");
  EXPECT_EQ(fault(BodySlider{}), "");
}

// A written NaN stops the body, and nothing else.
TEST(Body, StandsStillWhileItsNumbersAreBad) {
  BodyLevel level;
  level.floor();
  const Entity e = level.box({0, 2, 0}, vec3(0.2f));
  for (int k = 0; k < 20; ++k) level.grain({0.02f * static_cast<float>(k), 2.4f + 0.12f * static_cast<float>(k), 0}, 0.05f);
  level.run(5);
  const dvec3 was = level.place(e).position;
  level.world.find<RigidBody>(e)->velocity.y = kNan;
  level.run(60);
  EXPECT_EQ(level.place(e).position, was);
  for (const auto& [entity, s] : level.seen()) EXPECT_TRUE(std::isfinite(s.position.x + s.position.y + s.velocity.y));
  level.world.find<RigidBody>(e)->velocity = vec3(0);
  level.run(240);
  EXPECT_LT(level.place(e).position.y, 0.4);
}

// Nothing flies off faster than it can have fallen, and all stays finite.
TEST(Body, SurvivesHostileCompany) {
  for (const float mass : {1e-6f, 1e-3f, 1.0f, 1e6f}) {
    BodyLevel level;
    level.floor();
    GrainBlock block;
    block.count = {10, 20, 10};
    block.density = 2000;
    level.world.spawn(at({0, 1.1, 0}), block);  // buries them
    level.box({0, 0.3, 0}, vec3(0.2f), {.mass = mass});
    level.box({0.05, 0.32, 0}, vec3(0.2f), {.mass = mass});  // inside the other
    level.box({0.3, 2.5, 0}, {0.3f, 0.005f, 0.3f}, {.mass = mass});
    level.box({-0.3, 3.5, 0}, vec3(0.15f), {.mass = 1e6f * mass});
    double fastest = 0, low = 1e9;
    for (int tick = 0; tick < 240; ++tick) {
      level.run();
      level.world.query<const Transform, const RigidBody>().each([&](const Transform& t, const RigidBody& b) {
        ASSERT_TRUE(std::isfinite(t.position.x + t.position.y + t.position.z));
        fastest = std::max(fastest, static_cast<double>(glm::length(b.velocity)));
        low = std::min(low, t.position.y);
      });
    }
    // What was inside a heavy body may be pressed through the floor, and falls.
    double grains = 0;
    size_t through = 0;
    for (const auto& [entity, s] : level.seen()) {
      ASSERT_TRUE(std::isfinite(s.position.x + s.position.y + s.position.z));
      const bool fell = static_cast<double>(s.position.y) + grainField(level.world).origin.y < 0;
      through += fell;
      if (!fell) grains = std::max(grains, static_cast<double>(glm::length(s.velocity)));
    }
    std::printf("mass %g: fastest body %.2f m/s, lowest %.3f m, fastest grain at the end %.2f m/s, through the floor %zu\n",
                static_cast<double>(mass), fastest, low, grains, through);
    EXPECT_LT(fastest, 40);
    EXPECT_GT(low, -0.2);
    EXPECT_LT(grains, 20);
    EXPECT_LT(through, 40u);  // of 2,000
  }
}

TEST(Body, CostsNothingWhereThereIsNone) {
  BodyLevel level;
  level.heap({0, 0, 0}, {5, 5, 5});
  level.run(60);
  EXPECT_EQ(level.world.singleton<const BodyStats>().solved, 0u);
  EXPECT_EQ(level.world.singleton<const BodyStats>().bodies, 0u);
}

TEST(Body, WakesWhenWrittenToOrWhenItsFloorGoes) {
  BodyLevel level;
  const Entity ground = level.floor();
  const Entity e = level.box({0, 0.2, 0}, vec3(0.2f));
  level.run(120);
  ASSERT_TRUE(level.sleeps(e));
  level.world.find<Transform>(e)->position.y += 0.5;
  level.run(2);
  EXPECT_FALSE(level.sleeps(e));
  level.run(300);
  ASSERT_TRUE(level.sleeps(e));
  level.world.find<RigidBody>(e)->velocity = vec3(1, 0, 0);
  level.run(1);
  EXPECT_GT(level.body(e).velocity.x, 0.5f);
  level.run(300);
  ASSERT_TRUE(level.sleeps(e));
  grainField(level.world).gravity = vec3(0, -5, 0);
  level.run(1);
  EXPECT_FALSE(level.sleeps(e));
  level.run(300);
  ASSERT_TRUE(level.sleeps(e));
  level.world.destroy(ground);
  level.run(30);
  EXPECT_LT(level.body(e).velocity.y, -1);
}

}  // namespace
}  // namespace scree::grains::test

// Emitters: their rate, where grains appear, what is held back, and what is refused.
#include <nlohmann/json.hpp>

#include "engine/assets/extras.h"
#include "tests/grains/level.h"

namespace scree::grains::test {
namespace {

const GrainEmitter& emitterOf(Level& level, Entity entity) { return *level.world.peek<GrainEmitter>(entity); }

TEST(Emitter, KeepsItsRateToTheGrain) {
  for (const float rate : {1.0f, 7.3f, 60.0f, 100.0f, 1234.5f}) {
    Level level;
    level.weightless();
    const Entity e = level.world.spawn(
        at({0, 5, 0}), GrainEmitter{.rate = rate, .mouth = 2, .velocity = {0, -6, 0}, .radius = 0.01f});
    for (int tick = 1; tick <= 300; ++tick) {
      level.run();
      const GrainEmitter& now = emitterOf(level, e);
      const double due = static_cast<double>(rate) * tick / 60;
      ASSERT_EQ(now.held_back, 0u);
      ASSERT_NEAR(static_cast<double>(now.emitted) + now.due, due, 1e-5 * due) << rate << ' ' << tick;
      ASSERT_GE(now.due, 0);
      ASSERT_LE(now.due, 1);
    }
    EXPECT_EQ(level.count(), emitterOf(level, e).emitted);
  }
}

TEST(Emitter, GrainsAreOnTheParabolaOfTheirMoment) {
  Level level;
  grainField(level.world).damping = 0;
  constexpr double kRate = 37, kG = 9.81;
  Transform transform = at({3, 4, 5});
  transform.rotation = glm::angleAxis(1.5707963f, vec3(0, 1, 0));  // local x is -z
  level.world.spawn(transform,
                    GrainEmitter{.rate = kRate, .mouth = 0, .velocity = {6, 2, 0}, .radius = 0.02f});
  level.run(60);
  const dvec3 origin = grainField(level.world).origin;
  EXPECT_EQ(origin, dvec3(3, 4, 5));
  const auto all = level.seen();
  ASSERT_EQ(all.size(), 37u);
  int k = 0;
  for (const auto& [entity, s] : all) {
    const double age = 61.0 / 60 - ++k / kRate;  // one tick more than the time since it was due
    EXPECT_NEAR(s.position.z, -6 * age, 2e-4) << k;
    EXPECT_NEAR(s.position.y, 2 * age - 0.5 * kG * age * age, 2e-4) << k;
    EXPECT_NEAR(s.position.x, 0, 1e-5);
    EXPECT_NEAR(s.velocity.y, 2 - kG * age, 2e-4);
  }
}

TEST(Emitter, KindOfGrainAndItsJitter) {
  Level level;
  GrainEmitter emitter{.rate = 2000, .mouth = 3, .velocity = {0, -5, 0}, .spread = 1, .radius = 0.02f};
  emitter.radius_jitter = 0.3f;
  emitter.density = 2500;
  emitter.friction = 0.7f;
  level.weightless();
  level.world.spawn(at({0, 0, 0}), emitter);
  level.run(60);
  float smallest = 1, largest = 0, fastest = 0;
  level.world.query<const Grain, const GrainVelocity, const GrainMaterial>().each(
      [&](const Grain& g, const GrainVelocity& v, const GrainMaterial& m) {
        smallest = std::min(smallest, g.radius);
        largest = std::max(largest, g.radius);
        const float off = glm::length(v.linear - vec3(0, -5, 0));
        fastest = std::max(fastest, off);
        EXPECT_EQ(m.density, 2500);
        EXPECT_EQ(m.friction, 0.7f);
        EXPECT_LE(std::hypot(g.position.x, g.position.z), 3.1f + off);
      });
  EXPECT_GE(smallest, 0.02f * 0.6999f);
  EXPECT_LT(smallest, 0.02f * 0.71f);
  EXPECT_LE(largest, 0.02f * 1.3001f);
  EXPECT_GT(largest, 0.02f * 1.29f);
  EXPECT_GT(fastest, 0.9f);  // of a ball of 1 m/s
}

TEST(Emitter, NeverIntoATakenPlace) {
  // Nothing moves: what overlaps would be pushed, and what does not stays to the bit. The mouth fills
  // up, beside a boulder, a sleeping-sized speck and half under a box.
  Level level;
  level.weightless();
  level.grain({1.5f, 0.5f, 1.2f}, 1.0f);
  level.grain({-0.4f, 0.01f, 0.2f}, 0.004f);
  level.world.spawn(at({0, 0, -1}), BoxCollider{.half_extent = vec3(4, 0.5f, 1)});
  GrainEmitter emitter{.rate = 600, .mouth = 1, .velocity = vec3(0)};
  emitter.radius_jitter = 0.4f;
  const Entity e = level.world.spawn(at({0, 0, 0}), emitter);
  // Another that comes out at the same place in the same tick.
  emitter.seed = 2;
  const Entity other = level.world.spawn(at({0.1, 0, 0}), emitter);
  std::map<Entity, Level::Seen> before;
  for (int tick = 0; tick < 120; ++tick) {
    level.run();
    const auto now = level.seen();
    for (const auto& [entity, s] : before) ASSERT_EQ(now.at(entity).position, s.position);
    before = now;
    ASSERT_EQ(level.deepestOverlap(), 0) << tick;
  }
  const GrainEmitter &a = emitterOf(level, e), &b = emitterOf(level, other);
  EXPECT_GT(a.held_back, 500u);
  EXPECT_EQ(a.emitted + a.held_back, 1200u);
  EXPECT_EQ(b.emitted + b.held_back, 1200u);
  EXPECT_EQ(level.count(), 2 + a.emitted + b.emitted);
  EXPECT_GT(a.emitted, 40u);
  for (const auto& [entity, s] : before) {
    if (s.radius == 1.0f || s.radius == 0.004f) continue;
    EXPECT_GE(s.position.z, s.radius) << "inside the box";
    EXPECT_EQ(s.position.y, 0);
  }
}

TEST(Emitter, WhatWasJammedDoesNotCome) {
  Level level;
  const Entity gate = level.world.spawn(at({0, 5, 0}), BoxCollider{.half_extent = vec3(1)});
  const Entity e = level.world.spawn(
      at({0, 5, 0}), GrainEmitter{.rate = 90, .mouth = 1, .velocity = {0, -6, 0}, .radius = 0.01f});
  level.run(60);
  EXPECT_EQ(emitterOf(level, e).emitted, 0u);
  EXPECT_EQ(emitterOf(level, e).held_back, 90u);
  level.world.find<Transform>(gate)->position.x = 50;  // a teleport
  for (int k = 1; k <= 60; ++k) {
    level.run();
    EXPECT_NEAR(static_cast<double>(emitterOf(level, e).emitted), 1.5 * k, 1.001);
  }
  EXPECT_EQ(emitterOf(level, e).held_back, 90u);
}

TEST(Emitter, StopsAtItsMostAndWhenOff) {
  Level level;
  level.weightless();
  const Entity e = level.world.spawn(
      at({0, 5, 0}), GrainEmitter{.rate = 100, .most = 77, .mouth = 1, .velocity = {0, -6, 0}, .radius = 0.01f});
  level.run(20);
  const GrainEmitter before = emitterOf(level, e);
  EXPECT_EQ(before.emitted, 33u);
  level.world.find<GrainEmitter>(e)->on = false;
  level.run(100);
  EXPECT_EQ(emitterOf(level, e).emitted, 33u);
  EXPECT_EQ(emitterOf(level, e).due, before.due);  // time off is not made up for
  level.world.find<GrainEmitter>(e)->on = true;
  level.run(100);
  EXPECT_EQ(emitterOf(level, e).emitted, 77u);
  EXPECT_EQ(emitterOf(level, e).held_back, 0u);
  EXPECT_EQ(level.count(), 77u);
}

TEST(Emitter, BadOnesAreRefused) {
  const auto refused = [](auto change) {
    Level level;
    GrainEmitter emitter{.rate = 100, .mouth = 1, .radius = 0.01f};
    Transform transform = at({0, 5, 0});
    change(emitter, transform);
    EXPECT_FALSE(fault(emitter).empty() && transform.position == dvec3(0, 5, 0) && transform.scale == vec3(1));
    level.world.spawn(transform, emitter);
    level.run(5);
    EXPECT_EQ(level.count(), 0u) << fault(emitter);
  };
  using E = GrainEmitter;
  using T = Transform;
  refused([](E& e, T&) { e.rate = kNan; });
  refused([](E& e, T&) { e.rate = -1; });
  refused([](E& e, T&) { e.rate = 1e9f; });
  refused([](E& e, T&) { e.rate = kInf; });
  refused([](E& e, T&) { e.mouth = kNan; });
  refused([](E& e, T&) { e.mouth = -1; });
  refused([](E& e, T&) { e.velocity.y = kInf; });
  refused([](E& e, T&) { e.spread = kNan; });
  refused([](E& e, T&) { e.radius = 0; });
  refused([](E& e, T&) { e.radius_jitter = 1; });
  refused([](E& e, T&) { e.density = kNan; });
  refused([](E& e, T&) { e.restitution = 2; });
  refused([](E& e, T&) { e.due = kNan; });
  refused([](E& e, T&) { e.due = 1e9; });
  refused([](E&, T& t) { t.position.x = std::numeric_limits<double>::quiet_NaN(); });
  refused([](E&, T& t) { t.position.x = 1e300; });
  refused([](E& e, T& t) {
    e.mouth = 1e6f;
    t.scale = vec3(1e33f);
  });
  EXPECT_NE(fault(GrainEmitter{.rate = 1e9f}).find("rate = 1e+09; allowed is 0 to 100000"), std::string::npos);
}

TEST(Emitter, TheFastestIsBounded) {
  // A hundred thousand grains a second from a mouth for a few: held back, not heaped up.
  Level level;
  const Entity e = level.world.spawn(at({0, 5, 0}), GrainEmitter{.rate = 1e5f, .mouth = 0.1f});
  level.run(60);
  const GrainEmitter& now = emitterOf(level, e);
  EXPECT_NEAR(static_cast<double>(now.emitted + now.held_back), 1e5, 1.5);
  EXPECT_LT(now.emitted, 400u);
  EXPECT_LT(level.deepestOverlap(), 0.01);
}

TEST(Emitter, FromExtras) {
  Level level;
  const Entity e = level.world.spawn(at({0, 5, 0}));
  const auto attach = [&](const char* text) {
    return attachExtras(level.world, e, nlohmann::json::parse(text), "level.glb");
  };
  EXPECT_TRUE(attach(R"({"GrainEmitter": {"rate": 30, "radius": 0.02, "velocity": [0, -4, 0]},
                         "GrainSink": {"radius": 0.2, "on": false},
                         "GrainForce": {"drag": 2, "flow": [3, 0, 0]},
                         "GrainBlow": {"radius": 2, "strength": 10},
                         "GrainGrid": {"cells": [2, 3, 4]}})").ok());
  level.run(60);
  EXPECT_EQ(emitterOf(level, e).emitted, 30u);
  for (const char* bad : {R"({"GrainEmitter": {"rate": 1e9}})", R"({"GrainEmitter": {"most": -1}})",
                          R"({"GrainSink": {"half_extent": [1, -1, 1]}})", R"({"GrainSink": {"mass": -2}})",
                          R"({"GrainForce": {"falloff": 0}})", R"({"GrainForce": {"drag": -1}})",
                          R"({"GrainBlow": {"radius": -1}})", R"({"GrainGrid": {"cells": [0, 1, 1]}})",
                          R"({"GrainGrid": {"cells": [2000, 2000, 2000]}})", R"({"GrainGrid": {"every": 0}})",
                          R"({"GrainGrid": {"half_extent": [0, 1, 1]}})"}) {
    const Status status = attach(bad);
    ASSERT_FALSE(status.ok()) << bad;
    EXPECT_EQ(status.error().rfind("level.glb: extras: ", 0), 0u) << status.error();
  }
}

// Two streams onto a small heap that sleeps and wakes, with everything else that a level may have.
uint64_t streams(int threads, dvec3 place, bool turn, std::map<Entity, Level::Seen>& out) {
  Level level(threads);
  level.heap(place, {6, 3, 6});
  GrainEmitter emitter{.rate = 240, .mouth = 0.25f, .velocity = {0, -2, 0}, .spread = 0.5f, .radius = 0.03125f};
  emitter.radius_jitter = 0.25f;
  level.world.spawn(at(place + dvec3(0.25, 2, 0)), emitter);
  emitter.seed = 9;
  level.world.spawn(at(place + dvec3(-0.25, 1.5, 0.125)), emitter, RegionSensor{});
  level.world.spawn(at(place + dvec3(0, 0.125, 0.5)), GrainSink{.half_extent = vec3(0.125f), .radius = 0.25f});
  level.world.spawn(at(place), GrainForce{.half_extent = vec3(0.5f, 4, 4), .acceleration = {2, 0, 0},
                                          .drag = 0.5f, .swirl = 2});
  level.world.spawn(at(place), GrainGrid{.every = 3});
  level.world.singleton<GrainStrikes>().least_speed = 0.5f;
  uint64_t sum = 0;
  for (int tick = 0; tick < 120; ++tick) {
    if (tick == 60) impulseInSphere(level.world, place, 1, 200);
    level.run();
    if (turn && tick % 7 == 0) level.turnRows();
    sum = hashCombine(sum, level.world.stateHash());
    for (const GrainStrike& s : level.world.singleton<const GrainStrikes>().list) {
      sum = hashCombine(sum, s.a.bits() ^ s.b.bits());
      sum = hashBytes(&s.impulse, 4, hashBytes(&s.speed, 4, sum));
    }
    for (const GrainGridValues& g : level.world.singleton<const GrainGrids>().grids) {
      sum = hashBytes(g.fraction.data(), g.fraction.size() * 8, sum);
      sum = hashBytes(g.velocity.data(), g.velocity.size() * 12, sum);
    }
  }
  out = level.seen();
  setThreadCount(0);
  return sum;
}

TEST(Determinism, ThreadsRowsAndPlace) {
  std::map<Entity, Level::Seen> want, now;
  const uint64_t hash = streams(1, {0, 0, 0}, false, want);
  EXPECT_GT(want.size(), 500u);
  EXPECT_EQ(streams(2, {0, 0, 0}, false, now), hash);
  EXPECT_EQ(streams(4, {0, 0, 0}, false, now), hash);
  EXPECT_EQ(streams(2, {0, 0, 0}, true, now), hash);
  EXPECT_TRUE(now == want);
  streams(1, {1e6, -1e6, 1e6}, false, now);
  EXPECT_TRUE(now == want) << "1e6 m away";
}

TEST(Skip, WhatALevelLacksDoesNotRun) {
  Level level;
  level.grain({0, 5, 0});
  level.run(10);
  for (const char* name : {"grains.emit", "grains.push", "grains.sink", "grains.splat", "grains.spawn"})
    EXPECT_EQ(level.runs(name), 0u) << name;
  EXPECT_EQ(level.runs("grains.step"), 10u);
  EXPECT_TRUE(level.world.singleton<const GrainStrikes>().list.empty());

  level.world.spawn(at({0, 9, 0}), GrainEmitter{.on = false});
  level.world.spawn(at({0, 9, 0}), GrainForce{});
  level.world.spawn(at({0, 9, 0}), GrainSink{});
  const Entity grid = level.world.spawn(at({0, 9, 0}), GrainGrid{});
  level.run(10);
  for (const char* name : {"grains.emit", "grains.push", "grains.sink", "grains.splat"})
    EXPECT_EQ(level.runs(name), 10u) << name;
  level.world.destroy(grid);
  level.run(10);
  EXPECT_EQ(level.runs("grains.splat"), 11u);  // once more, to forget
  EXPECT_TRUE(level.world.singleton<const GrainGrids>().grids.empty());
}

TEST(Skip, AnEmitterAloneMakesNoField) {
  Level level;
  level.world.spawn(at({0, 9, 0}), GrainEmitter{.on = false});
  level.world.spawn(at({0, 9, 0}), GrainSink{});
  const size_t entities = level.world.entityCount();
  level.run(10);
  EXPECT_EQ(level.world.entityCount(), entities);
  EXPECT_EQ(level.runs("grains.sink"), 0u);  // without a grain
  EXPECT_EQ(level.runs("grains.step"), 0u);
}

}  // namespace
}  // namespace scree::grains::test

// The module in a World, without GL: blocks, colliders with Transforms, sensors, counts, the same
// bits for every thread count and far from the origin.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <sstream>

#include "modules/grains/bodies.h"
#include "tests/grains/app.h"

namespace scree {
namespace {

using grains::test::at;
using grains::test::makeApp;

uint64_t runsOf(const App& app, std::string_view name) {
  for (const SystemReport& report : const_cast<App&>(app).schedule().report())
    if (report.name == name) return report.runs;
  return ~uint64_t{0};
}

// A heap that falls on a tray at `origin`.
std::unique_ptr<App> heapAt(dvec3 origin, int threads = 1,
                            std::array<int32_t, 3> count = {8, 5, 8}) {
  auto app = makeApp(threads);
  GrainBlock block;
  block.count = count;
  block.radius_jitter = 0.2f;
  block.rolling_friction = 0.02f;
  app->world().spawn(at(origin + dvec3(0, 0.45, 0)), block);
  app->world().spawn(at(origin + dvec3(0, -0.25, 0)), BoxCollider{.half_extent = vec3(9, 0.25f, 9)},
                     LoadSensor{});
  app->world().spawn(at(origin + dvec3(0.3, 0.1, 0)),
                     CapsuleCollider{.a = vec3(0, 0, -0.3f), .b = vec3(0, 0, 0.3f), .radius = 0.1f});
  return app;
}

void run(App& app, int ticks) {
  for (int k = 0; k < ticks; ++k) app.tick();
}

// Grains' numbers by row, without their place in the world.
std::vector<float> numbers(App& app) {
  std::vector<float> all;
  app.world().query<const Grain, const GrainVelocity, const GrainSpin, const GrainOrientation>().each(
      [&](const Grain& g, const GrainVelocity& v, const GrainSpin& w, const GrainOrientation& o) {
        for (int k = 0; k < 3; ++k) {
          all.push_back(g.position[k]);
          all.push_back(v.linear[k]);
          all.push_back(w.angular[k]);
          all.push_back(o.rotation[k]);
        }
      });
  return all;
}

TEST(Block, BecomesGrainsOnce) {
  auto app = makeApp();
  World& world = app->world();
  GrainBlock block;
  block.count = {4, 3, 5};
  block.radius = 0.04f;
  block.radius_jitter = 0.3f;
  block.density = 2000;
  block.friction = 0.7f;
  const Entity e = world.spawn(at({10.4, 2.3, -7.7}), block);
  app->tick();
  EXPECT_FALSE(world.has<GrainBlock>(e));
  EXPECT_EQ(world.query<const Grain>().count(), 60u);
  EXPECT_EQ(grainField(world).origin, dvec3(10, 2, -8));
  app->tick();
  EXPECT_EQ(world.query<const Grain>().count(), 60u);
  std::vector<Grain> all;
  world.query<const Grain, const GrainMaterial>().each([&](const Grain& g, const GrainMaterial& m) {
    EXPECT_GE(g.radius, 0.04f * 0.699f);
    EXPECT_LE(g.radius, 0.04f * 1.301f);
    EXPECT_EQ(m.density, 2000);
    EXPECT_EQ(m.friction, 0.7f);
    all.push_back(g);
  });
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t j = i + 1; j < all.size(); ++j)
      EXPECT_GE(glm::length(all[i].position - all[j].position), all[i].radius + all[j].radius - 1e-5f);
}

TEST(Block, IsCenteredAndTurnedWithItsTransform) {
  auto app = makeApp();
  World& world = app->world();
  GrainBlock block;
  block.count = {20, 1, 1};
  block.spacing = 0.2f;
  Transform transform = at({3, 5, 7});
  transform.rotation = glm::angleAxis(1.5707963f, vec3(0, 1, 0));  // x becomes -z
  world.spawn(transform, block);
  app->tick();
  const dvec3 origin = grainField(world).origin;
  dvec3 sum(0);
  double low = 1e9, high = -1e9;
  world.query<const Grain>().each([&](const Grain& g) {
    const dvec3 p = origin + dvec3(g.position);
    sum += p;
    low = std::min(low, p.z);
    high = std::max(high, p.z);
    EXPECT_NEAR(p.x, 3, 0.06);
  });
  EXPECT_NEAR(sum.x / 20, 3, 0.03);
  EXPECT_NEAR(sum.z / 20, 7, 0.03);
  EXPECT_NEAR(high - low, 19 * 0.2, 0.2);
}

TEST(Block, BadOnesAreRefusedAndCounted) {
  auto app = makeApp();
  World& world = app->world();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto spawn = [&](auto change) {
    GrainBlock block;
    change(block);
    world.spawn(Transform{}, block);
  };
  spawn([&](GrainBlock& b) { b.radius = 0; });
  spawn([&](GrainBlock& b) { b.radius = -1; });
  spawn([&](GrainBlock& b) { b.radius = nan; });
  spawn([&](GrainBlock& b) { b.radius_jitter = 1; });
  spawn([&](GrainBlock& b) { b.density = 0; });
  spawn([&](GrainBlock& b) { b.density = nan; });
  spawn([&](GrainBlock& b) { b.friction = -1; });
  spawn([&](GrainBlock& b) { b.restitution = 2; });
  spawn([&](GrainBlock& b) { b.spacing = 0.05f; });
  spawn([&](GrainBlock& b) { b.count = {1000, 1000, 1000}; });
  spawn([&](GrainBlock& b) { b.count = {2000000000, 2000000000, 2000000000}; });
  spawn([&](GrainBlock& b) { b.count = {-3, 5, 5}; });
  spawn([&](GrainBlock& b) { b.count = {1, 1, 1}; });
  app->tick();
  EXPECT_EQ(grainField(world).refused, 12u);
  EXPECT_EQ(world.query<const Grain>().count(), 1u);
}

TEST(Grains, BadOnesAreRemovedAndCounted) {
  auto app = makeApp();
  World& world = app->world();
  std::vector<GrainSpec> specs(6);
  for (size_t k = 0; k < 6; ++k) specs[k].grain.position = vec3(0, static_cast<float>(k), 0);
  specs[1].grain.radius = 0;
  specs[2].grain.radius = -0.1f;
  specs[3].grain.radius = std::numeric_limits<float>::quiet_NaN();
  specs[4].material.density = std::numeric_limits<float>::quiet_NaN();
  spawnGrains(world, specs);
  app->tick();
  EXPECT_EQ(world.query<const Grain>().count(), 2u);
  EXPECT_EQ(grainField(world).refused, 4u);
  EXPECT_EQ(grainField(world).lost, 0u);
}

TEST(Grains, LeavingTheBoundsAreLost) {
  auto app = makeApp();
  World& world = app->world();
  grainField(world).bounds_min.y = -3;
  std::vector<GrainSpec> specs(10);
  for (size_t k = 0; k < 10; ++k)
    specs[k].grain.position = vec3(static_cast<float>(k), k < 4 ? 0.1f : 1.0f, 0);
  world.spawn(at({7.5, 0, 0}), BoxCollider{.half_extent = vec3(4, 0.05f, 1)});  // under rows 4 to 9
  spawnGrains(world, specs);
  run(*app, 120);
  EXPECT_EQ(world.query<const Grain>().count(), 6u);
  EXPECT_EQ(grainField(world).lost, 4u);
}

TEST(Colliders, BadOnesAreLeftOut) {
  auto app = makeApp();
  World& world = app->world();
  GrainSpec spec;
  spec.grain.position = {0, 1, 0};
  spawnGrains(world, {&spec, 1});
  world.spawn(at({0, 0, 0}), BoxCollider{.half_extent = vec3(std::nanf(""), 1, 1)});
  world.spawn(at({0, 0, 0}), CapsuleCollider{.radius = -1});
  world.spawn(at({std::numeric_limits<double>::quiet_NaN(), 0, 0}), PlaneCollider{});
  world.spawn(at({0, 0, 0}), PlaneCollider{.friction = std::nanf("")});
  world.spawn(at({0, -0.5, 0}), BoxCollider{});
  run(*app, 90);
  ASSERT_EQ(world.query<const Grain>().count(), 1u);
  world.query<const Grain>().each([](const Grain& g) { EXPECT_NEAR(g.position.y, 0.05, 1e-3); });
}

TEST(Colliders, ScaleAppliesToTheShape) {
  auto app = makeApp();
  World& world = app->world();
  Transform transform = at({0, 0, 0});
  transform.scale = {4, 2, 4};
  world.spawn(transform, BoxCollider{});
  GrainSpec spec;
  spec.grain.position = {1.5f, 2, 1.5f};
  spawnGrains(world, {&spec, 1});
  run(*app, 90);
  world.query<const Grain>().each([](const Grain& g) { EXPECT_NEAR(g.position.y, 1.05, 1e-3); });
}

TEST(Colliders, MoveByTheirTransform) {
  // A box that the game moves carries a grain with it; a jump does not throw it.
  auto app = makeApp();
  World& world = app->world();
  const Entity lift = world.spawn(at({0, -0.5, 0}), BoxCollider{.half_extent = vec3(1, 0.5f, 1), .friction = 1});
  GrainSpec spec;
  spec.grain.position = {0, 0.05f, 0};
  spec.material.rolling_friction = 0.2f;
  spawnGrains(world, {&spec, 1});
  run(*app, 10);
  for (int k = 0; k < 120; ++k) {
    world.find<Transform>(lift)->position += dvec3(0.01, 0.005, 0);
    app->tick();
  }
  world.query<const Grain, const GrainVelocity>().each([](const Grain& g, const GrainVelocity& v) {
    EXPECT_NEAR(g.position.y, 0.65, 5e-3);
    EXPECT_NEAR(v.linear.x, 0.6, 0.03);
    EXPECT_NEAR(v.linear.y, 0.3, 0.03);
  });
  world.find<Transform>(lift)->position += dvec3(0, -50, 0);  // a teleport
  app->tick();
  world.query<const GrainVelocity>().each(
      [](const GrainVelocity& v) { EXPECT_LT(glm::length(v.linear), 2.0f); });
}

TEST(Sensors, LoadIsTheWeightAndRegionCounts) {
  auto app = heapAt({0, 0, 0});
  World& world = app->world();
  const Entity region = world.spawn(at({0, 2, 0}), RegionSensor{.half_extent = vec3(9, 2, 9)});
  const Entity nothing = world.spawn(at({30, 2, 0}), RegionSensor{.half_extent = vec3(9, 2, 9)});
  // The capsule rests on the tray: it carries some grains itself.
  Entity capsule;
  world.query<const CapsuleCollider>().each([&](Entity e, const CapsuleCollider&) { capsule = e; });
  world.add(capsule, LoadSensor{});
  run(*app, 400);
  double mass = 0;
  world.query<const Grain, const GrainMaterial>().each(
      [&](const Grain& g, const GrainMaterial& m) { mass += grainMass(g.radius, m.density); });
  double weight = 0;
  for (int k = 0; k < 60; ++k) {
    app->tick();
    double now = 0;
    world.query<const LoadSensor>().each([&](const LoadSensor& s) { now -= s.impulse.y; });
    EXPECT_NEAR(now * 60 / 9.81 / mass, 1, 0.005) << k;
    weight += now;
  }
  EXPECT_NEAR(weight / 9.81 / mass, 1, 0.001);
  EXPECT_EQ(world.peek<RegionSensor>(region)->count, world.query<const Grain>().count());
  EXPECT_NEAR(world.peek<RegionSensor>(region)->mass / mass, 1, 1e-5);
  EXPECT_EQ(world.peek<RegionSensor>(nothing)->count, 0u);
  EXPECT_GT(world.peek<LoadSensor>(capsule)->contacts, 0u);

  // When the grains have gone, the sensors read nothing.
  std::vector<Entity> all;
  world.query<With<Grain>>().each([&](Entity e) { all.push_back(e); });
  world.destroyMany(all);
  run(*app, 2);
  world.query<const LoadSensor>().each([](const LoadSensor& s) { EXPECT_EQ(s.impulse, vec3(0)); });
  EXPECT_EQ(world.peek<RegionSensor>(region)->count, 0u);
}

TEST(FarAway, TheSameHeapAtEightOffsets) {
  std::vector<float> want;
  for (const dvec3 origin :
       {dvec3(0, 0, 0), dvec3(1000, 0, 0), dvec3(0, 0, -77777), dvec3(-1e6, 0, 0), dvec3(0, 1e6, 0),
        dvec3(1e6, -1e6, 1e6), dvec3(12345678, 0, 0), dvec3(-1e8, 1e8, 1e8)}) {
    auto app = heapAt(origin);
    run(*app, 120);
    const std::vector<float> now = numbers(*app);
    ASSERT_EQ(now.size(), 12u * 320);
    if (want.empty()) want = now;
    // Bit for bit where the offsets are whole metres that doubles hold with the colliders' places;
    // 0.1 and 0.3 m are not binary fractions, so what is left is the rounding of those.
    double worst = 0;
    for (size_t k = 0; k < 320; ++k)
      worst = std::max<double>(worst, std::abs(now[12 * k] - want[12 * k]));
    double mean = 0, mean_want = 0;
    for (size_t k = 0; k < 320; ++k) {
      mean += static_cast<double>(now[12 * k + 4]) / 320;
      mean_want += static_cast<double>(want[12 * k + 4]) / 320;
    }
    EXPECT_NEAR(mean, mean_want, 0.01) << origin.x;
  }
}

TEST(FarAway, BitForBitWithBinaryPlaces) {
  std::vector<float> want;
  for (const dvec3 origin : {dvec3(0, 0, 0), dvec3(1e6, 0, -1e6), dvec3(-3, 1e6, 7), dvec3(1e9, 1e9, 1e9)}) {
    auto app = makeApp();
    GrainBlock block;
    block.count = {6, 5, 6};
    block.radius_jitter = 0.2f;
    app->world().spawn(at(origin + dvec3(0, 1, 0)), block);
    app->world().spawn(at(origin + dvec3(0, -0.25, 0)), BoxCollider{.half_extent = vec3(2, 0.25f, 2)});
    app->world().spawn(at(origin + dvec3(0.25, 0.125, 0)), CapsuleCollider{.radius = 0.125f});
    run(*app, 100);
    const std::vector<float> now = numbers(*app);
    if (want.empty()) want = now;
    EXPECT_TRUE(now == want) << origin.x;
  }
}

TEST(Determinism, StateHashForEveryThreadCount) {
  uint64_t want = 0;
  for (const int threads : {1, 2, 4}) {
    auto app = heapAt({5, 0, 5}, threads, {12, 8, 12});
    uint64_t sum = 0;
    uint32_t most_pairs = 0;
    for (int k = 0; k < 120; ++k) {
      app->tick();
      sum = hashCombine(sum, app->world().stateHash());
      most_pairs = std::max(most_pairs, app->world().singleton<const GrainStats>().pairs);
    }
    EXPECT_GT(most_pairs, grains::kFewPairs);  // else threads have nothing to do
    if (threads == 1) want = sum;
    EXPECT_EQ(sum, want) << threads << " threads";
  }
  setThreadCount(0);
}

TEST(Skip, NoGrainsNoWork) {
  auto app = makeApp();
  World& world = app->world();
  world.spawn(at({0, 0, 0}), PlaneCollider{}, LoadSensor{});
  world.spawn(at({0, 0, 0}), RegionSensor{});
  const size_t entities = world.entityCount();
  run(*app, 10);
  EXPECT_EQ(runsOf(*app, "grains.spawn"), 0u);
  EXPECT_EQ(runsOf(*app, "grains.step"), 0u);
  EXPECT_EQ(world.entityCount(), entities);  // not even a field
  EXPECT_FALSE(world.query<const ColliderPose>().count() > 0);
}

}  // namespace
}  // namespace scree

// Regions: what sinks swallow and sensors read, against brute force.
#include "tests/grains/level.h"

namespace scree::grains::test {
namespace {

const GrainSink& sinkOf(Level& level, Entity e) { return *level.world.peek<GrainSink>(e); }

TEST(Sink, SwallowsAndCountsEveryGrain) {
  // A stream into a sink: what came is what is there and what was swallowed, number and mass.
  for (const float radius : {0.0f, 0.4f}) {
    Level level;
    GrainEmitter emitter{.rate = 500, .mouth = 0.3f, .velocity = {0, -4, 0}, .radius = 0.02f};
    emitter.radius_jitter = 0.5f;
    const Entity e = level.world.spawn(at({0, 3, 0}), emitter);
    const Entity s = level.world.spawn(at({0, 0, 0}),
                                       GrainSink{.half_extent = {0.5f, 0.2f, 0.5f}, .radius = radius});
    std::map<Entity, Level::Seen> before;
    double mass = 0;
    uint64_t gone = 0;
    for (int tick = 0; tick < 240; ++tick) {
      level.run();
      const auto now = level.seen();
      for (const auto& [entity, seen] : before) {
        if (now.count(entity) > 0) continue;
        ++gone;
        mass += Level::massOf(seen);
      }
      before = now;
      ASSERT_EQ(sinkOf(level, s).count, gone);
      ASSERT_NEAR(sinkOf(level, s).mass, mass, 1e-12 * mass);
      ASSERT_EQ(level.count() + gone, level.world.peek<GrainEmitter>(e)->emitted);
      for (const auto& [entity, seen] : now) {
        const dvec3 p = grainField(level.world).origin + dvec3(seen.position);
        if (radius > 0) {
          ASSERT_GE(glm::length(p), 0.4 - 1e-5);
        } else {
          ASSERT_FALSE(std::abs(p.x) < 0.4999 && std::abs(p.y) < 0.1999 && std::abs(p.z) < 0.4999);
        }
      }
    }
    EXPECT_GT(gone, 1000u);
    EXPECT_EQ(grainField(level.world).lost, 0u);
  }
}

TEST(Sink, RecyclesWithoutEnd) {
  // 30 times the number that is ever there at once.
  Level level;
  const Entity e = level.world.spawn(
      at({0, 2, 0}), GrainEmitter{.rate = 200, .mouth = 0.3f, .velocity = {0, -3, 0}, .radius = 0.03f});
  const Entity s = level.world.spawn(at({0, -1, 0}), GrainSink{.half_extent = {3, 1, 3}});
  size_t most = 0, least = 1000;
  uint64_t allocations = 0;
  for (int tick = 0; tick < 1200; ++tick) {
    level.run();
    if (tick == 600) allocations = level.world.singleton<const GrainStats>().allocations;
    most = std::max(most, level.count());
    if (tick > 120) least = std::min(least, level.count());
  }
  EXPECT_LT(most, 150u);
  EXPECT_GT(least, most - 20);
  EXPECT_EQ(level.world.peek<GrainEmitter>(e)->emitted, sinkOf(level, s).count + level.count());
  EXPECT_GT(sinkOf(level, s).count, 3500u);
  EXPECT_LT(level.world.singleton<const GrainStats>().allocations, allocations + 20);
}

TEST(Sink, TakesTheLowestEntitiesUpToItsMost) {
  for (const bool turned : {false, true}) {
    Level level;
    level.weightless();
    std::vector<Entity> all;
    for (int k = 0; k < 20; ++k) all.push_back(level.grain({0.2f * static_cast<float>(k), 0, 0}));
    if (turned) level.turnRows();
    const Entity s = level.world.spawn(at({2, 0, 0}), GrainSink{.half_extent = {1.5f, 1, 1}, .most = 7});
    level.run(3);
    EXPECT_EQ(sinkOf(level, s).count, 7u);
    for (size_t k = 0; k < all.size(); ++k) EXPECT_EQ(level.world.alive(all[k]), k < 3 || k >= 10) << k;
    // Another one over the same place goes on; the first is full.
    const Entity other = level.world.spawn(at({2, 0, 0}), GrainSink{.half_extent = {9, 1, 1}, .most = 3});
    level.run(3);
    EXPECT_EQ(sinkOf(level, s).count, 7u);
    EXPECT_EQ(sinkOf(level, other).count, 3u);
    EXPECT_EQ(level.count(), 10u);
  }
}

TEST(Sink, TwoOverOnePlaceShareTheGrains) {
  Level level;
  level.weightless();
  for (int k = 0; k < 50; ++k) level.grain({0.2f * static_cast<float>(k), 0, 0});
  const Entity a = level.world.spawn(at({2, 0, 0}), GrainSink{.half_extent = {2.1f, 1, 1}});
  const Entity b = level.world.spawn(at({4, 0, 0}), GrainSink{.half_extent = {2.1f, 1, 1}});
  level.run(2);
  EXPECT_EQ(sinkOf(level, a).count, 21u);
  EXPECT_EQ(sinkOf(level, b).count, 10u);
  EXPECT_EQ(level.count(), 19u);
}

TEST(Sink, UndermineASleepingHeap) {
  // A hole opens under sleepers: those above wake and follow, and all but those beside it go.
  Level level;
  level.heap({0, 0, 0}, {8, 4, 8});
  ASSERT_LT(level.sleep(), 3000);
  const Entity s = level.world.spawn(at({0, 0, 0}), GrainSink{.on = false, .half_extent = {0.3f, 0.15f, 0.3f}});
  level.run(30);
  EXPECT_EQ(sinkOf(level, s).count, 0u);
  EXPECT_EQ(level.asleep(), level.count());
  level.world.find<GrainSink>(s)->on = true;
  level.run(400);
  EXPECT_GT(sinkOf(level, s).count, 40u);
  EXPECT_EQ(sinkOf(level, s).count + level.count(), 256u);
  EXPECT_LT(level.deepestOverlap(), 0.005);
}

TEST(Sink, BadOnesSwallowNothing) {
  const auto refused = [](GrainSink sink, Transform transform = {}) {
    Level level;
    level.weightless();
    level.grain({0, 0, 0});
    level.world.spawn(transform, sink);
    level.run(5);
    EXPECT_EQ(level.count(), 1u);
  };
  refused({.half_extent = {kNan, 1, 1}});
  refused({.half_extent = {-1, 1, 1}});
  refused({.half_extent = {kInf, 1, 1}});
  refused({.radius = kNan});
  refused({.radius = -1});
  refused({.mass = std::numeric_limits<double>::quiet_NaN()});
  refused({}, at({1e300, 0, 0}));
  refused({}, at({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  Transform flat = at({0, 0.5, 0});
  flat.scale = vec3(0);
  refused({}, flat);
  refused({.half_extent = vec3(0)}, at({0, 0.01, 0}));  // holds no point but one
}

// What RegionSensor must read, grain by grain.
void expectReading(Level& level, Entity e, const char* when) {
  const Transform& transform = *level.world.peek<Transform>(e);
  const RegionSensor& sensor = *level.world.peek<RegionSensor>(e);
  const mat3 world_from_local = glm::mat3_cast(glm::normalize(transform.rotation));
  const vec3 centre = vec3(transform.position - grainField(level.world).origin);
  uint32_t count = 0;
  int64_t mass = 0;
  for (const auto& [entity, s] : level.seen()) {
    const vec3 local = (s.position - centre) * world_from_local;
    const vec3 half = sensor.half_extent * glm::abs(transform.scale);
    if (!(std::abs(local.x) <= half.x && std::abs(local.y) <= half.y && std::abs(local.z) <= half.z)) continue;
    ++count;
    mass += static_cast<int64_t>(static_cast<double>(grainMass(s.radius, s.density)) * 1e9);
  }
  ASSERT_EQ(sensor.count, count) << when;
  ASSERT_EQ(sensor.mass, static_cast<float>(static_cast<double>(mass) * 1e-9)) << when;
}

TEST(RegionSensor, EqualsBruteForceWhileAHeapSleepsAndWakesInParts) {
  Level level;
  level.heap({0, 0, 0}, {10, 4, 10});
  grainField(level.world).bounds_min.x = -3;
  std::vector<Entity> sensors;
  for (int k = 0; k < 8; ++k) {
    Transform transform = at({0.3 * k - 1, 0.05 * k, 0.1 * k});
    transform.rotation = glm::angleAxis(0.3f * static_cast<float>(k), glm::normalize(vec3(1, 2, 3)));
    sensors.push_back(level.world.spawn(
        transform, RegionSensor{.half_extent = {0.1f + 0.1f * static_cast<float>(k), 0.3f, 0.4f}}));
  }
  sensors.push_back(level.world.spawn(at({0, 0, 0}), RegionSensor{.half_extent = vec3(1e8f)}));
  const Entity rake =
      level.world.spawn(at({-9, 0.15, 0}), BoxCollider{.half_extent = {0.05f, 0.1f, 0.3f}});
  size_t partly = 0;
  for (int tick = 0; tick < 900; ++tick) {
    if (tick > 300 && tick < 700) level.world.find<Transform>(rake)->position.x = -1 + 0.005 * (tick - 300);
    if (tick == 500) level.world.find<Transform>(sensors[2])->position.x += 0.2;
    if (tick == 600) level.world.find<RegionSensor>(sensors[3])->half_extent.y = 0.1f;
    if (tick % 50 == 20) level.grain({-0.5f, 1.0f, 0.1f}, 0.05f, {-2, 1, 0});  // some roll off and are lost
    if (tick % 100 == 70) {
      const auto all = level.seen();
      level.world.destroy(std::next(all.begin(), tick / 9)->first);
    }
    if (tick == 800) level.world.destroy(sensors[4]);
    level.run();
    const size_t asleep = level.asleep();
    partly += asleep > 50 && asleep + 5 < level.count();
    for (const Entity e : sensors)
      if (level.world.alive(e)) expectReading(level, e, ("tick " + std::to_string(tick)).c_str());
  }
  EXPECT_GT(partly, 100u);
  EXPECT_GT(grainField(level.world).lost, 0u);
}

TEST(RegionSensor, WithoutBoundsOrPlace) {
  Level level;
  level.heap({0, 0, 0}, {4, 2, 4});
  ASSERT_LT(level.sleep(), 3000);
  Transform transform = at({0, 0, 0});
  transform.scale = vec3(1e30f);
  const Entity all = level.world.spawn(transform, RegionSensor{.half_extent = vec3(1e9f)});
  const Entity none =
      level.world.spawn(at({std::numeric_limits<double>::quiet_NaN(), 0, 0}), RegionSensor{});
  const Entity flat = level.world.spawn(at({0, 0, 0}), RegionSensor{.half_extent = vec3(0)});
  level.run(2);
  EXPECT_EQ(level.world.peek<RegionSensor>(all)->count, 32u);
  EXPECT_EQ(level.world.peek<RegionSensor>(none)->count, 0u);
  EXPECT_EQ(level.world.peek<RegionSensor>(flat)->count, 0u);
}

TEST(Pressure, OfAPatchIsTheLoadOfACollider) {
  // README: a floor of tiles reads the pressure patch by patch. On a bed between walls without
  // friction that is the weight of the bed over the floor's area.
  Level level;
  constexpr float kHalf = 0.15f;
  std::vector<Entity> tiles;
  for (int x = -1; x <= 1; ++x)
    for (int z = -1; z <= 1; ++z)
      tiles.push_back(level.world.spawn(at({0.3 * x, -0.5, 0.3 * z}),
                                        BoxCollider{.half_extent = {kHalf, 0.5f, kHalf}}, LoadSensor{}));
  for (int side = 0; side < 4; ++side) {
    const double s = side % 2 == 0 ? 0.95 : -0.95;
    level.world.spawn(at(side < 2 ? dvec3(s, 1, 0) : dvec3(0, 1, s)),
                      BoxCollider{.half_extent = side < 2 ? vec3(0.5f, 2, 3) : vec3(3, 2, 0.5f), .friction = 0});
  }
  const GrainBlock block{.count = {14, 16, 14}, .radius = 0.0254f, .radius_jitter = 0.25f};
  level.world.spawn(at({0, 0.62, 0}), block);
  // Sleepers on which those awake press carry a part of it that no sensor tells: keep all awake.
  level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(5), .acceleration = {0, -1e-3f, 0}, .wake_above = 0});
  level.run(400);
  double mass = 0;
  for (const auto& [entity, s] : level.seen()) mass += Level::massOf(s);
  std::vector<double> pressure(9);
  for (int tick = 0; tick < 30; ++tick) {
    level.run();
    for (size_t k = 0; k < 9; ++k)
      pressure[k] -= static_cast<double>(level.world.peek<LoadSensor>(tiles[k])->impulse.y) * 60 / 30 /
                     (4.0 * kHalf * kHalf);
  }
  const double want = mass * 9.81 / 0.81;
  double mean = 0;
  for (const double p : pressure) {
    mean += p / 9;
    EXPECT_NEAR(p, want, 0.25 * want);
  }
  EXPECT_NEAR(mean, want, 0.005 * want);
}

}  // namespace
}  // namespace scree::grains::test

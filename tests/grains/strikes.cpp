// Strikes: which contacts are told, with which impulse and speed, in which order.
#include "tests/grains/level.h"

namespace scree::grains::test {
namespace {

struct Told : Level {
  explicit Told(float least_impulse, float least_speed, int threads = 1) : Level(threads) {
    GrainStrikes& strikes = world.singleton<GrainStrikes>();
    strikes.least_impulse = least_impulse;
    strikes.least_speed = least_speed;
  }
  const GrainStrikes& strikes() { return world.singleton<const GrainStrikes>(); }
};

double massOf(float radius, float density = 1500) {
  return 4.0 / 3 * 3.14159265358979323846 * std::pow(static_cast<double>(radius), 3) * static_cast<double>(density);
}

TEST(Strikes, OfABallOnAFloor) {
  for (const dvec3 place : {dvec3(0, 0, 0), dvec3(1e6, -1e6, 1e6)}) {
    for (const float restitution : {0.0f, 0.5f, 1.0f}) {
      Told level(0, 1);
      grainField(level.world).damping = 0;
      grainField(level.world).origin = place;
      grainField(level.world).placed = true;
      const Entity floor = level.world.spawn(at(place + dvec3(0, -0.25, 0)), BoxCollider{.half_extent = {9, 0.25f, 9}});
      const Entity e = level.grain({0.5f, 2.1f, 0}, 0.1f, vec3(0), {1500, 0.5f, 0, restitution});
      // The whole of the impact: from the first strike on, until it flies or rests.
      double impulse = 0, speed = 0;
      size_t told = 0;
      for (int tick = 0; tick < 45; ++tick) {
        level.run();
        for (const GrainStrike& s : level.strikes().list) {
          EXPECT_EQ(s.a, e);
          EXPECT_EQ(s.b, floor);
          EXPECT_TRUE(s.collider);
          EXPECT_EQ(s.normal, vec3(0, 1, 0));
          EXPECT_LT(glm::length(s.position - place - dvec3(0.5, 0, 0)), 0.06);
          impulse += static_cast<double>(s.impulse);
          speed = std::max(speed, static_cast<double>(s.speed));
          ++told;
        }
      }
      const double v = std::sqrt(2 * 9.81 * 2);
      EXPECT_LE(told, 2u);
      EXPECT_NEAR(speed, v, 0.05);  // gravity of a substep: 0.04
      EXPECT_NEAR(impulse, massOf(0.1f) * v * (1 + static_cast<double>(restitution)), 0.03 * massOf(0.1f) * v);
    }
  }
}

TEST(Strikes, OfTwoGrains) {
  Told level(0, 0.5f);
  level.weightless();
  const Entity a = level.grain({-0.5f, 0, 0}, 0.1f, {3, 0, 0});
  const Entity b = level.grain({0.5f, 0, 0}, 0.2f, {-1, 0, 0});
  double impulse = 0;
  size_t told = 0;
  for (int tick = 0; tick < 30; ++tick) {
    level.run();
    for (const GrainStrike& s : level.strikes().list) {
      EXPECT_EQ(s.a, a);
      EXPECT_EQ(s.b, b);
      EXPECT_FALSE(s.collider);
      EXPECT_LT(glm::length(s.normal - vec3(-1, 0, 0)), 1e-5f);
      // They meet where the gap of 0.7 m closes at 4 m/s: the contact is at -0.4 + 3 t.
      EXPECT_NEAR(s.position.x, -0.4 + 3 * 0.7 / 4, 0.02);
      EXPECT_NEAR(s.speed, 4, 1e-4);
      impulse += static_cast<double>(s.impulse);
      ++told;
    }
  }
  const double m = massOf(0.1f), n = massOf(0.2f);
  EXPECT_EQ(told, 1u);
  EXPECT_NEAR(impulse, 4 * m * n / (m + n), 1e-3 * m * 4);
}

TEST(Strikes, LimitsLeaveOutWhatIsWeaker) {
  const double impulse = massOf(0.1f) * massOf(0.2f) / (massOf(0.1f) + massOf(0.2f)) * 4;
  const auto told = [&](float least_impulse, float least_speed) {
    Told level(least_impulse, least_speed);
    level.weightless();
    level.grain({-0.5f, 0, 0}, 0.1f, {3, 0, 0});
    level.grain({0.5f, 0, 0}, 0.2f, {-1, 0, 0});
    size_t count = 0;
    for (int tick = 0; tick < 30; ++tick) {
      level.run();
      count += level.strikes().list.size();
    }
    return count;
  };
  EXPECT_EQ(told(0, 3.99f), 1u);
  EXPECT_EQ(told(0, 4.01f), 0u);
  EXPECT_EQ(told(static_cast<float>(0.999 * impulse), 0), 1u);
  EXPECT_EQ(told(static_cast<float>(1.001 * impulse), 0), 0u);
  EXPECT_EQ(told(static_cast<float>(1.001 * impulse), 3.99f), 1u);
  for (const float nothing : {0.0f, -1.0f, kNan}) EXPECT_EQ(told(nothing, nothing), 0u);
  EXPECT_EQ(told(kInf, kInf), 0u);
}

TEST(Strikes, AddUpToTheLoads) {
  // With a limit that everything passes: what is told of a frictionless collider is its load.
  Told level(1e-9f, 0);
  level.world.singleton<GrainStrikes>().most = kMostStrikes;
  const Entity floor = level.world.spawn(at({0, -0.5, 0}), BoxCollider{.half_extent = {9, 0.5f, 9}, .friction = 0}, LoadSensor{});
  level.world.spawn(at({0, 1, 0}), GrainBlock{.count = {6, 6, 6}, .radius_jitter = 0.2f});
  size_t pairs = 0;
  for (int tick = 0; tick < 90; ++tick) {
    level.run();
    if (level.asleep() > 0) break;
    double sum = 0;
    for (const GrainStrike& s : level.strikes().list) {
      pairs += !s.collider;
      if (!s.collider) {
        ASSERT_LT(s.a.index, s.b.index);
        continue;
      }
      ASSERT_EQ(s.b, floor);
      sum += static_cast<double>(s.impulse);
    }
    const double load = -static_cast<double>(level.world.peek<LoadSensor>(floor)->impulse.y);
    ASSERT_NEAR(sum, load, 1e-4 * load + 1e-6) << tick;
    ASSERT_EQ(level.strikes().left_out, 0u);
  }
  EXPECT_GT(pairs, 1000u);
}

TEST(Strikes, OfPairsAreWhatEachGrainGains) {
  // Without friction and gravity: mass x change of velocity is the sum of a grain's strikes.
  Told level(1e-12f, 0, 2);
  level.weightless();
  level.world.singleton<GrainStrikes>().most = kMostStrikes;
  for (int k = 0; k < 216; ++k) {
    const auto draw = [&](uint64_t which) { return randomUnit(5, static_cast<uint64_t>(k), 0, which); };
    const vec3 cell(static_cast<float>(k % 6), static_cast<float>(k / 6 % 6), static_cast<float>(k / 36));
    level.grain((cell - 2.5f) * 0.13f, 0.04f + 0.02f * draw(0), -0.3f * (cell - 2.5f) + 0.1f * vec3(draw(1), draw(2), draw(3)),
                {1500, 0, 0, 0.5f});
  }
  size_t told = 0;
  for (int tick = 0; tick < 120; ++tick) {
    const auto before = level.seen();
    level.run();
    std::map<Entity, dvec3> gain;
    std::map<Entity, double> passed;
    for (const GrainStrike& s : level.strikes().list) {
      const dvec3 impulse = static_cast<double>(s.impulse) * dvec3(s.normal);
      gain[s.a] += impulse;
      gain[s.b] -= impulse;
      passed[s.a] += static_cast<double>(s.impulse);
      passed[s.b] += static_cast<double>(s.impulse);
      ++told;
    }
    for (const auto& [entity, s] : level.seen()) {
      const dvec3 change = Level::massOf(s) * (dvec3(s.velocity) - dvec3(before.at(entity).velocity));
      // The normal turns within a substep: by 2.6 m/s / 240 / 0.08 m at most.
      ASSERT_LT(glm::length(change - gain[entity]), 0.14 * passed[entity] + 1e-6) << tick;
    }
  }
  EXPECT_GT(told, 300u);
  setThreadCount(0);
}

TEST(Strikes, TheStrongestAreKept) {
  std::vector<GrainStrike> all;
  for (const uint32_t most : {kMostStrikes, 20u, 1u, 0u}) {
    Told level(0, 0.5f);
    level.world.singleton<GrainStrikes>().most = most;
    level.world.spawn(at({0, -0.5, 0}), BoxCollider{.half_extent = {9, 0.5f, 9}});
    level.world.spawn(at({0, 1.2, 0}), GrainBlock{.count = {10, 3, 10}, .radius_jitter = 0.5f});
    for (int tick = 0; tick < 120 && level.strikes().list.size() + level.strikes().left_out < 40; ++tick) level.run();
    const GrainStrikes& told = level.strikes();
    if (most == kMostStrikes) all = told.list;
    ASSERT_GE(all.size(), 40u);
    ASSERT_EQ(told.list.size(), std::min<size_t>(all.size(), most));
    EXPECT_EQ(told.left_out, all.size() - told.list.size());
    for (size_t k = 0; k < told.list.size(); ++k) {
      EXPECT_EQ(told.list[k].a, all[k].a);
      EXPECT_EQ(told.list[k].impulse, all[k].impulse);
      if (k > 0) {
        EXPECT_GE(told.list[k - 1].impulse, told.list[k].impulse);
      }
    }
  }
}

TEST(Strikes, NoneOfAHeapAtRestAndOneOfWhatFallsOnIt) {
  Told level(0, 1);
  level.heap({0, 0, 0}, {8, 2, 8});
  ASSERT_LT(level.sleep(), 3000);
  for (int k = 0; k < 20; ++k) {
    level.run();
    ASSERT_TRUE(level.strikes().list.empty());
  }
  const Entity e = level.grain({0, 1, 0}, 0.05f, {0, -5, 0});
  size_t told = 0;
  for (int tick = 0; tick < 60; ++tick) {
    level.run();
    for (const GrainStrike& s : level.strikes().list) {
      told += s.a == e || s.b == e;
      EXPECT_GT(s.speed, 1);
    }
  }
  EXPECT_GE(told, 1u);
  // When the grains have gone, so have the strikes.
  std::vector<Entity> all;
  level.world.query<With<Grain>>().each([&](Entity grain) { all.push_back(grain); });
  level.world.destroyMany(all);
  level.run(2);
  EXPECT_TRUE(level.strikes().list.empty());
}

}  // namespace
}  // namespace scree::grains::test

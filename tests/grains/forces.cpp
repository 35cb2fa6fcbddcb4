// Forces and blows against closed forms; who wakes by them and who sleeps on.
#include "modules/grains/forces.h"
#include "tests/grains/level.h"

namespace scree::grains::test {
namespace {

constexpr double kG = 9.81;

TEST(Force, UniformInItsBoxAndNowhereElse) {
  Level level;
  level.weightless();
  Transform turned = at({0, 0, 0});
  turned.rotation = glm::angleAxis(1.5707963f, vec3(0, 1, 0));  // local x is -z
  level.world.spawn(turned, GrainForce{.half_extent = {100, 1, 1}, .acceleration = {3, 0, 0}});
  const Entity small = level.grain({0, 0, 0}, 0.01f);
  const Entity large = level.grain({0.5f, 0.5f, -1}, 0.3f, {0, 0, 1});
  const Entity outside = level.grain({1.2f, 0, 0}, 0.05f, {0, 0, 1});
  level.run(120);
  const auto now = level.seen();
  EXPECT_NEAR(now.at(small).position.z, -0.5 * 3 * 4, 1e-4);
  EXPECT_NEAR(now.at(small).velocity.z, -6, 1e-4);
  EXPECT_NEAR(now.at(large).position.z, -1 + 2 - 0.5 * 3 * 4, 1e-4);
  EXPECT_EQ(now.at(outside).velocity, vec3(0, 0, 1));
  EXPECT_NEAR(now.at(outside).position.z, 2, 1e-4);
}

TEST(Force, RollsAGrainFromItsOnsetOn) {
  // Pushed with a on the flat it stays for a < mu_r g, and rolls with 5/7 (a - mu_r g) beyond.
  for (const double share : {0.5, 0.95, 1.05, 2.0}) {
    Level level;
    grainField(level.world).damping = 0;
    level.world.spawn(at({0, 0, 0}), PlaneCollider{.friction = 1, .rolling_friction = 0});
    const Entity e = level.grain({0, 0.05f, 0}, 0.05f, vec3(0), {1500, 1, 0.1f, 0});
    level.run(30);
    const double onset = 0.1 * kG, a = share * onset;
    level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(50), .acceleration = {static_cast<float>(a), 0, 0},
                                                .wake_above = 0});
    const double from = static_cast<double>(level.seen().at(e).position.x);
    level.run(60);
    const auto now = level.seen().at(e);
    const double want = share < 1 ? 0 : 5.0 / 7 * (a - onset);
    EXPECT_NEAR(now.velocity.x, want, 0.005 * want + 1e-3) << share;
    EXPECT_NEAR(static_cast<double>(now.position.x) - from, 0.5 * want, 0.01 * want + 1e-3) << share;
  }
}

TEST(Force, OrbitsKeepTheirEnergyAndTime) {
  // A circle around a Plummer sphere: v^2 = A s^2 d^2 / (d^2 + s^2)^1.5.
  constexpr double kA = 4, kS = 0.5, kD = 2;
  Level level;
  level.weightless();
  level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(10), .attraction = kA, .falloff = kS});
  const double speed = std::sqrt(kA * kS * kS * kD * kD / std::pow(kD * kD + kS * kS, 1.5));
  const Entity circle = level.grain({kD, 0, 0}, 0.05f, {0, 0, static_cast<float>(speed)});
  // And one that falls through the centre on a long loop.
  const Entity loop = level.grain({0, 3, 0}, 0.02f, {0.2f, 0, 0});
  const auto energy = [&](const Level::Seen& s) {
    const dvec3 x(s.position), v(s.velocity);
    return 0.5 * glm::dot(v, v) - kA * kS * kS / std::sqrt(glm::dot(x, x) + kS * kS);
  };
  const double circle_energy = energy(level.seen().at(circle)), loop_energy = energy(level.seen().at(loop));
  double turned = 0;
  dvec3 last(kD, 0, 0);
  for (int tick = 0; tick < 3600; ++tick) {
    level.run();
    const auto now = level.seen();
    const dvec3 x(now.at(circle).position);
    turned += std::atan2(last.x * x.z - last.z * x.x, last.x * x.x + last.z * x.z);
    last = x;
    ASSERT_NEAR(glm::length(x), kD, 2e-3);
    ASSERT_NEAR(energy(now.at(circle)), circle_energy, 1e-3 * std::abs(circle_energy));
    ASSERT_NEAR(energy(now.at(loop)), loop_energy, 0.01 * std::abs(loop_energy));
  }
  EXPECT_NEAR(turned, speed / kD * 60, 2e-3 * turned);
}

TEST(Force, Repels) {
  // Thrown out from distance d by a repeller: speed^2 / 2 is the potential that it left.
  Level level;
  level.weightless().bounds_max = vec3(1e6f);
  level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(1e6f), .attraction = -8, .falloff = 1});
  const Entity e = level.grain({0.5f, 0, 0});
  level.run(3000);
  const auto now = level.seen().at(e);
  const double x = static_cast<double>(now.position.x);
  const double want = std::sqrt(2 * 8 * (1 / std::sqrt(1.25) - 1 / std::sqrt(1 + x * x)));
  EXPECT_NEAR(now.velocity.x, want, 1e-3 * want);
}

TEST(Force, DragIsExponential) {
  for (const double drag : {0.1, 1.0, 5.0, 20.0}) {
    Level level;
    level.weightless();
    level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(200), .drag = static_cast<float>(drag),
                                                .flow = {2, 0, 1}});
    const Entity e = level.grain({0, 0, 0}, 0.05f, {-3, 4, 0});
    for (int tick = 1; tick <= 120; ++tick) {
      level.run();
      const double left = std::exp(-drag * tick / 60);
      const dvec3 want = dvec3(2, 0, 1) + left * dvec3(-5, 4, -1);
      // The scheme's error, x^2 / 6 of what is left to lose, is greatest at 1 / drag.
      const double x = drag / 240, allowed = 6.5 * 0.37 * x * x / 6 + 2e-4;
      ASSERT_LT(glm::length(dvec3(level.seen().at(e).velocity) - want), allowed) << drag << ' ' << tick;
    }
  }
}

TEST(Force, DragOfAnySizeOnlySlows) {
  for (const float drag : {1e2f, 1e4f, 1e6f}) {
    Level level;
    GrainField& field = grainField(level.world);
    field.damping = 0;
    // Three at a place: together they pull to the mean of their winds.
    for (const float flow : {1.0f, 2.0f, 6.0f})
      level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(200), .drag = drag, .flow = {flow, 0, 0}});
    const Entity e = level.grain({0, 0, 0}, 0.05f, {-300, 400, 0});
    float fastest = 500;
    for (int tick = 0; tick < 60; ++tick) {
      level.run();
      const vec3 v = level.seen().at(e).velocity;
      ASSERT_LE(glm::length(v), fastest + 1e-3f);
      fastest = std::max(glm::length(v), 3.1f);
    }
    const vec3 v = level.seen().at(e).velocity;
    EXPECT_NEAR(v.x, 3, 1e-3);
    EXPECT_NEAR(v.y, -9.81 / (3 * static_cast<double>(drag)), 1e-3);
  }
}

TEST(Force, TerminalSpeed) {
  Level level;
  grainField(level.world).damping = 0;
  level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(50), .drag = 4, .flow = {0, 1, 0}});
  const Entity e = level.grain({0, 0, 0});
  level.run(300);
  EXPECT_NEAR(level.seen().at(e).velocity.y, 1 - kG / 4, 1e-3);
}

TEST(Force, VortexTurnsAsItsProfile) {
  // With a strong drag grains move with the air.
  Transform tilted = at({0.25, 0.5, 0});
  tilted.rotation = glm::angleAxis(0.7f, glm::normalize(vec3(1, 0, 1)));
  const dvec3 axis(glm::mat3_cast(tilted.rotation)[1]);
  for (const double distance : {0.0, 0.2, 0.5, 1.0, 3.0}) {
    Level level;
    level.weightless();
    level.world.spawn(tilted, GrainForce{.half_extent = vec3(9), .falloff = 0.5f, .drag = 1e5f, .flow = {0, 1, 0},
                                         .swirl = 2});
    const dvec3 out = glm::normalize(glm::cross(axis, dvec3(0.3, 0.1, 0.9)));
    const Entity e = level.grain(vec3(tilted.position + distance * out - dvec3(0, 0, 0)));
    const dvec3 x = dvec3(level.seen().at(e).position) - tilted.position;
    level.run();
    const dvec3 v(level.seen().at(e).velocity);
    const double s = distance / 0.5;
    EXPECT_NEAR(glm::dot(v, axis), 1, 0.01);
    const dvec3 around = glm::cross(axis, out);
    EXPECT_NEAR(glm::dot(v, around), 2 * 2 * s / (1 + s * s), 0.05) << distance;
    EXPECT_GE(glm::dot(x, out), -1e-6);
  }
}

TEST(Force, PressesBouncyGrainsAgainstAWall) {
  Level level;
  level.weightless();
  level.world.spawn(at({1, 0, 0}), BoxCollider{.half_extent = {0.5f, 9, 9}});
  level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(20), .acceleration = {50, 0, 0}});
  const Entity e = level.grain({0.2f, 0, 0}, 0.05f, vec3(0), {1500, 0.5f, 0, 0.7f});
  level.run(240);
  for (int k = 0; k < 60; ++k) {
    level.run();
    EXPECT_NEAR(level.seen().at(e).position.x, 0.45, 2e-3);
  }
}

TEST(Force, WakesWhomItMovesAndNobodyElse) {
  Level level;
  level.heap({0, 0, 0}, {12, 3, 12});
  ASSERT_LT(level.sleep(), 3000);
  const auto before = level.seen();
  // Too weak: nobody wakes, the solver does not even run.
  const Entity weak = level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(9), .acceleration = {0.9f, 0, 0}});
  const Entity breeze = level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(9), .drag = 0.3f, .flow = {3, 0, 0}});
  level.run(60);
  EXPECT_EQ(level.world.singleton<const GrainStats>().visited, 0u);
  EXPECT_TRUE(level.seen() == before);
  level.world.destroy(weak);
  level.world.destroy(breeze);
  // Strong, and over a part.
  const Entity strong = level.world.spawn(at({0.5, 0, 0}), GrainForce{.half_extent = {0.25f, 9, 9}, .acceleration = {0, 0, 1.5f}});
  level.run();
  size_t woken = 0, far = 0;
  for (const auto& [entity, s] : level.seen()) {
    if (std::abs(before.at(entity).position.x - 0.5f) <= 0.2499f) {
      ASSERT_FALSE(s.asleep);
      ++woken;
    }
    if (before.at(entity).position.x < -0.1f) {
      ASSERT_TRUE(s.asleep);
      ASSERT_TRUE(s == before.at(entity));
      ++far;
    }
  }
  EXPECT_GT(woken, 50u);
  EXPECT_GT(far, 100u);
  // As long as it lasts, none in it falls asleep; afterwards all do.
  level.run(300);
  for (const auto& [entity, s] : level.seen())
    ASSERT_FALSE(s.asleep && std::abs(s.position.x - 0.5f) < 0.25f);
  level.world.find<GrainForce>(strong)->on = false;
  EXPECT_LT(level.sleep(), 3000);
}

TEST(Force, LetsNobodyItMovesFallAsleep) {
  // Pressed down by a twentieth of their weight: at rest, and balanced well enough to sleep.
  Level level;
  level.heap({0, 0, 0}, {6, 3, 6});
  const Entity e = level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(9), .acceleration = {0, -0.5f, 0},
                                                               .wake_above = 0.2f});
  for (int tick = 0; tick < 600; ++tick) {
    level.run();
    ASSERT_EQ(level.asleep(), 0u) << tick;
  }
  level.world.find<GrainForce>(e)->wake_above = 1;
  EXPECT_LT(level.sleep(), 3000);
}

TEST(Force, WakesSleepersThatItReachesLater) {
  // Nobody but the force changes: it moves onto them, then only its strength rises.
  Level level;
  level.heap({0, 0, 0}, {4, 2, 4});
  ASSERT_LT(level.sleep(), 3000);
  const Entity e = level.world.spawn(at({30, 0, 0}), GrainForce{.half_extent = vec3(5), .acceleration = {0.5f, 0, 0}});
  level.run(3);
  level.world.find<Transform>(e)->position.x = 0;
  level.run(3);
  EXPECT_EQ(level.asleep(), 32u);
  level.world.find<GrainForce>(e)->acceleration.x = 1.01f;
  level.run(1);
  EXPECT_EQ(level.asleep(), 0u);
}

TEST(Force, BadOnesDoNothing) {
  const auto refused = [](GrainForce force, Transform transform = {}) {
    Level level;
    level.weightless();
    const Entity e = level.grain({0.1f, 0, 0});
    level.world.spawn(transform, force);
    level.run(5);
    EXPECT_EQ(level.seen().at(e).velocity, vec3(0));
  };
  const vec3 push(1, 0, 0);
  refused({.half_extent = {kNan, 1, 1}, .acceleration = push});
  refused({.half_extent = vec3(0), .acceleration = push});
  refused({.half_extent = vec3(-1), .acceleration = push});
  refused({.acceleration = {kNan, 0, 0}});
  refused({.acceleration = {1e9f, 0, 0}});
  refused({.attraction = kInf});
  refused({.acceleration = push, .falloff = 0});
  refused({.acceleration = push, .drag = -1});
  refused({.drag = 1, .flow = {kNan, 0, 0}});
  refused({.drag = 1, .swirl = kNan});
  refused({.acceleration = push, .wake_above = kNan});
  refused({.on = false, .acceleration = push});
  refused({.acceleration = push}, at({std::numeric_limits<double>::infinity(), 0, 0}));
  Transform huge;
  huge.scale = vec3(1e33f);
  refused({.half_extent = vec3(1e6f), .acceleration = push}, huge);
  // The strongest that is allowed: finite, and lost beyond the bounds.
  Level level;
  level.grain({0.1f, 0.2f, 0.3f});
  level.world.spawn(Transform{}, GrainForce{.half_extent = vec3(1e9f), .acceleration = vec3(1e5f), .attraction = -1e5f,
                                            .falloff = 1e-3f, .drag = 1e-30f, .swirl = 1e4f, .wake_above = 0});
  level.run(200);
  EXPECT_EQ(level.count(), 0u);
  EXPECT_EQ(grainField(level.world).lost, 1u);
}

TEST(Push, OfTinyAndHugeDragIsFinite) {
  for (const float drag : {0.0f, 1e-38f, 1e-20f, 1e-6f, 1.0f, 1e6f}) {
    const Force force{.half = vec3(9), .acceleration = {0, -2, 0}, .drag = drag, .flow = {3, 0, 0}};
    const std::vector<Force> forces(8, force);
    const vec3 push = pushOf(forces, vec3(0.5f), vec3(1, 1, 1), vec3(0, -1, 0), 0.1f);
    EXPECT_TRUE(std::isfinite(push.x + push.y + push.z)) << drag;
    EXPECT_NEAR(push.y, drag < 1e-5f ? -1.6 : static_cast<double>(push.y), 1e-4);
  }
}

// ---- blows

// Velocity that a blow gives, in double.
dvec3 kick(dvec3 x, double radius, double strength, double grain_radius, double density) {
  const double d = glm::length(x);
  if (d >= radius || d == 0) return dvec3(0);
  const double pi = 3.14159265358979323846;
  const double impulse = strength * (1 - d / radius) * pi * grain_radius * grain_radius;
  return x / d * (impulse / (4 * pi / 3 * grain_radius * grain_radius * grain_radius * density));
}

TEST(Blow, MomentumIsTheSumOfItsImpulses) {
  for (const float strength : {300.0f, -300.0f}) {
    Level level;
    level.weightless();
    for (int k = 0; k < 200; ++k) {
      const auto draw = [&](uint64_t which) { return randomUnit(3, static_cast<uint64_t>(k), 0, which); };
      const vec3 cell(static_cast<float>(k % 6), static_cast<float>(k / 6 % 6), static_cast<float>(k / 36));
      level.grain((cell - 2.5f) * 0.5f + 0.1f * vec3(draw(0), draw(1), draw(2)), 0.02f + 0.05f * draw(3), vec3(0),
                  {500 + 3000 * draw(4)});
    }
    const Entity centre = level.grain({0.25f, 0.25f, 1.75f});
    const dvec3 where(0.25, 0.25, 1.75);
    const auto before = level.seen();
    impulseInSphere(level.world, where, 1.7f, strength);
    const size_t entities = level.world.entityCount();
    level.run();
    EXPECT_EQ(level.world.entityCount(), entities - 1);
    dvec3 want(0);
    size_t moved = 0;
    for (const auto& [entity, s] : level.seen()) {
      const Level::Seen& old = before.at(entity);
      const dvec3 v = kick(dvec3(old.position) - where, 1.7, static_cast<double>(strength),
                           static_cast<double>(old.radius), static_cast<double>(old.density));
      EXPECT_LT(glm::length(dvec3(s.velocity) - v), 1e-5 * (1 + glm::length(v)));
      want += Level::massOf(old) * v;
      moved += glm::length(v) > 0;
    }
    EXPECT_GT(moved, 40u);
    EXPECT_LT(moved, 150u);
    EXPECT_EQ(level.seen().at(centre).velocity, vec3(0));
    EXPECT_LT(glm::length(level.momentum() - want), 1e-6 * (glm::length(want) + 1));
    // Once only.
    const dvec3 after = level.momentum();
    level.run(5);
    EXPECT_LT(glm::length(level.momentum() - after), 1e-5 * (glm::length(after) + 1));
  }
}

TEST(Blow, InTheMiddleOfASymmetricCloudLeavesItsMomentum) {
  Level level;
  level.weightless();
  double each = 0;
  for (int sign = 0; sign < 8; ++sign) {
    for (int axis = 0; axis < 3; ++axis) {
      vec3 p((sign & 1) != 0 ? 1.f : -1.f, (sign & 2) != 0 ? 1.f : -1.f, (sign & 4) != 0 ? 1.f : -1.f);
      p[axis] *= 0.5f;
      level.grain(p);
    }
  }
  impulseInSphere(level.world, {0, 0, 0}, 3, 500);
  level.run();
  for (const auto& [entity, s] : level.seen()) each += Level::massOf(s) * static_cast<double>(glm::length(s.velocity));
  EXPECT_GT(each, 10);
  EXPECT_LT(glm::length(level.momentum()), 1e-6 * each);
}

TEST(Blow, WakesAHeapWithinItsReachOnly) {
  Level level;
  level.heap({1000000, 0, -1000000}, {14, 3, 14});
  ASSERT_LT(level.sleep(), 3000);
  const auto before = level.seen();
  const dvec3 origin = grainField(level.world).origin;
  const dvec3 where = dvec3(1000000, -0.1, -1000000);
  impulseInSphere(level.world, where, 0.5f, 300);
  level.run();
  size_t woken = 0, far = 0, up = 0;
  for (const auto& [entity, s] : level.seen()) {
    const double d = glm::length(origin + dvec3(before.at(entity).position) - where);
    if (d < 0.499) {
      EXPECT_FALSE(s.asleep);
      ++woken;
      up += s.velocity.y > 0.5f;
    }
    if (d > 0.9) {
      EXPECT_TRUE(s == before.at(entity));
      ++far;
    }
  }
  EXPECT_GT(woken, 50u);
  EXPECT_GT(up, 30u);
  EXPECT_GT(far, 100u);
  level.sleep();
  EXPECT_EQ(level.asleep(), level.count());
}

// Without a grain no step uses blows and forces up.
TEST(Blow, StrikesNobodyWhoComesLater) {
  Level level;
  level.weightless();
  impulseInSphere(level.world, {0, 0, 0}, 2, 300);
  const Entity wind = level.world.spawn(at({0, 0, 0}), GrainForce{.acceleration = vec3(5, 0, 0)});
  level.run(3);
  level.world.destroy(wind);
  level.run(3);
  const Entity late = level.grain({0.5f, 0, 0}, 0.1f);
  level.run(2);
  EXPECT_EQ(level.seen().at(late).velocity, vec3(0));
}

TEST(Blow, ComponentGoesAndTheEntityStays) {
  Level level;
  level.weightless();
  const Entity g = level.grain({1, 0, 0});
  const Entity e = level.world.spawn(at({0, 0, 0}), GrainBlow{.radius = 2, .strength = 100});
  level.run(3);
  EXPECT_TRUE(level.world.alive(e));
  EXPECT_FALSE(level.world.has<GrainBlow>(e));
  EXPECT_NEAR(level.seen().at(g).velocity.x, 100 * 0.5 * 0.75 / (0.05 * 1500), 1e-4);
  EXPECT_EQ(level.runs("grains.push"), 1u);
}

TEST(Blow, BoundedAndRefused) {
  Level level;
  level.weightless().bounds_max = vec3(1e5f);
  const Entity fast = level.grain({1, 0, 0}, 1e-3f);
  impulseInSphere(level.world, {0, 0, 0}, 2, 1e12f);
  level.run();
  EXPECT_NEAR(level.seen().at(fast).velocity.x, kMostBlow, 0.1);
  Level calm;
  calm.weightless();
  const Entity still = calm.grain({0.5f, 0, 0});
  for (const float radius : {kNan, -1.0f, kInf, 0.0f}) impulseInSphere(calm.world, {0, 0, 0}, radius, 100);
  for (const float strength : {kNan, kInf, 1e30f}) impulseInSphere(calm.world, {0, 0, 0}, 1, strength);
  impulseInSphere(calm.world, {0, std::numeric_limits<double>::quiet_NaN(), 0}, 1, 100);
  impulseInSphere(calm.world, {1e300, 0, 0}, 1, 100);
  const size_t entities = calm.world.entityCount();
  calm.run();
  EXPECT_EQ(calm.world.entityCount(), entities - 9);
  EXPECT_EQ(calm.seen().at(still).velocity, vec3(0));
}

}  // namespace
}  // namespace scree::grains::test

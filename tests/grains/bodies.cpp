// Rigid bodies in a world: motion against closed forms and double precision, rest, contact with grains.
#include <gtest/gtest.h>

#include <glm/gtc/quaternion.hpp>

#include "tests/grains/body_level.h"

namespace scree::grains::test {
namespace {

TEST(Body, FallsFreely) {
  BodyLevel level;
  const Entity e = level.box({0, 100, 0}, vec3(0.3f));
  level.run(120);
  EXPECT_NEAR(level.place(e).position.y, 100 - 0.5 * kG * 4, 1e-3);
  EXPECT_NEAR(level.body(e).velocity.y, -2 * kG, 1e-4);
}

// Torque-free Euler equations in double precision, fourth order, 20 steps a substep.
TEST(Body, SpinsAsEulerSays) {
  BodyLevel level;
  level.weightless();
  const vec3 half(0.1f, 0.25f, 0.4f);
  const vec3 start(0.3f, 4.0f, 0.5f);  // about the middle axis: it tumbles
  const Entity e = level.box({0, 5, 0}, half, {.density = 700, .spin = start});
  const dvec3 h(half);
  const dvec3 inertia = dvec3(h.y * h.y + h.z * h.z, h.x * h.x + h.z * h.z, h.x * h.x + h.y * h.y);  // x m/3
  dvec3 w(start);
  glm::dquat q(1, 0, 0, 0);
  struct Rate {
    dvec3 w;
    glm::dquat q;
  };
  const auto rate = [&](const dvec3& spin, const glm::dquat& at) {
    return Rate{dvec3((inertia.y - inertia.z) * spin.y * spin.z, (inertia.z - inertia.x) * spin.z * spin.x,
                      (inertia.x - inertia.y) * spin.x * spin.y) / inertia,
                0.5 * (at * glm::dquat(0, spin.x, spin.y, spin.z))};
  };
  const dvec3 momentum = inertia * w;  // world axes, at the start
  double worst = 0, off = 0;
  for (int tick = 0; tick < 600; ++tick) {
    const double step = 1.0 / 60 / 40;
    for (int k = 0; k < 40; ++k) {
      const Rate a = rate(w, q), b = rate(w + 0.5 * step * a.w, q + 0.5 * step * a.q),
                 c = rate(w + 0.5 * step * b.w, q + 0.5 * step * b.q), d = rate(w + step * c.w, q + step * c.q);
      w += step / 6 * (a.w + 2.0 * b.w + 2.0 * c.w + d.w);
      q = glm::normalize(q + step / 6 * (a.q + 2.0 * b.q + 2.0 * c.q + d.q));
    }
    level.run();
    const glm::dmat3 turned = glm::mat3_cast(glm::dquat(level.place(e).rotation));
    const dvec3 now = turned * (inertia * (dvec3(level.body(e).spin) * turned));
    worst = std::max(worst, glm::length(now - momentum) / glm::length(momentum));
    off = std::max(off, 1 - std::abs(glm::dot(glm::dquat(level.place(e).rotation), q)));
  }
  std::printf("angular momentum off by %.2e, orientation by %.2e rad\n", worst, 2 * std::sqrt(2 * off));
  EXPECT_LT(worst, 1e-4);
  EXPECT_LT(2 * std::sqrt(2 * off), 0.02);
}

TEST(Body, SlidesUntilFrictionStopsIt) {
  for (const float friction : {0.2f, 0.5f}) {
    BodyLevel level;
    level.floor(friction);
    const Entity e = level.box({0, 0.1, 0}, {0.3f, 0.1f, 0.3f}, {.velocity = {4, 0, 0}}, friction);
    level.run(400);
    const double way = 16 / (2 * static_cast<double>(friction) * kG);
    std::printf("slides %.4f m of %.4f\n", level.place(e).position.x, way);
    EXPECT_NEAR(level.place(e).position.x / way, 1, 0.005);
    EXPECT_TRUE(level.sleeps(e));
  }
}

TEST(Body, BallRollsDownAnIncline) {
  BodyLevel level;
  const double angle = 0.3;
  Transform ramp;
  ramp.rotation = glm::angleAxis(static_cast<float>(-angle), vec3(0, 0, 1));  // falls towards +x
  level.world.spawn(ramp, PlaneCollider{.friction = 0.8f});
  const dvec3 normal(std::sin(angle), std::cos(angle), 0), along(std::cos(angle), -std::sin(angle), 0);
  RigidBody body;
  body.damping = 0;
  const Entity e = level.world.spawn(at(normal * 0.2), SphereCollider{.radius = 0.2f, .friction = 0.8f}, body);
  level.run(120);
  const double way = glm::dot(level.place(e).position, along), want = 0.5 * 5.0 / 7 * kG * std::sin(angle) * 4;
  std::printf("rolls %.4f m of %.4f\n", way, want);
  EXPECT_NEAR(way / want, 1, 0.005);
}

TEST(Body, TipsOrSlidesAtTheRightAngle) {
  // Half extents 0.2 and 0.4: it tips where tan > 1/2; friction 0.3 slides where tan > 0.3.
  struct Case {
    double angle;
    float friction;
    bool tips, slides;
  };
  const double tip = std::atan(0.5), slide = std::atan(0.3);
  for (const Case& c : {Case{tip - 0.02, 1, false, false}, Case{tip + 0.02, 1, true, false},
                        Case{slide - 0.01, 0.3f, false, false}, Case{slide + 0.02, 0.3f, false, true}}) {
    BodyLevel level;
    Transform ramp;
    ramp.rotation = glm::angleAxis(static_cast<float>(-c.angle), vec3(0, 0, 1));
    level.world.spawn(ramp, PlaneCollider{.friction = c.friction});
    const dvec3 normal(std::sin(c.angle), std::cos(c.angle), 0);
    const Entity e = level.box(normal * 0.4, {0.2f, 0.4f, 0.2f}, {}, c.friction);
    level.world.find<Transform>(e)->rotation = ramp.rotation;
    level.run(240);
    const double up = glm::dot(dvec3(level.place(e).rotation * vec3(0, 1, 0)), normal);
    const double way = glm::length(level.place(e).position - normal * 0.4);
    EXPECT_EQ(up < 0.9, c.tips) << c.angle << " up " << up;
    if (!c.tips) {
      EXPECT_EQ(way > 0.01, c.slides) << c.angle << " went " << way;
    }
  }
}

dvec3 cross(dvec3 a, dvec3 b) { return glm::cross(a, b); }

TEST(Body, ExchangesMomentumWithGrainsExactly) {
  for (const float density : {50.0f, 1500.0f}) {
    BodyLevel level;
    level.weightless().substeps = 16;
    const vec3 half(0.15f, 0.1f, 0.25f);
    const Entity e = level.box({0, 0, 0}, half, {.density = density, .velocity = {0.1f, 0, 0}, .spin = {0.5f, 1, 0}});
    for (int x = 0; x < 4; ++x)
      for (int y = 0; y < 4; ++y)
        for (int z = 0; z < 4; ++z) {
          const vec3 p = 0.3f * (vec3(x, y, z) - 1.5f) + vec3(0, 0.9f, 0);
          level.grain(p, 0.05f, vec3(0, -1.5f, 0) - 0.3f * p, {1000, 0.4f, 0, 0});
        }
    const dvec3 h(half);
    const double mass = 8 * h.x * h.y * h.z * static_cast<double>(density);
    const dvec3 inertia = mass / 3 * dvec3(h.y * h.y + h.z * h.z, h.x * h.x + h.z * h.z, h.x * h.x + h.y * h.y);
    const auto sums = [&](dvec3& linear, dvec3& angular, double& scale) {
      linear = angular = dvec3(0);
      scale = 0;
      for (const auto& [entity, s] : level.seen()) {
        const double m = Level::massOf(s), r = static_cast<double>(s.radius);
        linear += m * dvec3(s.velocity);
        scale += m * glm::length(dvec3(s.velocity));
        angular += m * cross(dvec3(s.position), dvec3(s.velocity)) + 0.4 * m * r * r * dvec3(s.spin);
      }
      const dvec3 v(level.body(e).velocity), p = level.place(e).position - grainField(level.world).origin;
      const glm::dmat3 turned = glm::mat3_cast(glm::dquat(level.place(e).rotation));
      linear += mass * v;
      angular += mass * cross(p, v) + turned * (inertia * (dvec3(level.body(e).spin) * turned));
    };
    dvec3 p0, l0, p1, l1;
    double scale, now;
    sums(p0, l0, scale);
    const float speed_before = glm::length(level.body(e).velocity);
    level.run(90);
    sums(p1, l1, now);
    std::printf("momentum off by %.2e, angular by %.2e\n", glm::length(p1 - p0) / scale, glm::length(l1 - l0) / glm::length(l0));
    EXPECT_GT(glm::length(level.body(e).velocity), speed_before + 0.1f);  // it was hit
    EXPECT_LT(glm::length(p1 - p0) / scale, 1e-5);
    // Overlaps that are undone move mass without an impulse: against the size of what is exchanged.
    EXPECT_LT(glm::length(l1 - l0) / (0.2 * scale), 2e-4);
  }
}

// One strike, off the centre; they bounce apart, so no overlap is undone and all that changes hands is one
// impulse.
TEST(Body, OneStrikeKeepsAngularMomentum) {
  double worst = 0;
  for (uint64_t k = 0; k < 20; ++k) {
    BodyLevel level;
    level.weightless();
    const vec3 half(0.15f, 0.1f, 0.25f);
    const Entity e = level.box({0, 0, 0}, half, {.density = 400, .spin = {0.2f, -0.3f, 0.1f}});
    const auto random = [&](uint64_t which) { return 2 * randomUnit(21, k, 0, which) - 1; };
    const vec3 from = 0.8f * glm::normalize(vec3(random(0), random(1), random(2)));
    const vec3 aim = 0.8f * half * vec3(random(3), random(4), random(5));
    const Entity grain = level.grain(from, 0.05f, 3.0f * glm::normalize(aim - from), {1500, 0.5f, 0, 0.5f});
    const dvec3 h(half);
    const double mass = 8 * h.x * h.y * h.z * 400, radius = 0.05f;
    const dvec3 inertia = mass / 3 * dvec3(h.y * h.y + h.z * h.z, h.x * h.x + h.z * h.z, h.x * h.x + h.y * h.y);
    const auto momentum = [&] {
      const Level::Seen s = level.seen()[grain];
      const double m = Level::massOf(s);
      const glm::dmat3 turned = glm::mat3_cast(glm::dquat(level.place(e).rotation));
      const dvec3 p = level.place(e).position - grainField(level.world).origin;
      return m * glm::cross(dvec3(s.position), dvec3(s.velocity)) + 0.4 * m * radius * radius * dvec3(s.spin) +
             mass * glm::cross(p, dvec3(level.body(e).velocity)) +
             turned * (inertia * (dvec3(level.body(e).spin) * turned));
    };
    const dvec3 before = momentum();
    const double struck = Level::massOf(level.seen()[grain]) * 3 * 0.25;  // impulse x the longest arm
    level.run(40);
    EXPECT_GT(glm::length(level.body(e).velocity), 0.01f) << k;
    worst = std::max(worst, glm::length(momentum() - before) / struck);
  }
  std::printf("angular momentum off by %.2e of what was struck\n", worst);
  EXPECT_LT(worst, 2e-4);
}

TEST(Body, StackStandsAndSleeps) {
  BodyLevel level;
  const Entity ground = level.floor();
  std::vector<Entity> stack;
  for (int k = 0; k < 5; ++k) stack.push_back(level.box({0.01 * (k % 2), 0.2 + 0.402 * k, 0}, vec3(0.2f)));
  level.run(600);
  const double mass = 5 * 0.4 * 0.4 * 0.4 * 500;
  for (int k = 0; k < 5; ++k) {
    const dvec3 p = level.place(stack[static_cast<size_t>(k)]).position;
    EXPECT_NEAR(p.y, 0.2 + 0.4 * k, 0.004) << k;
    EXPECT_NEAR(p.x, 0.01 * (k % 2), 0.004) << k;
    EXPECT_TRUE(level.sleeps(stack[static_cast<size_t>(k)])) << k;
  }
  EXPECT_NEAR(level.load(ground) / mass, 1, 0.003);
  const uint64_t solved = level.world.singleton<const BodyStats>().solved;
  const Transform before = level.place(stack[4]);
  level.run(60);
  EXPECT_EQ(level.world.singleton<const BodyStats>().solved, solved);  // nothing is done for sleepers
  EXPECT_EQ(level.place(stack[4]).position, before.position);
  // Without the lowest the others fall.
  level.world.destroy(stack[0]);
  level.run(120);
  EXPECT_LT(level.place(stack[4]).position.y, 1.5);
}

TEST(Body, RestsOnABedOfGrainsAndAllSleeps) {
  BodyLevel level;
  GrainBlock block;
  block.count = {10, 4, 10};
  block.radius_jitter = 0.2f;
  block.rolling_friction = 0.05f;
  level.world.spawn(at({0, 0.3, 0}), block);
  const Entity ground = level.floor(0.7f);
  std::vector<Entity> walls;
  for (const double side : {-1.0, 1.0}) {
    walls.push_back(level.world.spawn(at({side * 1.0, 0.5, 0}), BoxCollider{.half_extent = {0.4f, 1, 2}}, LoadSensor{}));
    walls.push_back(level.world.spawn(at({0, 0.5, side * 1.0}), BoxCollider{.half_extent = {2, 1, 0.4f}}, LoadSensor{}));
  }
  const Entity e = level.box({0, 1.0, 0}, {0.2f, 0.15f, 0.2f}, {.density = 1000});
  int ticks = 0;
  for (; ticks < 3000; ++ticks) {
    level.run();
    const GrainStats& stats = level.world.singleton<const GrainStats>();
    if (stats.asleep == stats.grains && level.sleeps(e)) break;
  }
  EXPECT_LT(ticks, 3000) << level.world.singleton<const GrainStats>().asleep << " grains, body " << level.sleeps(e);
  double mass = 0.4 * 0.3 * 0.4 * 1000;
  for (const auto& [entity, s] : level.seen()) mass += Level::massOf(s);
  level.run(2);
  double borne = level.load(ground);
  for (const Entity wall : walls) borne += level.load(wall);
  std::printf("floor and walls bear %.3f kg of %.3f after %d ticks\n", borne, mass, ticks);
  EXPECT_NEAR(borne / mass, 1, 0.003);
  const uint64_t solved = level.world.singleton<const BodyStats>().solved;
  level.run(30);
  EXPECT_EQ(level.world.singleton<const BodyStats>().solved, solved);
  EXPECT_EQ(level.world.singleton<const GrainStats>().visited, 0u);
}

TEST(Body, ScaleReadsTheWeight) {
  BodyLevel level;
  RigidBody plate;
  plate.mass = 2;
  BodySlider spring;
  spring.stiffness = 4000;
  spring.resistance = 200;
  const Entity e = level.world.spawn(at({0, 0.5, 0}), BoxCollider{.half_extent = {0.5f, 0.05f, 0.5f}, .friction = 0.9f}, plate, spring);
  double mass = 2;
  for (int x = 0; x < 5; ++x)
    for (int z = 0; z < 5; ++z) {
      level.grain({-0.3f + 0.15f * static_cast<float>(x), 0.65f, -0.3f + 0.15f * static_cast<float>(z)}, 0.05f, vec3(0), {2000, 0.5f, 0.1f, 0});
    }
  for (const auto& [entity, s] : level.seen()) mass += Level::massOf(s);
  level.run(400);
  EXPECT_EQ(level.count(), 25u);
  const double travel = -static_cast<double>(level.world.peek<BodySlider>(e)->travel);
  std::printf("scale reads %.4f kg of %.4f; asleep %d, grains asleep %zu\n", travel * 4000 / kG, mass, level.sleeps(e), level.asleep());
  EXPECT_NEAR(travel * 4000 / kG / mass, 1, 0.005);
}

// Clumps meet bodies with each of their spheres.
TEST(Body, ScaleReadsTheWeightOfClumps) {
  BodyLevel level;
  RigidBody plate;
  plate.mass = 2;
  const Entity e = level.world.spawn(at({0, 0.5, 0}), BoxCollider{.half_extent = {0.5f, 0.05f, 0.5f}, .friction = 0.9f}, plate,
                                     BodySlider{.stiffness = 4000, .resistance = 200});
  level.world.spawn(at({0, 0.68, 0}), GrainBlock{.count = {3, 1, 3}, .radius = 0.05f, .density = 2000, .rolling_friction = 0.1f},
                    ClumpShape{.name = "bean"});
  level.run(400);
  double mass = 2;
  for (const auto& [entity, s] : level.seen()) mass += Level::massOf(s);
  EXPECT_EQ(level.count(), 18u);
  const double read = -static_cast<double>(level.world.peek<BodySlider>(e)->travel) * 4000 / kG;
  std::printf("scale reads %.4f kg of %.4f\n", read, mass);
  EXPECT_NEAR(read / mass, 1, 0.005);
}

TEST(Body, DoesNotTunnel) {
  for (const float density : {100.0f, 5000.0f}) {
    BodyLevel level;
    level.floor(0.5f, {20, 0.05f, 20});
    const Entity a = level.box({0, 3, 0}, {0.1f, 0.2f, 0.15f}, {.density = density, .velocity = {0, -50, 0}, .spin = {9, 5, 3}});
    const Entity b = level.box({4, 3, 0}, {0.3f, 0.01f, 0.3f}, {.density = density, .velocity = {0, -50, 0}, .spin = {30, 0, 8}});
    const Entity ball = level.world.spawn(at({8, 3, 0}), SphereCollider{.radius = 0.1f}, RigidBody{.velocity = {0, -50, 0}});
    level.run(300);
    for (const Entity e : {a, b, ball}) EXPECT_GT(level.place(e).position.y, 0) << e.index;
  }
}

}  // namespace
}  // namespace scree::grains::test

// The rules without a window: headings, walking, edges, pause, restart, winning and losing.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "engine/core/file.h"
#include "engine/core/random.h"
#include "game/rules/game.h"
#include "game/rules/ground.h"
#include "game/rules/heading.h"
#include "game/rules/rules.h"
#include "modules/grains/grains.h"
#include "modules/overlay/overlay.h"
#include "modules/scene/scene.h"
#include "tests/game/support/program.h"

namespace scree::hourglass {
namespace {

namespace fs = std::filesystem;

// A 6 m x 6 m terrace whose top is y = 0, a creature in its middle, and what `nodes` adds.
fs::path writeLevel(const std::string& name, const std::string& nodes = "") {
  const fs::path path = scratchFolder("rules_" + name) / (name + ".gltf");
  std::ofstream(path) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1)"
                      << (nodes.empty() ? "" : ", 2") << R"(]}], "nodes": [
    {"name": "terrace", "translation": [0, -0.5, 0],
     "extras": {"BoxCollider": {"half_extent": [3, 0.5, 3]}}},
    {"name": "beast", "extras": {"Creature": {}}})"
                      << (nodes.empty() ? "" : ",\n") << nodes << "]}";
  return path;
}

std::unique_ptr<App> open(const fs::path& level) {
  Result<std::unique_ptr<App>> app = openGame({.threads = 1}, level);
  EXPECT_TRUE(app.ok()) << app.error();
  return app.ok() ? std::move(*app) : nullptr;
}

struct Input {
  float x = 0, y = 0;
  bool pause = false, restart = false;
};

void tick(App& app, const Input& input, int count = 1) {
  const Controls controls = app.world().singleton<const Controls>();
  for (int i = 0; i < count; ++i) {
    std::array<int16_t, kMaxActions> values{};
    values[controls.move_x] = quantise(input.x);
    values[controls.move_y] = quantise(input.y);
    values[controls.pause] = input.pause ? kFullValue : 0;
    values[controls.restart] = input.restart ? kFullValue : 0;
    app.world().singleton<ActionState>().begin(values);
    app.tick();
  }
}

Transform beast(App& app) {
  Transform found;
  app.world().query<const Transform, With<Creature>>().each(
      [&](const Transform& transform) { found = transform; });
  return found;
}

TEST(Heading, TurnsByTheAngle) {
  for (int i = -100; i <= 100; ++i) {
    const float angle = static_cast<float>(i) * 0.002f;
    const vec2 turned = turn({0, 1}, angle);
    const double exact = 2 * std::atan(angle / 2.0);
    EXPECT_NEAR(turned.x, std::sin(exact), 2e-7);
    EXPECT_NEAR(turned.y, std::cos(exact), 2e-7);
  }
}

TEST(Heading, TurnsTowardsTheGoalTheShorterWayAndArrives) {
  for (uint64_t i = 0; i < 500; ++i) {
    const double from = randomUnit(1, i, 0, 0) * 6.28, to = randomUnit(1, i, 0, 1) * 6.28;
    vec2 heading{static_cast<float>(std::sin(from)), static_cast<float>(std::cos(from))};
    const vec2 goal{static_cast<float>(std::sin(to)), static_cast<float>(std::cos(to))};
    const double angle = std::abs(std::remainder(to - from, 2 * M_PI));
    int steps = 0;
    for (; steps < 200 && glm::length(heading - goal) > 1e-6f; ++steps)
      heading = turnTowards(heading, goal, 0.05f);
    EXPECT_LE(steps, static_cast<int>(angle / 0.0499) + 2) << from << " to " << to;
    EXPECT_LT(glm::length(heading - goal), 1e-6f);
  }
}

TEST(Heading, RotationTurnsForwardIntoTheHeading) {
  for (int i = 0; i <= 720; ++i) {
    const double angle = i * M_PI / 360;
    const vec2 heading{static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle))};
    const quat rotation = rotationFromHeading(heading);
    const vec3 forward = rotation * vec3(0, 0, 1);
    EXPECT_NEAR(glm::length(rotation), 1, 1e-6);
    EXPECT_NEAR(forward.x, heading.x, 2e-3) << i;
    EXPECT_NEAR(forward.z, heading.y, 2e-3) << i;
    EXPECT_NEAR(forward.y, 0, 1e-6);
  }
}

TEST(Ground, SpheresEndOutsideRotatedBoxes) {
  World world;
  const quat rotation = glm::normalize(quat(0.8f, 0.3f, -0.4f, 0.2f));
  const vec3 extent{1.0f, 0.5f, 2.0f};
  world.spawn(Transform{.position = {1, 2, 3}, .rotation = rotation}, BoxCollider{.half_extent = extent});
  for (uint64_t i = 0; i < 5000; ++i) {
    const auto random = [&](uint64_t draw) { return 6.0 * randomUnit(2, i, 0, draw) - 3.0; };
    const double radius = 0.1 + 0.5 * randomUnit(2, i, 0, 3);
    const dvec3 start = dvec3(1, 2, 3) + dvec3(random(0), random(1), random(2));
    const dvec3 center = pushOut(world, start, radius).center;
    // The exact distance to the box, axis by axis in the box's own axes.
    const dvec3 local = glm::conjugate(glm::dquat(rotation)) * (center - dvec3(1, 2, 3));
    double squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double beyond = std::max(0.0, std::abs(local[axis]) - static_cast<double>(extent[axis]));
      squared += beyond * beyond;
    }
    EXPECT_GE(std::sqrt(squared), radius - 1e-6);
  }
}

TEST(Creature, WalksAtItsSpeedAndStopsAtTheEdge) {
  auto app = open(writeLevel("walk"));
  ASSERT_TRUE(app);
  tick(*app, {}, 30);
  const dvec3 start = beast(*app).position;
  EXPECT_NEAR(start.y, 0, 0.01);
  tick(*app, {0, 1}, 30);  // up to speed
  const double before = beast(*app).position.z;
  tick(*app, {0, 1}, 30);
  EXPECT_NEAR(beast(*app).position.z - before, 2.2 * 0.5, 0.02);
  tick(*app, {0, 1}, 600);
  EXPECT_GT(beast(*app).position.z, 2.5);
  EXPECT_LT(beast(*app).position.z, 3.4);
  EXPECT_NEAR(beast(*app).position.y, 0, 0.2);
  for (const Input& input : {Input{1, 0}, Input{-1, 0}, Input{0, -1}, Input{0.7f, -0.7f}})
    tick(*app, input, 400);
  EXPECT_GT(beast(*app).position.y, -0.3) << "it fell off";
}

TEST(Creature, PushesAGrainThatItWalksInto) {
  auto app = open(writeLevel("push"));
  ASSERT_TRUE(app);
  tick(*app, {}, 30);
  GrainSpec spec;
  spec.grain = {vec3(0, 0.1, 1.6), 0.08f};
  grainField(app->world()).placed = true;
  spawnGrains(app->world(), {&spec, 1});
  tick(*app, {0, 1}, 60);
  int count = 0;
  app->world().query<const Grain>().each([&](const Grain& grain) {
    ++count;
    EXPECT_GT(grain.position.z, beast(*app).position.z + 0.5);
    EXPECT_GT(grain.position.z, 1.7);
  });
  EXPECT_EQ(count, 1);
}

TEST(Control, PauseStopsTimeAndRestartBeginsAgain) {
  auto app = open(writeLevel("pause"));
  ASSERT_TRUE(app);
  tick(*app, {}, 5);
  const uint64_t at_five = app->world().stateHash();
  tick(*app, {0, 1}, 40);
  EXPECT_NE(app->world().stateHash(), at_five);
  tick(*app, {.pause = true});
  const dvec3 paused = beast(*app).position;
  tick(*app, {0, 1}, 50);
  EXPECT_EQ(beast(*app).position, paused);
  tick(*app, {.pause = true});
  tick(*app, {0, 1}, 20);
  EXPECT_NE(beast(*app).position, paused);

  tick(*app, {.restart = true});
  const dvec3 restarted = beast(*app).position;
  EXPECT_NEAR(restarted.z, 0, 0.01);
  int creatures = 0, parts = 0;
  app->world().query<const Creature>().each([&](const Creature&) { ++creatures; });
  app->world().query<const PloughPart>().each([&](const PloughPart&) { ++parts; });
  EXPECT_EQ(creatures, 1);
  EXPECT_EQ(parts, 10);
}

TEST(Control, RestartsDoNotGrowTheMeshes) {
  auto app = open(contentRoot() / "levels" / "level1.glb");
  ASSERT_TRUE(app);
  const size_t meshes = app->world().singleton<MeshStore>().size();
  const size_t materials = app->world().singleton<MaterialStore>().size();
  for (int i = 0; i < 5; ++i) {
    tick(*app, {.restart = true});
    tick(*app, {});
  }
  EXPECT_EQ(app->world().singleton<MeshStore>().size(), meshes);
  EXPECT_EQ(app->world().singleton<MaterialStore>().size(), materials);
}

TEST(Match, IsWonByMassHeldLongEnough) {
  // 27 grains of 0.1 m and 1000 kg/m^3 rest on a tray that asks for 100 of their 113 kg.
  auto app = open(writeLevel("win", R"({"name": "tray", "translation": [20, -0.5, 0], "extras": {
      "BoxCollider": {"half_extent": [3, 0.5, 3], "friction": 1}, "LoadSensor": {},
      "Scale": {"target_kg": 100, "hold_s": 1}, "LevelRules": {"time_limit_s": 30}}, "children": [3]},
      {"name": "grains", "translation": [0, 1, 0], "extras": {"GrainBlock": {"count": [3, 3, 3],
      "radius": 0.1, "density": 1000, "friction": 1, "rolling_friction": 0.2}}})"));
  ASSERT_TRUE(app);
  tick(*app, {}, 60 * 10);
  const auto& match = app->world().singleton<const Match>();
  EXPECT_EQ(match.state, MatchState::Won);
  EXPECT_GT(match.elapsed_s, 1.0f);
  app->world().query<const ScaleReading>().each([&](const ScaleReading& reading) {
    EXPECT_NEAR(reading.mass_kg, 27 * grainMass(0.1f, 1000), 0.5);
  });
  EXPECT_EQ(describeMatch(app->world()).rfind("won: 113 kg of 100 kg after ", 0), 0u)
      << describeMatch(app->world());
}

TEST(Match, NeedleTurnsWithTheMass) {
  auto app = open(writeLevel("needle", R"({"name": "tray", "extras": {"Scale": {"target_kg": 100}}})"));
  ASSERT_TRUE(app);
  World& world = app->world();
  const quat zero(0.38268343f, 0, 0, -0.92387953f);  // -135 degrees about +Z
  Transform at;
  at.rotation = zero;
  const Entity needle = world.spawn(at, previousOf(at), Needle{}, NeedleZero{zero});
  for (const float mass : {0.0f, 50.0f, 100.0f, 120.0f, 1e6f}) {
    world.query<ScaleReading>().each([&](ScaleReading& reading) { reading.mass_kg = mass; });
    tick(*app, {});
    float shown = 0;  // less than the mass: no sensor carries anything
    world.query<const ScaleReading>().each([&](const ScaleReading& reading) { shown = reading.mass_kg; });
    const float degrees = -135 + 180 * std::min(shown / 100, 1.5f);
    const vec3 up = world.peek<Transform>(needle)->rotation * vec3(0, 1, 0);
    const float angle = std::atan2(-up.x, up.y) * 57.29578f;
    EXPECT_NEAR(angle, degrees, 0.2f) << mass;
  }
}

TEST(Match, ClockRoundsUpAndNeverShowsSixtySeconds) {
  auto app = open(writeLevel("clock", R"({"name": "tray", "extras": {
      "Scale": {"target_kg": 100}, "LevelRules": {"time_limit_s": 75}}})"));
  ASSERT_TRUE(app);
  const auto clockAt = [&](float elapsed) {
    app->world().singleton<Match>().elapsed_s = elapsed;
    app->schedule().run(Phase::Animate, app->world());
    for (const TextLine& line : app->world().singleton<OverlayText>().lines())
      if (line.anchor == Anchor::TopRight) return std::string(line.text);
    return std::string("none");
  };
  EXPECT_EQ(clockAt(0), "1:15.0");
  EXPECT_EQ(clockAt(15.02f), "1:00.0");
  EXPECT_EQ(clockAt(15.0f), "1:00.0");
  EXPECT_EQ(clockAt(15.12f), "0:59.9");
  EXPECT_EQ(clockAt(74.99f), "0:00.1");
  EXPECT_EQ(clockAt(80), "0:00.0");
}

TEST(Match, IsNotWonByAnEmptyScaleThatNeedNotHold) {
  auto app = open(writeLevel("no_hold", R"({"name": "tray", "translation": [20, -0.5, 0], "extras": {
      "Scale": {"target_kg": 100, "hold_s": 0}, "LevelRules": {"time_limit_s": 2}}})"));
  ASSERT_TRUE(app);
  tick(*app, {}, 10);
  EXPECT_EQ(app->world().singleton<const Match>().state, MatchState::Playing);
}

TEST(Match, IsLostWhenTheTimeRunsOut) {
  auto app = open(writeLevel("lose", R"({"name": "tray", "translation": [20, -0.5, 0], "extras": {
      "Scale": {"target_kg": 100}, "LevelRules": {"time_limit_s": 2}}})"));
  ASSERT_TRUE(app);
  tick(*app, {}, 118);
  EXPECT_EQ(app->world().singleton<const Match>().state, MatchState::Playing);
  tick(*app, {}, 4);
  EXPECT_EQ(app->world().singleton<const Match>().state, MatchState::Lost);
  const float elapsed = app->world().singleton<const Match>().elapsed_s;
  tick(*app, {}, 60);
  EXPECT_EQ(app->world().singleton<const Match>().elapsed_s, elapsed);
}

}  // namespace
}  // namespace scree::hourglass

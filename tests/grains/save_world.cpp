// A world with grains that was saved goes on in another App to the bit; what a world lacks is not in
// its file.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <vector>

#include "engine/core/hash.h"
#include "tests/grains/app.h"
#include "tests/grains/meshes.h"

namespace scree {
namespace {

using grains::test::at;

// Meshes are assets: each App has them, no saved world.
void addMeshes(App& app) {
  using namespace grains::test;
  addMesh(app.world(), floorSoup(1.5f, 6, [](float x, float) { return 0.4f * std::abs(x); }));
  addMesh(app.world(), boxSoup(vec3(-0.15f), vec3(0.15f)));
}

std::unique_ptr<App> makeApp(int threads = 1) {
  auto app = grains::test::makeApp(threads);
  addMeshes(*app);
  return app;
}

// Who moves is found by its name, so that a loaded world is driven like the one that was saved.
Entity named(World& world, std::string_view name) {
  Entity found = Entity::kNone;
  world.query<const Name>().each([&](Entity e, const Name& n) {
    if (std::string_view(n.text) == name) found = e;
  });
  return found;
}
Name nameOf(std::string_view text) {
  Name name;
  text.copy(name.text, sizeof name.text - 1);
  return name;
}

constexpr int kTicks = 1100;

// A heap between walls that a paddle stirs at first; it falls asleep; a blade takes some away, blocks
// are poured, grains are removed and written to; all are sensed.
void fill(World& world) {
  GrainBlock block;
  block.count = {9, 5, 9};
  block.radius_jitter = 0.25f;
  block.rolling_friction = 0.1f;
  world.spawn(at({5.2, 0.5, -3.1}), block);
  world.spawn(at({5, -0.25, -3}), BoxCollider{.half_extent = vec3(2, 0.25f, 2)}, LoadSensor{});
  world.spawn(at({5, 0.005, -3}), MeshInstance{0}, MeshCollider{}, LoadSensor{});
  world.spawn(at({4.4, 0.1, -3.2}), MeshInstance{1}, HullCollider{}, LoadSensor{});
  world.spawn(at({5, 0, -3}), PlaneCollider{}, LoadSensor{});
  world.spawn(at({5.8, 0.3, -3}), BoxCollider{.half_extent = vec3(0.05f, 0.3f, 1)}, LoadSensor{});
  world.spawn(at({5, 0.15, -3}), CapsuleCollider{.a = vec3(0, 0, -0.4f), .b = vec3(0, 0, 0.4f), .radius = 0.06f},
              LoadSensor{}, nameOf("paddle"));
  world.spawn(at({5.1, 0.2, -3}), RegionSensor{.half_extent = vec3(0.4f, 0.3f, 0.4f)}, nameOf("region"));
  // What the paddle flings far away is lost.
  grainField(world).bounds_min = {-3, -1, -3};
  grainField(world).bounds_max = {3, 5, 3};
}

void act(World& world, int tick) {
  Transform* paddle = world.find<Transform>(named(world, "paddle"));
  if (tick < 120) {
    paddle->position.x = 5 + 0.3 * std::sin(0.15 * tick);
    paddle->rotation = glm::angleAxis(0.1f * static_cast<float>(tick), vec3(0, 1, 0));
  }
  if (tick > 750 && tick < 820) paddle->position += dvec3(0.004, 0.001, 0);
  if (tick % 90 == 60 && tick > 600 && tick < 900) {
    GrainBlock more;
    more.count = {3, 1, 3};
    more.rolling_friction = 0.05f;
    more.restitution = 0.2f;
    world.spawn(at({5.1, 1.2, -2.9}), more);
  }
  if (tick == 680 || tick == 860) {
    std::vector<Entity> all;
    world.query<With<Grain>>().each([&](Entity e) { all.push_back(e); });
    for (size_t k = 7; k < all.size(); k += 97) world.destroy(all[k]);
    world.find<GrainVelocity>(all[20])->linear.y = 1.5f;
  }
}

struct Reference {
  std::vector<uint64_t> hash;  // after each tick
  size_t half = 0, sleeping = 0;
};
Reference undisturbed(int threads) {
  Reference reference;
  auto app = makeApp(threads);
  World& world = app->world();
  fill(world);
  for (int tick = 0; tick < kTicks; ++tick) {
    act(world, tick);
    app->tick();
    reference.hash.push_back(world.stateHash());
    const GrainStats& stats = world.singleton<const GrainStats>();
    reference.half += stats.asleep > 0 && stats.asleep < stats.grains;
    reference.sleeping += stats.asleep == stats.grains;
  }
  return reference;
}

TEST(SavedWorld, GoesOnToTheBit) {
  const Reference want = undisturbed(1);
  std::printf("ticks half asleep %zu, all asleep %zu\n", want.half, want.sleeping);
  EXPECT_GT(want.half, 100u);
  EXPECT_GT(want.sleeping, 50u);
  for (const int threads : {1, 2, 4}) {
    auto app = makeApp(threads);
    World& world = app->world();
    fill(world);
    // One App that only ever loads goes through many worlds; others are new.
    auto other = makeApp(threads);
    fill(other->world());
    for (int tick = 0; tick < 50; ++tick) other->tick();
    std::mt19937_64 random(static_cast<uint64_t>(threads));
    int next = 3, loads = 0;
    for (int tick = 0; tick < kTicks; ++tick) {
      act(world, tick);
      if (tick == next) {
        next += 40 + static_cast<int>(random() % 60);
        // Between the game's changes and the tick that sees them.
        const std::string bytes = world.saveBytes();
        auto fresh = makeApp(threads);
        App& heir = loads++ % 2 == 0 ? *fresh : *other;
        const Status loaded = heir.world().loadBytes(bytes, "the save");
        ASSERT_TRUE(loaded.ok()) << loaded.error();
        EXPECT_TRUE(heir.world().saveBytes() == bytes) << "saved again, another file";
        for (int later = tick; later < std::min(tick + 200, kTicks); ++later) {
          if (later > tick) act(heir.world(), later);
          heir.tick();
          ASSERT_EQ(heir.world().stateHash(), want.hash[static_cast<size_t>(later)])
              << threads << " threads, saved at " << tick << ", differs at " << later;
        }
      }
      app->tick();
      ASSERT_EQ(world.stateHash(), want.hash[static_cast<size_t>(tick)]) << "saving changed tick " << tick;
    }
    EXPECT_GT(loads, 6);
  }
  setThreadCount(0);
}

TEST(SavedWorld, SensorsReadNothingAfterTheLastGrain) {
  auto app = makeApp();
  World& world = app->world();
  fill(world);
  for (int tick = 0; tick < 200; ++tick) app->tick();
  std::vector<Entity> all;
  world.query<With<Grain>>().each([&](Entity e) { all.push_back(e); });
  world.destroyMany(all);
  auto heir = makeApp();
  ASSERT_TRUE(heir->world().loadBytes(world.saveBytes(), "the save").ok());
  EXPECT_GT(heir->world().peek<RegionSensor>(named(heir->world(), "region"))->count, 0u);
  for (int tick = 0; tick < 3; ++tick) {
    app->tick();
    heir->tick();
    EXPECT_EQ(heir->world().stateHash(), world.stateHash());
  }
  EXPECT_EQ(heir->world().peek<RegionSensor>(named(heir->world(), "region"))->count, 0u);
  // New grains meet a solver with a past.
  for (App* each : {app.get(), heir.get()}) {
    GrainBlock block;
    block.count = {6, 3, 6};
    each->world().spawn(at({5, 0.5, -3}), block);
  }
  for (int tick = 0; tick < 100; ++tick) {
    app->tick();
    heir->tick();
    ASSERT_EQ(heir->world().stateHash(), world.stateHash()) << tick;
  }
}

TEST(SavedWorld, WithoutGrainsHasNothingOfThem) {
  auto app = makeApp();
  World& world = app->world();
  world.spawn(at({0, 0, 0}), nameOf("a thing"));
  for (int tick = 0; tick < 5; ++tick) app->tick();
  const std::string bytes = world.saveBytes();
  EXPECT_EQ(bytes.find("rain"), std::string::npos);
  World plain;
  ASSERT_TRUE(plain.loadBytes(bytes, "the save").ok());
  EXPECT_TRUE(plain.saveBytes() == bytes);
  // Loaded over a world with grains, nothing of these is left.
  auto full = makeApp();
  fill(full->world());
  for (int tick = 0; tick < 30; ++tick) full->tick();
  ASSERT_TRUE(full->world().loadBytes(bytes, "the save").ok());
  EXPECT_TRUE(full->world().saveBytes() == bytes);
}

TEST(SavedWorld, KeepsItsPartWhereNobodyKnowsGrains) {
  auto app = makeApp();
  fill(app->world());
  for (int tick = 0; tick < 150; ++tick) app->tick();
  const std::string bytes = app->world().saveBytes();
  World plain;
  ASSERT_TRUE(plain.loadBytes(bytes, "the save").ok());
  EXPECT_TRUE(plain.saveBytes() == bytes);
  // The module may come after the world.
  AppOptions options;
  auto late = std::make_unique<App>(options);
  ASSERT_TRUE(late->world().loadBytes(bytes, "the save").ok());
  addScene(*late);
  addDeferred(*late);
  addGrains(*late);
  addMeshes(*late);
  for (int tick = 0; tick < 50; ++tick) {
    app->tick();
    late->tick();
    ASSERT_EQ(late->world().stateHash(), app->world().stateHash()) << tick;
  }
}

TEST(SavedWorld, DamagedPartIsRefusedAndChangesNothing) {
  auto app = makeApp();
  World& world = app->world();
  fill(world);
  for (int tick = 0; tick < 100; ++tick) app->tick();
  const std::string bytes = world.saveBytes();
  const size_t part = bytes.rfind("grains") + 6 + 8;  // its bytes
  std::string damaged = bytes;
  damaged[part + 1] = 9;  // the version
  const uint64_t hash = hashBytes(damaged.data(), damaged.size() - 8);
  std::memcpy(damaged.data() + damaged.size() - 8, &hash, 8);
  const Status status = world.loadBytes(damaged, "the save");
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error(), "the save: part 'grains': version 9; this program reads 4");
  EXPECT_TRUE(world.saveBytes() == bytes);
}

}  // namespace
}  // namespace scree

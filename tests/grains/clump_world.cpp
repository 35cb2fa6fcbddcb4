// Clumps in a world: blocks, emitters, sinks, sensors, forces, faults, edits, saves.
#include <gtest/gtest.h>

#include "modules/grains/clump_shape.h"
#include "tests/grains/level.h"

namespace scree::grains::test {
namespace {

ClumpShape named(std::string_view name) {
  ClumpShape shape;
  name.copy(shape.name, sizeof shape.name - 1);
  return shape;
}

ClumpSpec bean(vec3 position, float r = 0.05f) {
  ClumpSpec spec;
  spec.member[0] = {vec3(-0.5f * r, 0, 0), r};
  spec.member[1] = {vec3(0.5f * r, 0, 0), r};
  spec.position = position;
  return spec;
}

std::vector<Entity> members(World& world) {
  std::vector<Entity> all;
  world.query<const GrainClump>().each([&](Entity e, const GrainClump&) { all.push_back(e); });
  std::sort(all.begin(), all.end());
  return all;
}

// Of two grains of different clumps, m.
double deepestOfStrangers(World& world) {
  std::vector<std::pair<Grain, Entity>> all;
  world.query<const Grain, const GrainClump>().each(
      [&](const Grain& g, const GrainClump& c) { all.emplace_back(g, c.first); });
  double worst = 0;
  for (size_t i = 0; i < all.size(); ++i)
    for (size_t j = i + 1; j < all.size(); ++j)
      if (all[i].second != all[j].second)
        worst = std::max(worst, static_cast<double>(all[i].first.radius + all[j].first.radius -
                                                    glm::length(all[i].first.position - all[j].first.position)));
  return worst;
}

TEST(ClumpWorld, BlocksOfAllShapesAreBornApart) {
  for (const char* name : {"bean", "bolt", "rod", "triangle", "tetrapod"}) {
    Level level;
    level.weightless();
    GrainBlock block;
    block.count = {4, 3, 4};
    block.radius_jitter = 0.3f;
    level.world.spawn(at({0, 1, 0}), block, named(name));
    level.run();
    const ClumpForm form = formOf(named(name));
    EXPECT_EQ(level.count(), 48u * form.count) << name;
    EXPECT_LE(deepestOfStrangers(level.world), 0) << name;
    EXPECT_EQ(grainField(level.world).refused, 0u);
  }
}

TEST(ClumpWorld, EmitterCountsClumpsAndSinkSwallowsThemWhole) {
  Level level;
  GrainEmitter emitter;
  emitter.rate = 40;
  emitter.most = 60;
  emitter.mouth = 0.5f;
  emitter.radius = 0.02f;
  level.world.spawn(at({0, 2, 0}), emitter, named("bolt"));
  const Entity sink = level.world.spawn(at({0, -1, 0}), GrainSink{.half_extent = vec3(3, 0.5f, 3)});
  double emitted_mass = 0;
  for (int tick = 0; tick < 200; ++tick) {
    level.run();
    // Never a part of one.
    EXPECT_EQ(level.count() % 4, 0u);
    EXPECT_LE(deepestOfStrangers(level.world), 1e-3);
    if (level.world.peek<GrainSink>(sink)->count == 0) {
      emitted_mass = 0;
      for (const auto& [entity, s] : level.seen())
        emitted_mass += Level::massOf(s) / static_cast<double>(level.count());
    }
  }
  EXPECT_EQ(level.count(), 0u);
  EXPECT_EQ(level.world.peek<GrainSink>(sink)->count, 240u);
  EXPECT_NEAR(level.world.peek<GrainSink>(sink)->mass / (240 * emitted_mass), 1, 1e-6);
}

TEST(ClumpWorld, SinkWithALimitTakesWholeClumps) {
  Level level;
  level.weightless();
  std::vector<ClumpSpec> specs;
  for (int k = 0; k < 5; ++k) specs.push_back(bean(vec3(0.2f * static_cast<float>(k), 0, 0)));
  spawnClumps(level.world, specs);
  const Entity sink = level.world.spawn(at({0, 0, 0}), GrainSink{.half_extent = vec3(3), .most = 5});
  level.run(2);
  EXPECT_EQ(level.world.peek<GrainSink>(sink)->count, 6u);
  EXPECT_EQ(level.count(), 4u);
}

// Handles used again do not come in order: the members of one clump lie around those of another.
TEST(ClumpWorld, SinkWithALimitTakesWholeClumpsOfRecycledHandles) {
  Level level;
  level.weightless();
  const Entity sink = level.world.spawn(at({0, 0, 0}), GrainSink{.half_extent = vec3(3), .most = 1});
  std::vector<Entity> grain;
  for (int k = 0; k < 4; ++k) grain.push_back(level.grain(vec3(0.5f * static_cast<float>(k), 0, 0)));
  std::sort(grain.begin(), grain.end());
  for (const size_t k : {2u, 1u, 3u, 0u}) level.world.destroy(grain[k]);
  spawnClumps(level.world, std::vector{bean(vec3(0)), bean(vec3(1, 0, 0))});
  std::vector<Entity> first;
  for (const Entity e : members(level.world)) first.push_back(level.world.peek<GrainClump>(e)->first);
  ASSERT_EQ(first.size(), 4u);
  ASSERT_EQ(first[0], first[3]);
  ASSERT_EQ(first[1], first[2]);
  ASSERT_NE(first[0], first[1]);
  level.run(2);
  EXPECT_EQ(level.world.peek<GrainSink>(sink)->count, 2u);
  const std::vector<Entity> left = members(level.world);
  ASSERT_EQ(left.size(), 2u);
  for (const Entity e : left) EXPECT_EQ(level.world.peek<GrainClump>(e)->first, first[1]);
}

TEST(ClumpWorld, MembersAreOfTheirMakersMatter) {
  Level level;
  GrainBlock block;
  block.count = {2, 1, 2};
  GrainEmitter emitter;
  emitter.rate = 600;
  emitter.most = 5;
  const auto set = [](auto& maker) {
    maker.friction = 0.3f;
    maker.rolling_friction = 0.1f;
    maker.restitution = 0.2f;
    maker.cohesion = 0.7f;
  };
  set(block);
  set(emitter);
  level.world.spawn(at({0, 1, 0}), block, named("bean"));
  level.world.spawn(at({0, 5, 0}), emitter, named("bean"));
  level.run(60);
  size_t seen = 0;
  level.world.query<const GrainMaterial, const GrainClump>().each([&](const GrainMaterial& m, const GrainClump&) {
    ++seen;
    EXPECT_EQ(m.friction, 0.3f);
    EXPECT_EQ(m.rolling_friction, 0.1f);
    EXPECT_EQ(m.restitution, 0.2f);
    EXPECT_EQ(m.cohesion, 0.7f);
  });
  EXPECT_EQ(seen, 18u);
}

// An emitter asks in each tick.
TEST(ClumpWorld, FormsAreMadeOncePerShape) {
  ClumpForms forms;
  ClumpShape shape = named("rod");
  const ClumpForm rod = forms.of(shape);
  EXPECT_EQ(rod.density_share, formOf(shape).density_share);
  EXPECT_EQ(rod.arm, formOf(shape).arm);
  shape.radius[0] = 2;  // of no account beside a name
  EXPECT_EQ(forms.of(shape).radius, rod.radius);
  EXPECT_EQ(forms.made(), 1u);
  shape.name[0] = 0;
  EXPECT_EQ(forms.of(shape).radius[0], 2);
  shape.radius[3] = 5;  // no member
  forms.of(shape);
  EXPECT_EQ(forms.made(), 2u);
  shape.offset[1].x += 0.1f;
  EXPECT_EQ(forms.of(shape).arm, formOf(shape).arm);
  EXPECT_EQ(forms.made(), 3u);
  // The oldest give way.
  for (int k = 0; k < 200; ++k) {
    shape.radius[0] = 1 + 0.01f * static_cast<float>(k);
    EXPECT_EQ(forms.of(shape).bound, formOf(shape).bound);
  }
  EXPECT_EQ(forms.made(), 203u);
  EXPECT_EQ(forms.of(named("rod")).arm, rod.arm);
  EXPECT_EQ(forms.made(), 204u);
}

TEST(ClumpWorld, RegionSensorsWeighTheUnion) {
  Level level;
  level.weightless();
  spawnClumps(level.world, std::vector{bean(vec3(0))});
  const Entity sensor = level.world.spawn(at({0, 0, 0}), RegionSensor{.half_extent = vec3(1)});
  level.run();
  // Two spheres of radius r, r apart: 4/3 pi r^3 (2 - 5/16).
  const double r = 0.05, want = 4.0 / 3 * 3.14159265358979 * r * r * r * (2 - 5.0 / 16) * 1500;
  EXPECT_NEAR(static_cast<double>(level.world.peek<RegionSensor>(sensor)->mass) / want, 1, 1e-5);
  EXPECT_EQ(level.world.peek<RegionSensor>(sensor)->count, 2u);
}

TEST(ClumpWorld, RefusesWhatIsNotAllowed) {
  ClumpShape shape = named("spoon");
  EXPECT_NE(fault(shape).find("name = \"spoon\"; allowed is \"bean\""), std::string::npos) << fault(shape);
  shape = {};
  shape.count = 5;
  EXPECT_NE(fault(shape).find("count = 5"), std::string::npos) << fault(shape);
  shape = {};
  shape.radius[1] = kNan;
  EXPECT_NE(fault(shape).find("radius[1]"), std::string::npos) << fault(shape);
  shape.radius[1] = 1;
  shape.offset[1].y = 11;
  EXPECT_NE(fault(shape).find("offset[1].y = 11"), std::string::npos) << fault(shape);

  Level level;
  GrainBlock block;
  block.spacing = 0.12f;  // enough for spheres, not for beans of 0.15
  level.world.spawn(at({0, 1, 0}), block, named("bean"));
  level.world.spawn(at({0, 1, 0}), GrainBlock{}, named("spoon"));
  level.world.spawn(at({0, 1, 0}), GrainEmitter{}, named("spoon"));
  level.run();
  EXPECT_EQ(level.count(), 0u);
  EXPECT_EQ(grainField(level.world).refused, 2u);

  std::vector<ClumpSpec> specs(4, bean(vec3(0, 2, 0)));
  specs[0].count = 1;
  specs[1].member[1].radius = -1;
  specs[2].velocity.x = kInf;
  spawnClumps(level.world, specs);
  EXPECT_EQ(level.count(), 2u);
  EXPECT_EQ(grainField(level.world).refused, 5u);

  for (const float cohesion : {-1.0f, 2e6f, kNan}) {
    ClumpSpec spec = bean(vec3(0, 3, 0));
    spec.material.cohesion = cohesion;
    EXPECT_NE(fault(spec).find("cohesion"), std::string::npos) << fault(spec);
    spawnClumps(level.world, {&spec, 1});
  }
  EXPECT_EQ(level.count(), 2u);
  EXPECT_EQ(grainField(level.world).refused, 8u);
}

TEST(ClumpWorld, MembersSetFreeLoseTheirComponent) {
  Level level;
  spawnClumps(level.world, std::vector{bean(vec3(0, 1, 0)), bean(vec3(1, 1, 0))});
  level.run();
  const std::vector<Entity> before = members(level.world);
  ASSERT_EQ(before.size(), 4u);
  level.world.destroy(before[1]);
  level.run(3);
  EXPECT_EQ(members(level.world), (std::vector{before[2], before[3]}));
  EXPECT_EQ(level.count(), 3u);
  EXPECT_LT(level.seen()[before[0]].position.y, 1);
}

// A member that is written to takes the others along.
TEST(ClumpWorld, EditsMoveTheWholeClump) {
  Level level;
  level.weightless();
  spawnClumps(level.world, std::vector{bean(vec3(0))});
  level.run();
  const std::vector<Entity> both = members(level.world);
  level.world.find<GrainVelocity>(both[0])->linear = vec3(0, 2, 0);
  level.run();
  auto seen = level.seen();
  EXPECT_NEAR(0.5f * (seen[both[0]].velocity.y + seen[both[1]].velocity.y), 1, 1e-4);
  level.world.find<Grain>(both[1])->position += vec3(0.4f, 0, 0);
  level.run(2);
  seen = level.seen();
  EXPECT_NEAR(glm::length(seen[both[0]].position - seen[both[1]].position), 0.05f, 1e-6);
  EXPECT_NEAR(0.5f * (seen[both[0]].position.x + seen[both[1]].position.x), 0.2f, 1e-2);
}

// Pulled everywhere alike it falls as a sphere does; drag slows it as its members.
TEST(ClumpWorld, ForcesActOnMembers) {
  Level level;
  level.weightless();
  level.world.spawn(at({0, 0, 0}), GrainForce{.half_extent = vec3(50), .acceleration = vec3(0, 3, 0), .drag = 0.5f});
  spawnClumps(level.world, std::vector{bean(vec3(0, 0, 0))});
  const Entity sphere = level.grain(vec3(1, 0, 0));
  level.run(60);
  const std::vector<Entity> both = members(level.world);
  auto seen = level.seen();
  EXPECT_NEAR(seen[both[0]].velocity.y, seen[sphere].velocity.y, 1e-4);
  EXPECT_NEAR(seen[both[0]].position.y, seen[sphere].position.y, 1e-4);
  EXPECT_LT(glm::length(seen[both[0]].spin), 1e-3f);
}

TEST(ClumpWorld, BlowsWakeAndThrowWholeClumps) {
  Level level;
  level.world.spawn(at({0, -0.5, 0}), BoxCollider{.half_extent = vec3(20, 0.5f, 20)});
  spawnClumps(level.world, std::vector{bean(vec3(0, 0.05f, 0))});
  ASSERT_LE(level.sleep(), 3000);
  impulseInSphere(level.world, {0.2, 0, 0}, 0.3f, 500);
  level.run(2);
  for (const auto& [entity, s] : level.seen()) {
    EXPECT_FALSE(s.asleep);
    EXPECT_LT(s.velocity.x, -0.05f);
  }
}

TEST(ClumpWorld, SavedWorldsGoOnToTheBit) {
  const auto fill = [](Level& level) {
    GrainBlock block;
    block.count = {5, 4, 5};
    block.radius_jitter = 0.2f;
    block.rolling_friction = 0.05f;
    level.world.spawn(at({0.1, 1.2, 0}), block, named("bolt"));
    level.world.spawn(at({0, -0.5, 0}), BoxCollider{.half_extent = vec3(20, 0.5f, 20)}, LoadSensor{});
  };
  const auto drop = [](Level& level) { spawnClumps(level.world, std::vector{bean(vec3(0.1f, 1.5f, 0))}); };
  for (const int save_at : {2, 40, 400, 640}) {
    Level all(2);
    fill(all);
    std::string bytes;
    for (int tick = 0; tick < 700; ++tick) {
      if (tick == save_at) bytes = all.world.saveBytes();
      if (tick == 600) drop(all);
      all.run();
    }
    Level later(1);
    ASSERT_TRUE(later.world.loadBytes(bytes, "test").ok());
    for (int tick = save_at; tick < 700; ++tick) {
      if (tick == 600) drop(later);
      later.run();
    }
    EXPECT_TRUE(all.seen() == later.seen()) << "saved at " << save_at;
    EXPECT_GT(all.asleep(), save_at == 400 ? 100u : 0u);
    setThreadCount(1);
  }
}


}  // namespace
}  // namespace scree::grains::test

// Deferred commands: their order, their pending handles, their refusals.
#include <gtest/gtest.h>

#include "engine/core/parallel.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

TEST(Commands, ApplyOnlyAtTheFlush) {
  World world;
  const Entity entity = world.spawn(Position{});
  Commands& commands = world.commands();
  commands.add(entity, Velocity{{1, 2, 3}, 4});
  commands.remove<Position>(entity);
  commands.spawn(Asleep{});
  EXPECT_TRUE(world.has<Position>(entity));
  EXPECT_EQ(world.entityCount(), 1u);
  const FlushResult result = world.flush();
  EXPECT_EQ(result.applied, 3u);
  EXPECT_EQ(result.refused, 0u);
  EXPECT_FALSE(world.has<Position>(entity));
  EXPECT_EQ(*world.peek<Velocity>(entity), (Velocity{{1, 2, 3}, 4}));
  EXPECT_EQ(world.entityCount(), 2u);
  EXPECT_EQ(world.flush().applied, 0u) << "each command once";
}

TEST(Commands, OnDeadEntitiesAreRefusedAndCounted) {
  World world;
  const Entity entity = world.spawn(Position{});
  world.commands().destroy(entity);
  world.commands().destroy(entity);
  world.commands().add(entity, Velocity{});
  world.commands().remove<Position>(entity);
  const FlushResult result = world.flush();
  EXPECT_EQ(result.applied, 1u);
  EXPECT_EQ(result.refused, 3u);
  EXPECT_EQ(world.entityCount(), 0u);
}

TEST(Commands, PendingHandlesNameTheNewEntity) {
  World world;
  Commands& commands = world.commands();
  const Entity first = commands.spawn(Link{Entity::kNone, 1});
  const Entity second = commands.spawn(Link{first, 2});
  EXPECT_FALSE(world.alive(first));
  commands.add(first, Link{second, 3});
  commands.add(second, Everything{.other = second, .pair = {first, Entity::kNone}});
  const Entity doomed = commands.spawn(Wide{});
  commands.destroy(doomed);
  world.flush();
  EXPECT_EQ(world.entityCount(), 2u);
  world.query<const Link>().each([&](Entity entity, const Link& link) {
    EXPECT_TRUE(world.alive(link.to));
    EXPECT_NE(link.to, entity);
    EXPECT_EQ(world.peek<Link>(link.to)->to, entity) << "they point at each other";
  });
  world.query<const Everything>().each([&](Entity entity, const Everything& everything) {
    EXPECT_EQ(everything.other, entity);
    EXPECT_EQ(world.peek<Link>(everything.pair[0])->weight, 3u);
    EXPECT_EQ(everything.pair[1], Entity::kNone);
  });
}

// What a run of parallel commands leaves behind: rows in order, with handles.
std::vector<std::pair<Entity, uint32_t>> runParallel(int threads) {
  setThreadCount(threads);
  World world;
  const TableRows rows = world.spawnMany<Position>(20000);
  for (size_t i = 0; i < rows.size(); ++i)
    rows.column<Position>()[i].radius_m = static_cast<float>(i);
  const auto query = world.query<const Position>();
  world.commands().spawn(Link{Entity::kNone, 1000001});
  query.eachParallel(
      [](Entity entity, const Position& p, Commands& commands) {
        const auto i = static_cast<uint32_t>(p.radius_m);
        if (i % 3 == 0) commands.spawn(Link{entity, i});
        if (i % 5 == 0) commands.destroy(entity);
        if (i % 7 == 0) commands.add<Marked>(entity);
      },
      64);
  world.commands().spawn(Link{Entity::kNone, 1000002});
  // World::commands() inside a chunk is the chunk's buffer too.
  query.eachParallel([&](Entity entity, const Position& p) {
    const auto i = static_cast<uint32_t>(p.radius_m);
    if (i % 11 == 0) world.commands().spawn(Link{entity, 2000000 + i});
  });
  world.flush();
  std::vector<std::pair<Entity, uint32_t>> result;
  for (const auto& table : world.tables())
    for (Entity entity : table->entities()) {
      const Link* link = world.peek<Link>(entity);
      const Position* p = world.peek<Position>(entity);
      result.emplace_back(entity, link ? link->weight : static_cast<uint32_t>(p->radius_m));
    }
  setThreadCount(0);
  return result;
}

TEST(Commands, OfParallelChunksApplyInTheOrderOfChunks) {
  const auto expected = runParallel(1);
  // Spawned links come in the order of rows, between those that were recorded before and after.
  std::vector<uint32_t> weights;
  for (const auto& [entity, weight] : expected) weights.push_back(weight);
  const auto begin = std::find(weights.begin(), weights.end(), 1000001u);
  ASSERT_NE(begin, weights.end());
  auto at = begin + 1;
  for (uint32_t i = 0; i < 20000; i += 3) ASSERT_EQ(*at++, i);
  ASSERT_EQ(*at++, 1000002u);
  for (uint32_t i = 0; i < 20000; i += 11) ASSERT_EQ(*at++, 2000000 + i);
  for (int threads : {2, 4, 8}) EXPECT_EQ(runParallel(threads), expected) << threads << " threads";
}

TEST(Commands, OfNestedParallelIterationsApplyInOrder) {
  const auto run = [](int threads) {
    setThreadCount(threads);
    World world;
    const TableRows rows = world.spawnMany<Wide>(40);
    for (size_t i = 0; i < rows.size(); ++i) rows.column<Wide>()[i].value = static_cast<double>(i);
    const auto query = world.query<const Wide>();
    query.eachParallel(
        [&](const Wide& outer, Commands& commands) {
          const auto o = static_cast<uint32_t>(outer.value) * 1000;
          commands.spawn(Link{Entity::kNone, o});
          query.eachParallel(
              [&](const Wide& inner, Commands& nested) {
                nested.spawn(Link{Entity::kNone, o + 1 + static_cast<uint32_t>(inner.value)});
              },
              3);
          world.commands().spawn(Link{Entity::kNone, o + 999});
        },
        1);
    world.flush();
    std::vector<uint32_t> weights;
    world.query<const Link>().each([&](const Link& link) { weights.push_back(link.weight); });
    setThreadCount(0);
    return weights;
  };
  std::vector<uint32_t> expected;
  for (uint32_t o = 0; o < 40; ++o) {
    expected.push_back(o * 1000);
    for (uint32_t i = 0; i < 40; ++i) expected.push_back(o * 1000 + 1 + i);
    expected.push_back(o * 1000 + 999);
  }
  for (int threads : {1, 2, 4}) EXPECT_EQ(run(threads), expected) << threads << " threads";
}

}  // namespace
}  // namespace scree

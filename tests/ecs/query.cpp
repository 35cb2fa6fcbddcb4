// Queries: matching, emptiness, versions, serial and parallel iteration.
#include <gtest/gtest.h>

#include <atomic>
#include <set>

#include "engine/core/parallel.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

TEST(Query, MatchesWithAndWithout) {
  World world;
  const Entity a = world.spawn(Position{});
  const Entity b = world.spawn(Position{}, Velocity{});
  const Entity c = world.spawn(Position{}, Velocity{}, Asleep{});
  const Entity d = world.spawn(Velocity{}, Marked{});
  const auto matched = [](auto query) {
    std::set<Entity> entities;
    query.each([&](Entity entity, auto&...) { entities.insert(entity); });
    EXPECT_EQ(entities.size(), query.count());
    EXPECT_EQ(entities.empty(), query.empty());
    return entities;
  };
  EXPECT_EQ(matched(world.query<const Position>()), (std::set{a, b, c}));
  EXPECT_EQ(matched(world.query<Position, Velocity>()), (std::set{b, c}));
  EXPECT_EQ(matched(world.query<const Velocity, Without<Position>>()), (std::set{d}));
  EXPECT_EQ(matched(world.query<Position, With<Velocity>, Without<Asleep>>()), (std::set{b}));
  EXPECT_EQ(matched(world.query<With<Asleep>>()), (std::set{c}));
  EXPECT_EQ(matched(world.query<Without<Asleep>>()), (std::set{a, b, d}));
  EXPECT_EQ(matched(world.query<const Position, With<Marked>>()), (std::set<Entity>{}));
}

TEST(Query, KnowsEmptyFromFilledThroughEveryKindOfChange) {
  World world;
  const auto query = world.query<const Position, Without<Asleep>>();
  EXPECT_TRUE(query.empty()) << "no table yet";
  const Entity a = world.spawn(Position{});
  EXPECT_FALSE(query.empty());
  world.destroy(a);
  EXPECT_TRUE(query.empty());
  const Entity b = world.spawn(Position{}, Velocity{});
  const Entity c = world.spawn(Position{});
  EXPECT_FALSE(query.empty());
  world.destroy(c);
  EXPECT_FALSE(query.empty()) << "one of two tables is still filled";
  world.add<Asleep>(b);
  EXPECT_TRUE(query.empty()) << "the entity moved to a table that does not match";
  world.remove<Asleep>(b);
  EXPECT_FALSE(query.empty());
  world.remove<Position>(b);
  EXPECT_TRUE(query.empty());
  const TableRows rows = world.spawnMany<Position>(10);
  EXPECT_FALSE(query.empty());
  const std::vector<Entity> all(rows.entities().begin(), rows.entities().end());
  world.destroyMany(all);
  EXPECT_TRUE(query.empty());
  world.commands().spawn(Position{});
  EXPECT_TRUE(query.empty()) << "not before the flush";
  world.flush();
  EXPECT_FALSE(query.empty());
  world.clear();
  EXPECT_TRUE(query.empty());
  world.spawnMany<Position>(0);
  EXPECT_TRUE(query.empty());
  EXPECT_EQ(world.query<const Position>().empty(), true) << "made after the tables";
  world.spawn(Position{});
  EXPECT_FALSE((world.query<const Position, Without<Marked>>().empty()));
}

TEST(Query, CopiesShareOneCache) {
  World world;
  const auto first = world.query<Position>();
  const auto second = world.query<Position>();
  EXPECT_EQ(first.tables().data(), second.tables().data());
  world.spawn(Position{});
  EXPECT_EQ(first.tables().data(), second.tables().data());
  EXPECT_FALSE(second.empty());
}

TEST(Query, EachWritesAndSpansSeeIt) {
  World world;
  for (int i = 0; i < 100; ++i) {
    world.spawn(Position{{i, 0, 0}, 1}, Velocity{{1, 2, 3}, 0});
    world.spawn(Position{{i, 0, 0}, 1}, Velocity{{1, 2, 3}, 0}, Marked{});
  }
  const auto query = world.query<Position, const Velocity>();
  query.each([](Position& p, const Velocity& v) { p.position += v.velocity; });
  int tables = 0;
  query.spans(
      [&](std::span<const Entity> entities, std::span<Position> p, std::span<const Velocity> v) {
        ++tables;
        ASSERT_EQ(entities.size(), 100u);
        ASSERT_EQ(v.size(), 100u);
        for (size_t i = 0; i < p.size(); ++i)
          EXPECT_EQ(p[i].position, vec3(static_cast<float>(i) + 1, 2, 3));
      });
  EXPECT_EQ(tables, 2);
}

TEST(Query, ParallelVisitsEachRowOnceInFixedChunks) {
  for (int threads : {1, 2, 4}) {
    setThreadCount(threads);
    World world;
    world.spawnMany<Position>(5000);
    world.spawnMany<Position, Marked>(1);
    world.spawnMany<Position, Asleep>(2500);
    const auto query = world.query<Position>();
    query.eachParallel([](Entity, Position& p) { p.radius_m += 1; });
    query.eachParallel([](Position& p) { p.radius_m += 1; }, 7);
    query.each([](const Position& p) { EXPECT_EQ(p.radius_m, 3); });
    std::atomic<size_t> chunks{0};
    std::atomic<size_t> rows{0};
    query.spansParallel(
        [&](std::span<const Entity> entities, std::span<Position> p) {
          ++chunks;
          rows += p.size();
          EXPECT_EQ(entities.size(), p.size());
          EXPECT_LE(p.size(), 1000u);
          for (size_t i = 0; i < p.size(); ++i) EXPECT_EQ(world.peek<Position>(entities[i]), &p[i]);
        },
        1000);
    EXPECT_EQ(chunks, 5u + 1u + 3u);
    EXPECT_EQ(rows, 7501u);
  }
  setThreadCount(0);
}

TEST(Versions, GrowAtEachChangeAndOnlyThen) {
  World world;
  const Entity a = world.spawn(Position{}, Velocity{});
  Table& table = *world.tables()[0];
  const auto query = world.query<Position, const Velocity>();
  Version position = table.version<Position>();
  Version velocity = table.version<Velocity>();
  Version whole = query.version();
  const auto expect = [&](bool position_changed, bool velocity_changed, const char* what) {
    EXPECT_EQ(table.version<Position>() > position, position_changed) << what;
    EXPECT_EQ(table.version<Velocity>() > velocity, velocity_changed) << what;
    EXPECT_EQ(query.version<Position>() > position, position_changed) << what;
    EXPECT_EQ(query.version<Velocity>() > velocity, velocity_changed) << what;
    EXPECT_EQ(query.version() > whole, position_changed || velocity_changed) << what;
    EXPECT_EQ(query.version(), std::max(table.version<Position>(), table.version<Velocity>()));
    position = table.version<Position>();
    velocity = table.version<Velocity>();
    whole = query.version();
  };
  expect(false, false, "reading versions");
  query.each([](Position&, const Velocity&) {});
  expect(true, false, "each");
  query.eachParallel([](Position&, const Velocity&) {});
  expect(true, false, "eachParallel");
  world.query<const Position>().each([](const Position&) {});
  world.query<const Position>().eachParallel([](const Position&) {});
  expect(false, false, "const each");
  world.find<Velocity>(a);
  expect(false, true, "find");
  world.peek<Velocity>(a);
  static_cast<void>(table.read<Velocity>());
  expect(false, false, "peek");
  static_cast<void>(table.write<Velocity>());
  expect(false, true, "write");
  const Entity b = world.spawn(Position{}, Velocity{});
  expect(true, true, "spawn");
  world.permute(table, std::vector<uint32_t>{1, 0});
  expect(true, true, "permute");
  world.destroy(b);
  expect(true, true, "destroy");
  world.spawn(Wide{});
  expect(false, false, "another table");
  world.add(a, Velocity{});
  expect(false, true, "add overwrites");
  world.stateHash();
  expect(false, false, "hashing");
  world.clear();
  expect(true, true, "clear");
}

TEST(Versions, OfAQueryGrowWhenATableStopsToBeFilledOrComesIn) {
  World world;
  const auto query = world.query<const Position>();
  Version last = query.version();
  const auto changed = [&] {
    const Version now = query.version();
    const bool result = now > last;
    last = now;
    return result;
  };
  EXPECT_FALSE(changed());
  const Entity entity = world.spawn(Position{});
  EXPECT_TRUE(changed());
  world.add<Marked>(entity);
  EXPECT_TRUE(changed()) << "the row is elsewhere now";
  world.destroy(entity);
  EXPECT_TRUE(changed());
  EXPECT_FALSE(changed());
}

}  // namespace
}  // namespace scree

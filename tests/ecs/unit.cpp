// Entities, tables, components one by one and in bulk, singletons.
#include <gtest/gtest.h>

#include <set>

#include "engine/ecs/entity_slots.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

TEST(Entities, DeadHandlesAreRefused) {
  World world;
  const Entity entity = world.spawn(Position{}, Asleep{});
  ASSERT_TRUE(world.alive(entity));
  ASSERT_TRUE(world.destroy(entity));
  EXPECT_FALSE(world.alive(entity));
  EXPECT_FALSE(world.destroy(entity));
  EXPECT_EQ(world.find<Position>(entity), nullptr);
  EXPECT_EQ(world.peek<Position>(entity), nullptr);
  EXPECT_EQ(world.add(entity, Velocity{}), nullptr);
  EXPECT_FALSE(world.remove<Asleep>(entity));
  EXPECT_FALSE(world.has<Asleep>(entity));
  EXPECT_TRUE(world.componentIds(entity).empty());
  const Entity next = world.spawn(Position{});
  EXPECT_EQ(next.index, entity.index);
  EXPECT_FALSE(world.alive(entity)) << "an index's next entity must not revive the old handle";
  EXPECT_EQ(world.find<Position>(entity), nullptr);
  EXPECT_EQ(world.entityCount(), 1u);
}

TEST(Entities, MadeUpHandlesAreRefused) {
  World world;
  const Entity entity = world.spawn();
  world.destroy(entity);
  EXPECT_FALSE(world.alive(Entity::kNone));
  EXPECT_FALSE(world.alive(Entity{}));
  EXPECT_FALSE(world.alive(Entity{0, 0}));
  EXPECT_FALSE(world.alive(Entity{1u << 30, 1}));
  EXPECT_FALSE(world.alive(Entity{0, kPendingGeneration}));
  EXPECT_FALSE(world.alive(Entity{entity.index, entity.generation + 1}))
      << "nobody lives there yet";
}

TEST(Entities, AnIndexRetiresBeforeItsGenerationWraps) {
  EntitySlots slots(3);
  std::set<uint64_t> seen;
  for (int i = 0; i < 3; ++i) {
    const Entity entity = slots.allocate(0, 0);
    EXPECT_EQ(entity.index, 0u);
    EXPECT_TRUE(seen.insert(entity.bits()).second);
    slots.release(entity);
  }
  const Entity fresh = slots.allocate(0, 0);
  EXPECT_EQ(fresh.index, 1u) << "index 0 has used up its generations";
  for (uint64_t bits : seen)
    EXPECT_EQ(slots.find(Entity{static_cast<uint32_t>(bits), static_cast<uint32_t>(bits >> 32)}),
              nullptr);
  EXPECT_EQ(slots.find(Entity{0, kPendingGeneration}), nullptr);
  EXPECT_EQ(slots.aliveCount(), 1u);
}

TEST(Components, AddFindRemove) {
  World world;
  const Entity a = world.spawn(Position{{1, 2, 3}, 4});
  const Entity b = world.spawn(Position{{5, 6, 7}, 8});
  Velocity* velocity = world.add(a, Velocity{{1, 0, 0}, 2});
  ASSERT_NE(velocity, nullptr);
  EXPECT_EQ(*velocity, (Velocity{{1, 0, 0}, 2}));
  EXPECT_EQ(*world.peek<Position>(a), (Position{{1, 2, 3}, 4})) << "values move with the entity";
  EXPECT_EQ(*world.peek<Position>(b), (Position{{5, 6, 7}, 8}));
  world.add(a, Velocity{{9, 9, 9}, 9});
  EXPECT_EQ(*world.peek<Velocity>(a), (Velocity{{9, 9, 9}, 9})) << "add overwrites";
  EXPECT_TRUE(world.remove<Position>(a));
  EXPECT_FALSE(world.remove<Position>(a));
  EXPECT_EQ(world.peek<Position>(a), nullptr);
  EXPECT_EQ(*world.peek<Velocity>(a), (Velocity{{9, 9, 9}, 9}));
  EXPECT_EQ(world.componentIds(a).size(), 1u);
}

TEST(Components, TagsHaveNoMemoryButExist) {
  World world;
  const Entity entity = world.spawn();
  EXPECT_EQ(world.find<Asleep>(entity), nullptr);
  EXPECT_NE(world.add<Asleep>(entity), nullptr);
  EXPECT_NE(world.find<Asleep>(entity), nullptr);
  EXPECT_TRUE(world.has<Asleep>(entity));
  EXPECT_EQ(findComponent("Asleep")->size, 0u);
  EXPECT_TRUE(world.remove<Asleep>(entity));
  EXPECT_FALSE(world.has<Asleep>(entity));
}

TEST(Components, ColumnsAreAlignedAndContiguous) {
  World world;
  for (int i = 0; i < 1000; ++i) world.spawn(Position{{i, 0, 0}, 1}, Wide{i + 0.5});
  int calls = 0;
  world.query<const Position, const Wide>().spans(
      [&](std::span<const Entity> entities, std::span<const Position> p, std::span<const Wide> w) {
        ++calls;
        ASSERT_EQ(entities.size(), 1000u);
        ASSERT_EQ(p.size(), 1000u);
        EXPECT_EQ(reinterpret_cast<uintptr_t>(p.data()) % kColumnAlignment, 0u);
        EXPECT_EQ(reinterpret_cast<uintptr_t>(w.data()) % 128, 0u);
        for (int i = 0; i < 1000; ++i) {
          EXPECT_EQ(p[static_cast<size_t>(i)].position.x, static_cast<float>(i));
          EXPECT_EQ(w[static_cast<size_t>(i)].value, i + 0.5);
        }
      });
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(reinterpret_cast<uintptr_t>(&world.singleton<Wide>()) % 128, 0u);
}

TEST(Bulk, SpawnManyFillsDefaultsOrCopies) {
  World world;
  world.spawn(Position{}, Velocity{});
  const TableRows rows = world.spawnMany<Position, Velocity>(1000);
  ASSERT_EQ(rows.size(), 1000u);
  for (const Velocity& v : rows.column<Velocity>()) EXPECT_EQ(v, Velocity{});
  for (size_t i = 0; i < rows.size(); ++i) rows.column<Position>()[i].radius_m = i * 1.0f;
  for (size_t i = 0; i < rows.size(); ++i)
    EXPECT_EQ(world.peek<Position>(rows.entities()[i])->radius_m, i * 1.0f);
  const Position sample{{3, 1, 4}, 1.5f};
  const TableRows copies = world.spawnMany(777, sample, Asleep{});
  for (const Position& p : copies.column<Position>()) EXPECT_EQ(p, sample);
  EXPECT_EQ(world.spawnMany<Position>(0).size(), 0u);
  EXPECT_EQ(world.entityCount(), 1778u);
  std::set<Entity> distinct;
  for (const auto& table : world.tables())
    distinct.insert(table->entities().begin(), table->entities().end());
  EXPECT_EQ(distinct.size(), 1778u);
}

TEST(Bulk, SpawnManySetsValuesByIndex) {
  World world;
  world.spawn(Position{}, Velocity{});
  const size_t count = 300000;  // the columns are of huge pages
  const TableRows rows =
      world.spawnMany<Position, Velocity>(count, [](size_t i, Position& p, Velocity& v) {
        p.radius_m = static_cast<float>(i);
        v.velocity.y = -static_cast<float>(i);
      });
  ASSERT_EQ(rows.size(), count);
  for (size_t i = 0; i < count; i += 997) {
    const Entity entity = rows.entities()[i];
    const auto x = static_cast<float>(i);
    EXPECT_EQ(*world.peek<Position>(entity), (Position{vec3(0), x}));
    EXPECT_EQ(*world.peek<Velocity>(entity), (Velocity{vec3(0, -x, 0)}));
  }
  EXPECT_EQ(world.entityCount(), count + 1);
  EXPECT_EQ(world.stateHash(), world.stateHashFromScratch());
}

TEST(Bulk, SpawnManyReusesFreedHandles) {
  World world;
  const TableRows first = world.spawnMany<Position>(10);
  const std::vector<Entity> old(first.entities().begin(), first.entities().end());
  world.destroyMany(std::span(old).subspan(2, 5));
  const TableRows rows = world.spawnMany<Velocity>(8);
  std::set<uint32_t> indices;
  for (Entity entity : rows.entities()) {
    EXPECT_TRUE(world.alive(entity));
    indices.insert(entity.index);
  }
  EXPECT_EQ(indices, (std::set<uint32_t>{2, 3, 4, 5, 6, 10, 11, 12}));
}

TEST(Bulk, DestroyManyTakesOnlyTheLivingAndKeepsTheRest) {
  World world;
  std::vector<Entity> all;
  for (int i = 0; i < 100; ++i) {
    all.push_back(i % 3 ? world.spawn(Position{{i, 0, 0}, 1})
                        : world.spawn(Position{{i, 0, 0}, 1}, Velocity{}));
  }
  std::vector<Entity> doomed;
  for (int i = 0; i < 100; i += 2) doomed.push_back(all[static_cast<size_t>(i)]);
  doomed.push_back(all[0]);  // twice
  doomed.push_back(Entity::kNone);
  world.destroy(all[4]);  // dead already
  EXPECT_EQ(world.destroyMany(doomed), 49u);
  for (int i = 0; i < 100; ++i) {
    const Entity entity = all[static_cast<size_t>(i)];
    ASSERT_EQ(world.alive(entity), i % 2 == 1);
    if (i % 2 == 0) continue;
    EXPECT_EQ(world.peek<Position>(entity)->position.x, static_cast<float>(i));
  }
  world.clear();
  EXPECT_EQ(world.entityCount(), 0u);
  for (Entity entity : all) EXPECT_FALSE(world.alive(entity));
}

TEST(Permute, ReordersRowsAndKeepsHandles) {
  World world;
  std::vector<Entity> entities;
  for (uint32_t i = 0; i < 50000; ++i)
    entities.push_back(world.spawn(Position{{i, 0, 0}, 1}, Wide{i * 2.0}, Link{Entity{}, i}));
  Table& table = *world.tables()[0];
  const uint64_t hash = world.stateHash();
  std::vector<uint32_t> order(50000);
  for (uint32_t i = 0; i < order.size(); ++i)
    order[i] = static_cast<uint32_t>(uint64_t{i} * 7919 % order.size());
  world.permute(table, order);
  for (uint32_t i = 0; i < 50000; ++i) {
    EXPECT_EQ(table.entities()[i], entities[order[i]]);
    EXPECT_EQ(table.read<Link>()[i].weight, order[i]);
    EXPECT_EQ(world.peek<Position>(entities[i])->position.x, static_cast<float>(i));
    EXPECT_EQ(world.peek<Wide>(entities[i])->value, i * 2.0);
  }
  EXPECT_EQ(world.stateHash(), hash);
  EXPECT_EQ(world.stateHashFromScratch(), hash);
}

struct Plain {
  std::string text = "new";
  std::vector<int>* log = nullptr;
  ~Plain() {
    if (log) log->push_back(static_cast<int>(text.size()));
  }
  Plain() = default;
  Plain(Plain&& other) noexcept
      : text(std::move(other.text)), log(std::exchange(other.log, nullptr)) {}
};
struct NoDefault {
  explicit NoDefault(int v) : value(v) {}
  int value;
};
struct Second {
  Plain plain;
};

TEST(SingletonValues, AreMadeOnFirstUseAndDestroyedInReverse) {
  std::vector<int> log;
  {
    World world;
    EXPECT_FALSE(world.hasSingleton<Plain>());
    EXPECT_EQ(world.singleton<const Plain>().text, "new");
    EXPECT_TRUE(world.hasSingleton<Plain>());
    world.singleton<Plain>().text = "a";
    world.singleton<Plain>().log = &log;
    EXPECT_EQ(&world.singleton<Plain>(), &world.singleton<const Plain>());
    world.singleton<Second>().plain.text = "bb";
    world.singleton<Second>().plain.log = &log;
    EXPECT_EQ(world.setSingleton(NoDefault(5)).value, 5);
    EXPECT_EQ(world.setSingleton(NoDefault(6)).value, 6);
    EXPECT_EQ(world.singleton<NoDefault>().value, 6);
  }
  EXPECT_EQ(log, (std::vector<int>{2, 1}));
}

}  // namespace
}  // namespace scree

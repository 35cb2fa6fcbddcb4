// Misuse ends the program with one line that names what is wrong.
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "engine/core/parallel.h"
#include "engine/ecs/range.h"
#include "engine/ecs/schedule.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

class Refusals : public ::testing::Test {
 protected:
  void SetUp() override {
    // Forked children must not inherit half a thread pool.
    ::testing::FLAGS_gtest_death_test_style = "threadsafe";
    entity = world.spawn(Position{}, Velocity{});
  }
  void inSystem(SystemDesc desc, std::function<void(World&)> run) {
    desc.name = "test.system";
    desc.run = std::move(run);
    schedule.add(std::move(desc));
    schedule.run(Phase::Simulate, world);
  }
  World world;
  Schedule schedule;
  Entity entity;
};

TEST(Ranges, LimitsOfFloatsAreAllowed) {
  EXPECT_EQ(firstFault({{"x", static_cast<double>(0.01f), 0.01, 10}}), "");
  EXPECT_EQ(firstFault({{"x", static_cast<double>(1e-12f), 1e-12, 1e15}, {"y", static_cast<double>(1e9f), 1e-9, 1e9}}), "");
  EXPECT_EQ(firstFault({{"x", static_cast<double>(std::nextafter(0.01f, 0.0f)), 0.01, 10}}), "x = 0.01; allowed is 0.01 to 10");
  EXPECT_NE(firstFault({{"x", std::nan(""), 0, 1}}), "");
}

TEST_F(Refusals, StructuralChangeWhileIterating) {
  const auto query = world.query<const Position>();
  const auto during = [&](auto change) { query.each([&](const Position&) { change(); }); };
  const char* why = "while a query iterates: use World::commands";
  EXPECT_DEATH(during([&] { world.spawn(Position{}); }), why);
  EXPECT_DEATH(during([&] { world.spawnMany<Position>(2); }), why);
  EXPECT_DEATH(during([&] { world.destroy(entity); }), why);
  EXPECT_DEATH(during([&] { world.destroyMany({&entity, 1}); }), why);
  EXPECT_DEATH(during([&] { world.add(entity, Wide{}); }), why);
  EXPECT_DEATH(during([&] { world.remove<Position>(entity); }), why);
  EXPECT_DEATH(during([&] { world.clear(); }), why);
  EXPECT_DEATH(during([&] { world.flush(); }), why);
  EXPECT_DEATH(during([&] { world.permute(*world.tables()[0], {}); }), why);
  EXPECT_DEATH(during([&] { static_cast<void>(world.load("nothing")); }), why);
  EXPECT_DEATH(during([&] { world.stateHash(); }), why);
  EXPECT_DEATH(query.eachParallel([&](const Position&) { world.destroy(entity); }), why);
  EXPECT_DEATH(query.spans([&](auto, auto) { world.destroy(entity); }), why);
  EXPECT_TRUE(world.destroy(entity)) << "afterwards it is allowed again";
}

TEST_F(Refusals, StructuralChangeInASystemThatIsNotExclusive) {
  EXPECT_DEATH(inSystem({.exclusive = false}, [&](World& w) { w.destroy(entity); }),
               "destroy in system 'test.system', which is not exclusive");
  inSystem({}, [&](World& w) { w.destroy(entity); });
  EXPECT_FALSE(world.alive(entity)) << "an exclusive one may";
}

TEST_F(Refusals, AccessThatASystemDoesNotDeclare) {
  const SystemDesc reads_position{.reads = reads<Position>(), .exclusive = false};
  EXPECT_DEATH(
      inSystem(reads_position, [](World& w) { w.query<Position>().each([](Position&) {}); }),
      "'test.system' writes Position, which it does not declare");
  EXPECT_DEATH(inSystem(reads_position,
                        [](World& w) { w.query<const Velocity>().each([](const Velocity&) {}); }),
               "'test.system' reads Velocity");
  EXPECT_DEATH(
      inSystem(reads_position,
               [](World& w) { w.query<const Velocity>().eachParallel([](const Velocity&) {}); }),
      "reads Velocity");
  EXPECT_DEATH(inSystem(reads_position, [&](World& w) { w.find<Position>(entity); }),
               "writes Position");
  EXPECT_DEATH(inSystem(reads_position, [&](World& w) { w.peek<Velocity>(entity); }),
               "reads Velocity");
  EXPECT_DEATH(inSystem(reads_position, [](World& w) { w.singleton<const int>(); }), "reads int");
  EXPECT_DEATH(
      inSystem({.reads = reads<int>(), .exclusive = false}, [](World& w) { w.singleton<int>(); }),
      "writes int");
  EXPECT_DEATH(inSystem(reads_position, [](World& w) { w.tables()[0]->write<Position>(); }),
               "writes Position");
  EXPECT_DEATH(inSystem(reads_position,
                        [&](World& w) {
                          w.query<const Position>().eachParallel(
                              [&](const Position&) { w.find<Velocity>(entity); });
                        }),
               "writes Velocity")
      << "also on the threads of a parallel iteration";
}

TEST_F(Refusals, DeclaredAccessIsAllowed) {
  inSystem(
      {.reads = reads<Velocity, float>(), .writes = writes<Position, int>(), .exclusive = false},
      [&](World& w) {
        w.query<Position, const Velocity>().eachParallel([&](Position&, const Velocity&) {
          EXPECT_NE(w.peek<Position>(entity), nullptr) << "who may write may read";
        });
        w.singleton<int>() = static_cast<int>(w.singleton<const float>());
        w.commands().add(entity, Wide{});
      });
  EXPECT_TRUE(world.has<Wide>(entity));
}

TEST_F(Refusals, CommandsOnAThreadOfTheirOwnOrAfterTheirFlush) {
  EXPECT_DEATH(
      {
        setThreadCount(2);
        inSystem({}, [](World& w) { std::thread([&] { w.commands().spawn(); }).join(); });
      },
      "on a thread of its own inside a system");
  EXPECT_DEATH(
      {
        Commands& commands = world.commands();
        commands.spawn();
        world.flush();
        commands.spawn();
      },
      "used after its flush");
}

TEST_F(Refusals, ColumnsThatATableDoesNotHave) {
  EXPECT_DEATH(static_cast<void>(world.tables()[0]->read<Wide>()), "without 'Wide'");
}

struct NoDefault {
  explicit NoDefault(int v) : value(v) {}
  int value;
};

TEST_F(Refusals, ASingletonThatCannotBeMade) {
  EXPECT_DEATH(world.singleton<NoDefault>(), "NoDefault has no default constructor");
}

TEST_F(Refusals, SpawningOneTypeTwice) {
  EXPECT_DEATH(world.spawn(Position{}, Position{}), "'Position' twice");
}

TEST_F(Refusals, AnOrderThatIsNoPermutation) {
  const TableRows rows = world.spawnMany<Wide>(3);
  EXPECT_DEATH(world.permute(*rows.table, std::vector<uint32_t>{0, 1}), "order of 2 rows");
  EXPECT_DEATH(world.permute(*rows.table, std::vector<uint32_t>{0, 1, 1}), "order\\[2\\] = 1");
  EXPECT_DEATH(world.permute(*rows.table, std::vector<uint32_t>{0, 1, 3}), "order\\[2\\] = 3");
}

TEST_F(Refusals, TwoSystemsOfOneName) {
  schedule.add({.name = "a.b", .run = [](World&) {}});
  EXPECT_DEATH(schedule.add({.name = "a.b", .phase = Phase::Input, .run = [](World&) {}}),
               "'a.b' is added twice");
  EXPECT_DEATH(schedule.add({.name = "c.d"}), "'c.d' has no function");
}

TEST_F(Refusals, TwoTypesOfOneName) {
  ComponentInfo copy = *findComponent("Position");
  EXPECT_DEATH(detail::registerComponent(copy), "Position.*another type has this name");
  copy.name = "Position2";
  copy.fields.push_back(copy.fields[0]);
  EXPECT_DEATH(detail::registerComponent(copy), "field 'position' is listed twice");
}

}  // namespace
}  // namespace scree

// Systems: phases, conflicts, needs, commands.
#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>
#include <thread>

#include "engine/core/log.h"
#include "engine/core/parallel.h"
#include "engine/ecs/schedule.h"
#include "tests/ecs/components.h"

namespace scree {
namespace {

class ScheduleTest : public ::testing::Test {
 protected:
  void TearDown() override { setThreadCount(0); }
  void add(const std::string& name, std::vector<AccessId> read, std::vector<AccessId> written,
           bool exclusive = false, Phase phase = Phase::Simulate) {
    schedule.add({.name = name,
                  .phase = phase,
                  .reads = std::move(read),
                  .writes = std::move(written),
                  .exclusive = exclusive,
                  .run = [this, name](World&) {
                    const std::lock_guard lock(mutex);
                    order.push_back(name);
                  }});
  }
  bool before(const std::string& a, const std::string& b) const {
    return std::find(order.begin(), order.end(), a) < std::find(order.begin(), order.end(), b);
  }
  World world;
  Schedule schedule;
  std::mutex mutex;
  std::vector<std::string> order;
};

TEST_F(ScheduleTest, ConflictingSystemsRunInTheOrderOfAdding) {
  add("write_p", {}, writes<Position>());
  add("read_p_1", reads<Position>(), {});
  add("read_p_2", reads<Position>(), writes<Velocity>());
  add("read_v", reads<Velocity>(), {});
  add("all", {}, {}, true);
  add("write_p_again", {}, writes<Position>());
  add("write_score", {}, writes<Score>());
  add("read_score", reads<Score>(), {});
  add("write_string", {}, writes<std::string>());
  add("read_string", reads<std::string>(), {});
  for (int threads : {1, 2, 4}) {
    setThreadCount(threads);
    for (int repeat = 0; repeat < 100; ++repeat) {
      order.clear();
      schedule.run(Phase::Simulate, world);
      ASSERT_EQ(order.size(), 10u);
      EXPECT_TRUE(before("write_p", "read_p_1"));
      EXPECT_TRUE(before("write_p", "read_p_2"));
      EXPECT_TRUE(before("read_p_2", "read_v"));
      EXPECT_TRUE(before("read_p_1", "all"));
      EXPECT_TRUE(before("read_v", "all"));
      EXPECT_EQ(order[4], "all") << "after all that came first, before all that came later";
      EXPECT_TRUE(before("all", "write_p_again"));
      EXPECT_TRUE(before("write_score", "read_score"));
      EXPECT_TRUE(before("write_string", "read_string"));
    }
  }
}

TEST_F(ScheduleTest, SystemsWithoutAConflictMeetEachOther) {
  setThreadCount(4);
  std::condition_variable condition;
  int inside = 0;
  bool met = false;
  const auto meet = [&](World&) {
    std::unique_lock lock(mutex);
    met = ++inside == 2 || met;
    condition.notify_all();
    condition.wait_for(lock, std::chrono::seconds(30), [&] { return met; });
    --inside;
  };
  schedule.add({.name = "a", .writes = writes<Position>(), .exclusive = false, .run = meet});
  schedule.add({.name = "b", .writes = writes<Velocity>(), .exclusive = false, .run = meet});
  schedule.run(Phase::Simulate, world);
  EXPECT_TRUE(met) << "both must run at the same time";
}

TEST_F(ScheduleTest, ConflictingSystemsNeverMeet) {
  setThreadCount(4);
  std::atomic<int> writers{0};
  for (int i = 0; i < 6; ++i)
    schedule.add({.name = fmt::format("s{}", i),
                  .reads = reads<Velocity>(),
                  .writes = writes<Position>(),
                  .exclusive = false,
                  .run = [&](World&) {
                    EXPECT_EQ(writers.fetch_add(1), 0);
                    std::this_thread::yield();
                    writers.fetch_sub(1);
                  }});
  for (int repeat = 0; repeat < 200; ++repeat) schedule.run(Phase::Simulate, world);
}

TEST_F(ScheduleTest, PhasesRunApartAndReportInTheirOrder) {
  add("p.prepare", {}, {}, true, Phase::Prepare);
  add("s.first", {}, {}, true, Phase::Simulate);
  add("i.input", {}, {}, true, Phase::Input);
  add("s.second", {}, {}, false, Phase::Simulate);
  schedule.run(Phase::Simulate, world);
  EXPECT_EQ(order, (std::vector<std::string>{"s.first", "s.second"}));
  schedule.run(Phase::Simulate, world);
  schedule.run(Phase::Prepare, world);
  const auto& report = schedule.report();
  ASSERT_EQ(report.size(), 4u);
  EXPECT_EQ(report[0].name, "i.input");
  EXPECT_EQ(report[1].name, "s.first");
  EXPECT_EQ(report[2].name, "s.second");
  EXPECT_EQ(report[3].name, "p.prepare");
  EXPECT_EQ(report[0].runs, 0u);
  EXPECT_FALSE(report[0].on);
  EXPECT_EQ(report[1].runs, 2u);
  EXPECT_EQ(report[2].runs, 2u);
  EXPECT_EQ(report[3].runs, 1u);
  EXPECT_TRUE(report[3].on);
  EXPECT_GE(report[1].cpu_ms, 0);
  EXPECT_GT(report[3].begin_s, report[1].begin_s);
  EXPECT_EQ(report[1].phase, Phase::Simulate);
  EXPECT_EQ(phaseName(Phase::Prepare), "Prepare");
}

TEST_F(ScheduleTest, ASystemSleepsWhileItsNeedsAreNotMet) {
  const auto positions = world.query<const Position>();
  int runs = 0;
  schedule.add({.name = "spawner", .run = [&](World& w) {
                  if (runs == 0 && w.entityCount() == 0) w.commands().spawn(Position{});
                }});
  schedule.add({.name = "user",
                .reads = reads<Position>(),
                .exclusive = false,
                .needs = [=] { return !positions.empty(); },
                .run = [&](World&) { ++runs; }});
  schedule.run(Phase::Simulate, world);
  EXPECT_EQ(runs, 0) << "commands come at the end of the phase";
  EXPECT_FALSE(schedule.report()[1].on);
  schedule.run(Phase::Simulate, world);
  EXPECT_EQ(runs, 1);
  EXPECT_TRUE(schedule.report()[1].on);
  world.clear();
  runs = 5;
  schedule.run(Phase::Simulate, world);
  EXPECT_EQ(runs, 5);
  EXPECT_EQ(schedule.report()[1].runs, 1u);
}

TEST_F(ScheduleTest, CommandsApplyInTheOrderOfSystems) {
  const auto run = [](int threads) {
    setThreadCount(threads);
    World local;
    Schedule systems;
    local.spawnMany<Wide>(3000);
    const auto query = local.query<const Wide>();
    // All in one wave: they only read, and record.
    for (uint32_t s = 0; s < 5; ++s) {
      systems.add({.name = fmt::format("s{}", s),
                   .reads = reads<Wide>(),
                   .exclusive = false,
                   .run = [s, query](World& w) {
                     w.commands().spawn(Link{Entity::kNone, s * 10000});
                     query.eachParallel(
                         [s](Entity entity, const Wide&, Commands& commands) {
                           commands.spawn(Link{entity, s * 10000 + 1 + entity.index});
                         },
                         100);
                     w.commands().spawn(Link{Entity::kNone, s * 10000 + 9999});
                   }});
    }
    systems.run(Phase::Simulate, local);
    std::vector<uint32_t> weights;
    local.query<const Link>().each([&](const Link& link) { weights.push_back(link.weight); });
    return weights;
  };
  std::vector<uint32_t> expected;
  for (uint32_t s = 0; s < 5; ++s) {
    expected.push_back(s * 10000);
    for (uint32_t i = 0; i < 3000; ++i) expected.push_back(s * 10000 + 1 + i);
    expected.push_back(s * 10000 + 9999);
  }
  for (int threads : {1, 2, 4}) EXPECT_EQ(run(threads), expected) << threads << " threads";
}

// Two systems in parallel over one world, each with parallel iteration, against one thread.
TEST_F(ScheduleTest, ResultsDoNotDependOnThreads) {
  const auto run = [](int threads) {
    setThreadCount(threads);
    World local;
    Schedule systems;
    const TableRows rows = local.spawnMany<Position, Velocity, Wide>(20000);
    for (size_t i = 0; i < rows.size(); ++i) rows.column<Velocity>()[i].velocity = vec3(i, 1, 0);
    const auto move = local.query<Position, const Velocity>();
    const auto widen = local.query<Wide, const Velocity>();
    systems.add({.name = "move",
                 .reads = reads<Velocity>(),
                 .writes = writes<Position>(),
                 .exclusive = false,
                 .run = [=](World&) {
                   move.eachParallel([](Entity e, Position& p, const Velocity& v, Commands& c) {
                     p.position += v.velocity * 0.1f;
                     if (e.index % 1000 == 0) c.destroy(e);
                   });
                 }});
    systems.add({.name = "widen",
                 .reads = reads<Velocity>(),
                 .writes = writes<Wide>(),
                 .exclusive = false,
                 .run = [=](World&) {
                   widen.eachParallel([](Entity e, Wide& w, const Velocity& v, Commands& c) {
                     w.value = w.value * 0.5 + v.velocity.x;
                     if (e.index % 777 == 0) c.spawn(Position{}, w);
                   });
                 }});
    std::vector<uint64_t> hashes;
    for (int tick = 0; tick < 10; ++tick) {
      systems.run(Phase::Simulate, local);
      hashes.push_back(local.stateHash());
    }
    return hashes;
  };
  const auto expected = run(1);
  for (int threads : {2, 4}) EXPECT_EQ(run(threads), expected);
}

}  // namespace
}  // namespace scree

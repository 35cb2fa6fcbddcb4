// Sleep: a heap falls asleep, stays to the bit, costs no search and no pass, and wakes where touched.
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstring>

#include "engine/core/parallel.h"
#include "tests/grains/resting.h"

namespace scree::grains::test {
namespace {

struct Bed : RestingField {
  explicit Bed(int n = 8, int height = 6) {
    parameters.damping = 0.05f;
    pour(*this, n, height, 0.05f, 6, 0.2f, {1000, 0.5f, 0.02f, 0});
  }
  // Ticks until all sleep.
  int sleep(int most = 1500) {
    for (int tick = 0; tick < most; ++tick) {
      step();
      if (asleep() == grain.size()) return tick;
    }
    return most;
  }
  size_t highest() const {
    size_t top = 0;
    for (size_t k = 0; k < grain.size(); ++k)
      if (grain[k].position.y > grain[top].position.y) top = k;
    return top;
  }
  uint64_t hashWithRest() const {
    uint64_t sum = hash();
    for (size_t k = 0; k < rest.size(); ++k)
      sum += hashCombine(hashBytes(&rest[k].anchor, sizeof(vec3), entity[k].index),
                         rest[k].asleep ? 1 : 0);
    return sum;
  }
};

TEST(Sleep, HeapFallsAsleepAndStaysToTheBit) {
  Bed bed;
  ASSERT_LT(bed.sleep(), 1500);
  const uint64_t before = bed.hash();
  bed.step();  // lists who sleeps
  for (int tick = 0; tick < 200; ++tick) {
    bed.step();
    ASSERT_EQ(bed.solver.stats().rebuilds, 0u);
    ASSERT_EQ(bed.solver.stats().pairs, 0u);
    ASSERT_EQ(bed.solver.stats().woken, 0u);
  }
  EXPECT_EQ(bed.solver.stats().asleep, bed.grain.size());
  EXPECT_EQ(bed.hash(), before);
  EXPECT_LT(bed.deepestOverlap(), 0.01);
}

// Impulses in a deep packing with friction wander for long. Sleepers take that up: none is let go with
// a push that wakes the next.
TEST(Sleep, ADeepHeapOfEqualSpheresComesToRest) {
  Bed bed(0, 0);
  bed.parameters.passes = 4;
  constexpr int kSide = 17;
  const float spacing = 0.12f, half = 0.5f * spacing * kSide;
  for (uint64_t k = 0; k < 5000; ++k) {
    const vec3 cell(static_cast<float>(k % kSide) + 0.5f, static_cast<float>(k / (kSide * kSide)) + 0.75f,
                    static_cast<float>(k / kSide % kSide) + 0.5f);
    bed.add(cell * spacing - vec3(half, 0, half) + (unitCube(3, k) - 0.5f) * 0.015f, 0.05f,
            {1000, 0.5f, 0, 0});
  }
  bed.colliders.clear();
  bed.addBin(half, 0.5f);
  for (Collider& c : bed.colliders) c.sensed = true;
  double mass = 0, mean = 0;
  for (size_t k = 0; k < bed.grain.size(); ++k) mass += bed.mass(k);
  const auto load = [&] {
    double sum = 0;
    for (const Collider& c : bed.colliders) sum -= c.load.y * 60 / 9.81;
    return sum;
  };
  // While some parts sleep and others wake, too.
  bed.step(150);
  for (int tick = 150; tick < 600; ++tick) {
    bed.step();
    mean += load() / mass / 450;
    if (tick >= 250) {
      EXPECT_NEAR(load() / mass, 1, 0.01) << tick;
    }
  }
  EXPECT_NEAR(mean, 1, 0.007);
  EXPECT_GT(bed.asleep(), bed.grain.size() * 49 / 50);
  EXPECT_NEAR(load() / mass, 1, 0.005);
}

TEST(Sleep, NothingSleepsInTheAir) {
  Bed bed(2, 2);
  bed.colliders.clear();
  bed.parameters.bounds_min = vec3(-1e4f);
  for (size_t k = 0; k < bed.grain.size(); ++k) bed.velocity[k].linear = {0, 9.81f, 0};
  bed.step(120);  // up, and down again
  EXPECT_EQ(bed.asleep(), 0u);
}

TEST(Sleep, WakesWhereAFastGrainStrikes) {
  Bed bed(16, 4);
  ASSERT_LT(bed.sleep(), 1500);
  const std::vector<Grain> before = bed.grain;
  const size_t top = bed.highest();
  const vec3 at = bed.grain[top].position;
  bed.add(at + vec3(0, 0.3f, 0), 0.05f, {1000, 0.5f, 0.02f, 0}, {0, -3, 0});
  bed.step(30);
  EXPECT_FALSE(bed.rest[top].asleep);
  // Far from there all are as they were, to the bit.
  size_t far = 0, far_awake = 0;
  for (size_t k = 0; k < before.size(); ++k) {
    if (glm::length(before[k].position - at) < 0.6f) continue;
    ++far;
    far_awake += !bed.rest[k].asleep ||
                 std::memcmp(&before[k].position, &bed.grain[k].position, sizeof(vec3)) != 0;
  }
  EXPECT_GT(far, 100u);
  EXPECT_LT(far_awake, far / 20);
  bed.sleep();
  EXPECT_EQ(bed.asleep(), bed.grain.size());
}

TEST(Sleep, AFewAwakeVisitNoneButTheirNeighbours) {
  Bed bed(24, 5);
  ASSERT_LT(bed.sleep(), 1500);
  bed.add(bed.grain[bed.highest()].position + vec3(0, 0.2f, 0), 0.05f, {1000, 0.5f, 0.02f, 0});
  for (int tick = 0; tick < 240; ++tick) {
    bed.step();
    ASSERT_LT(bed.solver.stats().visited, bed.grain.size() / 5) << tick;
    ASSERT_LT(bed.solver.stats().pairs, bed.grain.size() / 2) << tick;
  }
  EXPECT_EQ(bed.solver.stats().asleep, bed.asleep());
}

TEST(Sleep, RowsAsLeftNeedNotBeRead) {
  // A heap that sleeps and wakes in parts under a rake, with rows known to be as left, and not.
  uint64_t want = 0;
  for (const RowsAre rows : {RowsAre::Unknown, RowsAre::AsLeft}) {
    Bed bed(10, 4);
    bed.addBox({-2, 0.2f, 0}, {0.02f, 0.15f, 0.2f}, 0.5f);
    uint64_t sum = 0;
    size_t some = 0;
    for (int tick = 0; tick < 1000; ++tick) {
      Collider& rake = bed.colliders.back();
      rake.position0 = rake.position1;
      if (tick > 400) rake.position1.x += 0.006f;
      bed.step(1, rows);
      sum = hashCombine(sum, bed.hashWithRest());
      some += bed.asleep() > 0 && bed.asleep() < bed.grain.size();
    }
    EXPECT_GT(some, 200u);
    if (rows == RowsAre::Unknown) want = sum;
    EXPECT_EQ(sum, want);
  }
}

TEST(Sleep, WakesUnderAMovingCollider) {
  Bed bed(16, 4);
  ASSERT_LT(bed.sleep(), 1500);
  Collider& blade = bed.addBox({-0.3f, 0.15f, 0}, {0.02f, 0.1f, 0.2f}, 0.5f);
  for (int tick = 0; tick < 10; ++tick) {
    blade.position0 = blade.position1;
    blade.position1 = blade.position0 + vec3(0.01f, 0, 0);
    bed.step();
  }
  EXPECT_LT(bed.asleep(), bed.grain.size());
  for (size_t k = 0; k < bed.grain.size(); ++k) {
    const vec3 d = glm::abs(bed.grain[k].position - blade.position0) - blade.half_extent;
    const float r = bed.grain[k].radius;
    if (d.x < 0.9f * r && d.y < 0.5f * r && d.z < 0.5f * r) {
      EXPECT_FALSE(bed.rest[k].asleep) << k;
    }
  }
}

TEST(Sleep, WakesWhenItsSupportGoes) {
  Bed bed(5, 4);
  bed.colliders.clear();
  bed.addBin(0.4f, 0.5f);
  ASSERT_LT(bed.sleep(), 1500);
  {  // a grain that others lie on
    Bed fewer = bed;
    size_t bottom = 0;
    const size_t top = fewer.highest();
    for (size_t k = 0; k < fewer.grain.size(); ++k) {
      const vec3 d = fewer.grain[top].position - fewer.grain[k].position;
      if (k != top && d.y > 0 &&
          glm::length(d) < 1.001f * (fewer.grain[top].radius + fewer.grain[k].radius))
        bottom = k;
    }
    fewer.remove(bottom);
    fewer.step();
    EXPECT_GT(fewer.solver.stats().woken, 0u);
    EXPECT_FALSE(fewer.rest[top > bottom ? top - 1 : top].asleep);
  }
  {  // the floor
    Bed falling = bed;
    falling.colliders.erase(falling.colliders.begin());
    falling.step(120);
    for (const Grain& g : falling.grain) EXPECT_LT(g.position.y, -1);
  }
  {  // gravity
    Bed turned = bed;
    turned.parameters.gravity = {4, -9, 0};
    turned.step();
    EXPECT_EQ(turned.asleep(), 0u);
  }
  {  // a row that is written to
    Bed pushed = bed;
    pushed.velocity[3].linear = {0, 1, 0};
    pushed.step();
    EXPECT_FALSE(pushed.rest[3].asleep);
  }
}

TEST(Sleep, LoadIsStillFelt) {
  Bed bed;
  for (Collider& c : bed.colliders) c.sensed = true;
  const auto load = [&] {
    double sum = 0;
    for (const Collider& c : bed.colliders) sum -= c.load.y * 60 / 9.81;
    return sum;
  };
  ASSERT_LT(bed.sleep(), 1500);
  double mass = 0;
  for (size_t k = 0; k < bed.grain.size(); ++k) mass += bed.mass(k);
  for (int tick = 0; tick < 3; ++tick) {
    bed.step();
    EXPECT_NEAR(load() / mass, 1, 0.003);
  }
  // What comes on top is felt below.
  for (uint64_t k = 0; k < 60; ++k)
    bed.add({0.12f * (static_cast<float>(k % 6) - 2.5f), 0.8f,
             0.12f * (static_cast<float>(k / 6) - 4.5f) * 0.6f},
            0.05f, {1000, 0.5f, 0.02f, 0});
  double more = 0;
  for (size_t k = 0; k < bed.grain.size(); ++k) more += bed.mass(k);
  ASSERT_GT(more, 1.1 * mass);
  bed.sleep();
  EXPECT_NEAR(load() / more, 1, 0.005);
}

TEST(Sleep, ANewSolverFeelsTheLoadOfSleepers) {
  Bed bed;
  for (Collider& c : bed.colliders) c.sensed = true;
  ASSERT_LT(bed.sleep(), 1500);
  double mass = 0;
  for (size_t k = 0; k < bed.grain.size(); ++k) mass += bed.mass(k);
  bed.solver = GrainSolver();  // as after loading a world
  bed.step(60);
  double load = 0;
  for (const Collider& c : bed.colliders) load -= c.load.y * 60 / 9.81;
  EXPECT_NEAR(load / mass, 1, 0.02);
  EXPECT_LT(bed.sleep(), 1500);
  EXPECT_LT(bed.deepestOverlap(), 0.01);
}

TEST(Sleep, IsTheSameForEveryThreadCountAndOrderOfRows) {
  uint64_t want = 0;
  for (const int run : {0, 1, 2, 3}) {
    setThreadCount(run == 3 ? 1 : 1 << run);
    Bed bed(12, 5);
    bed.rest.resize(bed.grain.size());
    const size_t n = bed.grain.size();
    uint64_t sum = 0;
    uint32_t most_pairs = 0;
    for (int tick = 0; tick < 400; ++tick) {
      if (run == 3) {
        for (size_t k = n - 1; k > 0; --k) {
          const size_t o = randomBits(3, k, static_cast<uint64_t>(tick), 0) % (k + 1);
          std::swap(bed.entity[k], bed.entity[o]);
          std::swap(bed.grain[k], bed.grain[o]);
          std::swap(bed.velocity[k], bed.velocity[o]);
          std::swap(bed.spin[k], bed.spin[o]);
          std::swap(bed.orientation[k], bed.orientation[o]);
          std::swap(bed.previous[k], bed.previous[o]);
          std::swap(bed.material[k], bed.material[o]);
          std::swap(bed.rest[k], bed.rest[o]);
        }
      }
      bed.step();
      sum = hashCombine(sum, bed.hashWithRest());
      most_pairs = std::max(most_pairs, bed.solver.stats().pairs);
    }
    EXPECT_GT(bed.asleep(), 0u);
    EXPECT_GT(most_pairs, kFewPairs);  // else threads have nothing to do
    if (run == 0) want = sum;
    EXPECT_EQ(sum, want) << "run " << run;
  }
  setThreadCount(0);
}

}  // namespace
}  // namespace scree::grains::test

// What the solver keeps for each grain: bytes of all its arrays, counted and as the heap has them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "engine/core/parallel.h"
#include "tests/grains/resting.h"
#include "tests/support/gl_allocations.h"

namespace scree::grains::test {
namespace {

class Memory : public ::testing::Test {
 protected:
  void TearDown() override { setThreadCount(0); }
};

// Equal spheres in a loose lattice over the floor of a box, which fall into it.
void drop(Field& field, int n, int height) {
  pour(field, n, height, 0.05f, 7, 0, {1000, 0.5f, 0, 0});
  field.parameters.passes = 4;
  field.parameters.damping = 0.05f;
}

double bytesEach(const Field& field) {
  return static_cast<double>(field.solver.memoryBytes()) / static_cast<double>(field.grain.size());
}

TEST_F(Memory, OfAHeapIsBounded) {
  setThreadCount(2);
  Field field;
  drop(field, 27, 28);
  double most = 0;
  for (int tick = 0; tick < 100; ++tick) {
    field.step();
    most = std::max(most, bytesEach(field));
  }
  std::printf("%zu grains: %.0f bytes each at most, %.0f after 100 ticks, %.1f pairs\n", field.grain.size(), most,
              bytesEach(field), static_cast<double>(field.solver.stats().pairs) / static_cast<double>(field.grain.size()));
  EXPECT_LT(bytesEach(field), 360);
  EXPECT_LT(most, 430);
}

// What the walls and what each thread needs weighs more than in a large one.
TEST_F(Memory, OfASmallHeapIsBounded) {
  setThreadCount(2);
  Field field;
  drop(field, 17, 17);
  double most = 0;
  for (int tick = 0; tick < 300; ++tick) {
    field.step();
    most = std::max(most, bytesEach(field));
  }
  std::printf("%zu grains: %.0f bytes each at most, %.0f after 300 ticks\n", field.grain.size(), most, bytesEach(field));
  EXPECT_LT(bytesEach(field), 340);
  EXPECT_LT(most, 430);
}

TEST_F(Memory, OfAHeapAsleepIsBounded) {
  RestingField field;
  drop(field, 17, 17);
  int ticks = 0;
  while (ticks < 900 && 100 * field.asleep() < 99 * field.grain.size()) {
    field.step();
    ++ticks;
  }
  ASSERT_LT(ticks, 900);
  field.step(60);
  std::printf("%zu of %zu grains asleep after %d ticks: %.0f bytes each\n", field.asleep(), field.grain.size(), ticks,
              bytesEach(field));
  EXPECT_LT(bytesEach(field), 340);
}

TEST_F(Memory, IsWhatTheHeapHas) {
  for (const int threads : {1, 2})
    for (const int ticks : {20, 120, 400}) {
      setThreadCount(threads);
      RestingField field;
      drop(field, 17, 17);
      field.step(ticks);
      const size_t counted = field.solver.memoryBytes(), before = scree::test::bytesInUse();
      field.solver = GrainSolver();
      const size_t freed = before - scree::test::bytesInUse();
      std::printf("%d threads, after %d ticks: %zu bytes counted, %zu freed\n", threads, ticks, counted, freed);
      EXPECT_NEAR(static_cast<double>(freed), static_cast<double>(counted), 0.005 * static_cast<double>(counted));
    }
}

}  // namespace
}  // namespace scree::grains::test

// A million grains at rest: they cost nothing, and a few that fall among them wake only their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

TEST(Million, LieStillAndWakeWhereStruck) {
  Field field;
  field.addPlane({0, 0, 0}, quat(1, 0, 0, 0), 0.5f);
  field.colliders.back().sensed = true;
  constexpr int kSide = 1000;
  constexpr float kRadius = 0.05f;
  for (int x = 0; x < kSide; ++x)
    for (int z = 0; z < kSide; ++z)
      field.add({0.104f * static_cast<float>(x - kSide / 2), kRadius,
                 0.104f * static_cast<float>(z - kSide / 2)},
                kRadius, {1000, 0.5f, 0.05f, 0});
  std::vector<GrainRest> rest(field.grain.size());
  std::vector<double> ms;
  const auto step = [&](RowsAre rows) {
    rest.resize(field.grain.size());
    const GrainRows all{field.entity,   field.grain,    field.velocity, field.spin, field.orientation,
                        field.previous, field.material, rest};
    const auto begin = std::chrono::steady_clock::now();
    field.solver.step(std::span(&all, 1), field.colliders, field.parameters, rows);
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                     .count());
  };
  const GrainStats& stats = field.solver.stats();
  for (int tick = 0; tick < 60 && stats.asleep < field.grain.size(); ++tick) step(RowsAre::AsLeft);
  ASSERT_EQ(stats.asleep, field.grain.size());
  double mass = 0;
  for (size_t k = 0; k < field.grain.size(); ++k) mass += field.mass(k);
  step(RowsAre::AsLeft);
  EXPECT_EQ(stats.visited, 0u);
  EXPECT_EQ(stats.rebuilds, 0u);
  EXPECT_NEAR(-field.colliders[0].load.y * 60 / 9.81 / mass, 1, 1e-3);

  for (int k = 0; k < 5; ++k)
    field.add({7.0f * static_cast<float>(k), 1, 3}, kRadius, {1000, 0.5f, 0.05f, 0});
  step(RowsAre::Unknown);
  ms.clear();
  for (int tick = 0; tick < 200; ++tick) {
    step(RowsAre::AsLeft);
    ASSERT_LT(stats.visited, 500u) << tick;
  }
  std::sort(ms.begin(), ms.end());
  EXPECT_GT(stats.asleep, field.grain.size() - 300);
  std::printf("a tick with 5 grains falling on 1,000,000 at rest: %.3f ms, median of 200\n",
              ms[ms.size() / 2]);
}

}  // namespace
}  // namespace scree::grains::test

// Instruction sets: the same bits from each.
#include <gtest/gtest.h>

#include "engine/core/parallel.h"
#include "tests/grains/field.h"

namespace scree::grains::test {
namespace {

// The hash of every tick of a pour, summed.
uint64_t hashOf(Lanes lanes, GrainMaterial material, float radius_jitter) {
  Field field;
  field.parameters.lanes = lanes;
  pour(field, 9, 10, 0.05f, 41, radius_jitter, material);
  for (Collider& c : field.colliders) c.restitution = material.restitution;
  uint64_t sum = 0;
  for (int tick = 0; tick < 100; ++tick) {
    field.step();
    sum = hashCombine(sum, field.hash());
  }
  return sum;
}

TEST(Lanes, WideAndBaselineGiveTheSameBits) {
  if (wideKernels() == nullptr) GTEST_SKIP() << "no wider set on this machine";
  for (const GrainMaterial material : {GrainMaterial{1000, 0.5f, 0, 0}, {1000, 0.5f, 0.02f, 0},
                                       {1000, 0.4f, 0.02f, 0.6f}})
    for (const float jitter : {0.0f, 0.7f})
      EXPECT_EQ(hashOf(Lanes::Widest, material, jitter), hashOf(Lanes::Baseline, material, jitter))
          << "rolling friction " << material.rolling_friction << ", restitution "
          << material.restitution << ", radius jitter " << jitter;
}

TEST(Lanes, CoincidentCentresToo) {
  if (wideKernels() == nullptr) GTEST_SKIP() << "no wider set on this machine";
  uint64_t want = 0;
  for (const Lanes lanes : {Lanes::Widest, Lanes::Baseline}) {
    Field field;
    field.parameters.lanes = lanes;
    field.parameters.gravity = vec3(0);
    for (int k = 0; k < 300; ++k) field.add({1, 2, 3}, 0.05f, {1000, 0.3f, 0, 0.5f});
    field.step(20);
    if (lanes == Lanes::Widest) want = field.hash();
    EXPECT_EQ(field.hash(), want);
  }
}

}  // namespace
}  // namespace scree::grains::test
